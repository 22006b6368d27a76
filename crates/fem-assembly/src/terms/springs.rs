//! Springs from points of the body to points in space.

use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::Mat;
use fem_materials::HessianProjection;
use std::ops::Range;

/// A spring of rest length 0 from a point of the body to a point in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring<const D: usize, const V: usize> {
    /// The nodes that carry the point; they must differ.
    pub nodes: [usize; V],
    /// Their shares in it: the point is Σ wₐ xₐ.
    pub weights: [f64; V],
    /// Where the spring ends, meters.
    pub anchor: [f64; D],
    /// k, newtons per meter.
    pub stiffness: f64,
}

/// Springs: E = Σ k/2 |Σₐ wₐ xₐ − p|², joules. V is 1 for springs at nodes and D + 1 for springs at
/// points embedded in an element.
#[derive(Clone, Debug, PartialEq)]
pub struct Springs<const D: usize, const V: usize>(Vec<Spring<D, V>>);

impl<const D: usize> Springs<D, 1> {
    /// Springs of one stiffness (N/m) from nodes to points.
    ///
    /// # Errors
    /// As [`Springs::new`].
    pub fn at_nodes(
        ends: impl IntoIterator<Item = (usize, [f64; D])>,
        stiffness: f64,
    ) -> Result<Self, AssemblyError> {
        let spring = |(node, anchor)| Spring {
            nodes: [node],
            weights: [1.0],
            anchor,
            stiffness,
        };
        Self::new(ends.into_iter().map(spring).collect())
    }
}

impl<const D: usize, const V: usize> Springs<D, V> {
    /// Checks them.
    ///
    /// # Errors
    /// When a number of a spring is not finite or its stiffness is negative.
    pub fn new(springs: Vec<Spring<D, V>>) -> Result<Self, AssemblyError> {
        for (index, spring) in springs.iter().enumerate() {
            let mut numbers = spring.weights.iter().chain(&spring.anchor);
            if !(spring.stiffness.is_finite() && numbers.all(|n| n.is_finite())) {
                let what = "a number of spring";
                return Err(AssemblyError::NotFinite { what, index });
            }
            if spring.stiffness < 0.0 {
                let factor = spring.stiffness;
                return Err(AssemblyError::NegativeStiffness { index, factor });
            }
        }
        Ok(Self(springs))
    }

    /// Σ wₐ xₐ − p.
    fn stretch(&self, at: Configuration<D>, stencil: usize) -> [f64; D] {
        let spring = &self.0[stencil];
        let carried = spring.nodes.iter().zip(&spring.weights);
        carried.fold(spring.anchor.map(|p| -p), |mut d, (&node, w)| {
            (0..D).for_each(|i| d[i] += w * at.positions()[node][i]);
            d
        })
    }

    fn energy_of(&self, stencil: usize, stretch: [f64; D]) -> f64 {
        0.5 * self.0[stencil].stiffness * stretch.iter().map(|c| c * c).sum::<f64>()
    }
}

impl<const D: usize, const V: usize> Term<D> for Springs<D, V> {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.0.iter().map(|spring| spring.nodes))
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            sink.energy(s, self.energy_of(s, self.stretch(at, s)));
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        for s in stencils {
            let stretch = self.stretch(at, s);
            sink.energy(s, self.energy_of(s, stretch));
            let Spring {
                weights, stiffness, ..
            } = &self.0[s];
            for (a, w) in weights.iter().enumerate() {
                sink.add(s, a, stretch.map(|d| stiffness * w * d));
            }
        }
    }
    /// k wₐ w_b I, positive semidefinite whatever is asked for.
    fn hessian(
        &self,
        _: Configuration<D>,
        _: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        for s in stencils {
            let Spring {
                weights, stiffness, ..
            } = &self.0[s];
            for a in 0..V {
                for b in 0..=a {
                    let block =
                        Mat::<f64, D>::identity().scale(stiffness * weights[a] * weights[b]);
                    sink.add(s, a, b, block.0);
                }
            }
        }
    }
}
