//! Collisions as penalty forces (document 000, 5.7).

use crate::builder::AssemblyBuilder;
use crate::configuration::Configuration;
use crate::direction::UNIT_TOLERANCE;
use crate::error::AssemblyError;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::{ImplicitSurface, Mat, UnusableSurface};
use fem_materials::HessianProjection;
use std::ops::Range;

/// Nodes that an obstacle pushes out with the force ε · depth · normal, the depth being −φ; energy ε/2 depth².
#[derive(Clone, Debug, PartialEq)]
pub struct Penalty<const D: usize> {
    /// The nodes that are tested.
    pub nodes: Vec<usize>,
    /// ε, newtons per meter of depth.
    pub stiffness: f64,
    /// What they may not enter.
    pub obstacle: ImplicitSurface<D>,
}

impl<const D: usize> Penalty<D> {
    /// Names the first number that no contact can be computed with; `index` is the term's.
    pub(crate) fn check(&self, index: usize) -> Result<(), AssemblyError> {
        let stiff = self.stiffness > 0.0 && self.stiffness.is_finite();
        let stiffness = UnusableSurface {
            what: "the stiffness",
            value: self.stiffness,
            needed: "finite and greater than 0",
        };
        let usable = if stiff {
            self.obstacle.check(UNIT_TOLERANCE)
        } else {
            Err(stiffness)
        };
        usable.map_err(|bad| AssemblyError::UnusablePenalty {
            index,
            what: bad.what,
            value: bad.value,
            needed: bad.needed,
        })
    }

    /// Depth of a node that is inside, and its place.
    fn contact<'a>(&self, at: Configuration<'a, D>, stencil: usize) -> Option<(f64, &'a [f64; D])> {
        let x = &at.positions()[self.nodes[stencil]];
        let depth = -self.obstacle.distance(x);
        // NaN goes on as a contact, into the energy.
        (depth > 0.0 || depth.is_nan()).then_some((depth, x))
    }

    fn energy_of(&self, depth: f64) -> f64 {
        0.5 * self.stiffness * depth * depth
    }

    /// ∂²/∂x² of ε/2 φ²: ε (n nᵀ + φ ∇²φ). The second part is negative: a projection clamps or
    /// reflects it, which is exact because the two parts act on orthogonal directions and the
    /// solids are convex.
    fn stiffness_block(
        &self,
        depth: f64,
        x: &[f64; D],
        projection: HessianProjection,
    ) -> Mat<f64, D> {
        let normal = self.obstacle.normal(x);
        let sliding = projection.eigenvalue(-depth);
        let curved = self.obstacle.curvature(x).scale(sliding);
        (Mat::outer(normal, normal) + curved).scale(self.stiffness)
    }
}

/// Each of the nodes is a stencil.
impl<const D: usize> Term<D> for Penalty<D> {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.nodes.iter().map(|&n| [n]))
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            let contact = self.contact(at, s);
            sink.energy(s, contact.map_or(0.0, |(depth, _)| self.energy_of(depth)));
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        for s in stencils {
            let Some((depth, x)) = self.contact(at, s) else {
                continue;
            };
            sink.energy(s, self.energy_of(depth));
            let push = self.stiffness * depth;
            sink.add(s, 0, self.obstacle.normal(x).map(|n| -(push * n)));
        }
    }
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        for s in stencils {
            if let Some((depth, x)) = self.contact(at, s) {
                sink.add(s, 0, 0, self.stiffness_block(depth, x, projection).0);
            }
        }
    }
}

impl<const D: usize, S: crate::shape::ElementShape<D>> AssemblyBuilder<D, S> {
    /// Adds a penalty against an obstacle (document 000, 5.7).
    ///
    /// # Errors
    /// When one of its nodes does not exist, a number is not finite, the stiffness or the radius is
    /// not positive, or the normal is not of length 1 (to 1e-3).
    pub fn penalty(self, penalty: Penalty<D>) -> Result<Self, AssemblyError> {
        penalty.check(self.terms())?;
        self.term(penalty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(center: [f64; 2], radius: f64, stiffness: f64) -> Penalty<2> {
        Penalty {
            nodes: vec![0],
            stiffness,
            obstacle: ImplicitSurface::Sphere { center, radius },
        }
    }

    fn plane(point: [f64; 2], normal: [f64; 2]) -> Penalty<2> {
        Penalty {
            nodes: vec![0],
            stiffness: 1.0,
            obstacle: ImplicitSurface::HalfSpace { point, normal },
        }
    }

    #[test]
    fn numbers_that_no_contact_can_be_computed_with_are_refused() {
        let nan = f64::NAN;
        for bad in [
            sphere([0.0, nan], 1.0, 1.0),
            sphere([0.0; 2], nan, 1.0),
            sphere([0.0; 2], -1.0, 1.0),
            sphere([0.0; 2], 1.0, nan),
            sphere([0.0; 2], 1.0, -1.0),
            plane([f64::INFINITY, 0.0], [0.0, 1.0]),
            plane([0.0; 2], [0.0, 2.0]),
            plane([0.0; 2], [0.0; 2]),
            plane([0.0; 2], [nan, 1.0]),
        ] {
            let refused = bad.check(3);
            assert!(
                matches!(
                    refused,
                    Err(AssemblyError::UnusablePenalty { index: 3, .. })
                ),
                "{bad:?}: {refused:?}"
            );
        }
        assert_eq!(sphere([0.0; 2], 1.0, 1.0).check(0), Ok(()));
        assert_eq!(plane([0.0; 2], [0.6, 0.8]).check(0), Ok(()));
    }

    #[test]
    fn a_node_that_is_not_a_number_is_no_absence_of_contact() {
        for penalty in [sphere([0.0; 2], 1.0, 1.0), plane([0.0; 2], [0.0, 1.0])] {
            let energy = |x: [f64; 2]| {
                let mut energies = [f64::INFINITY];
                let mut sink = EnergySink {
                    first: 0,
                    scale: 1.0,
                    energies: &mut energies,
                };
                penalty.energy(Configuration::trusted(&[x], &[]), 0..1, &mut sink);
                energies[0]
            };
            assert!(energy([0.0, f64::NAN]).is_nan());
            assert_eq!(energy([0.0, 2.0]), 0.0);
        }
    }
}
