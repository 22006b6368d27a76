//! Collisions as penalty forces (document 000, 5.7).

use crate::builder::{AssemblyBuilder, UNIT_TOLERANCE};
use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::Mat;
use fem_materials::HessianProjection;
use std::ops::Range;

/// What nodes may not enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle<const D: usize> {
    /// A ball.
    Sphere {
        /// Center, meters.
        center: [f64; D],
        /// Radius, meters.
        radius: f64,
    },
    /// Everything behind a plane.
    HalfSpace {
        /// A point of the plane, meters.
        point: [f64; D],
        /// Unit normal; points out of the obstacle.
        normal: [f64; D],
    },
}

/// A node inside an obstacle.
struct Contact<const D: usize> {
    depth: f64,
    normal: [f64; D],
    /// 1/r of the surface through the node: the normal turns when the node slides.
    curvature: f64,
}

impl<const D: usize> Obstacle<D> {
    fn contact(&self, x: &[f64; D]) -> Option<Contact<D>> {
        match self {
            Self::Sphere { center, radius } => {
                let offset: [f64; D] = core::array::from_fn(|k| x[k] - center[k]);
                let distance = offset.iter().map(|c| c * c).sum::<f64>().sqrt();
                let depth = radius - distance;
                // NaN goes on as a contact, into the energy.
                if depth <= 0.0 {
                    return None;
                }
                // At the very center every direction leads out; the first axis is taken.
                let normal = core::array::from_fn(|k| {
                    if distance > 0.0 {
                        offset[k] / distance
                    } else {
                        f64::from(k == 0)
                    }
                });
                let curvature = if distance > 0.0 { 1.0 / distance } else { 0.0 };
                Some(Contact {
                    depth,
                    normal,
                    curvature,
                })
            }
            Self::HalfSpace { point, normal } => {
                let depth = -(0..D).map(|k| normal[k] * (x[k] - point[k])).sum::<f64>();
                (depth > 0.0 || depth.is_nan()).then_some(Contact {
                    depth,
                    normal: *normal,
                    curvature: 0.0,
                })
            }
        }
    }
}

/// Nodes that an obstacle pushes out with the force ε · depth · normal; energy ε/2 depth².
#[derive(Clone, Debug, PartialEq)]
pub struct Penalty<const D: usize> {
    /// The nodes that are tested.
    pub nodes: Vec<usize>,
    /// ε, newtons per meter of depth.
    pub stiffness: f64,
    /// What they may not enter.
    pub obstacle: Obstacle<D>,
}

impl<const D: usize> Penalty<D> {
    /// Names the first number that no contact can be computed with; `index` is the term's.
    pub(crate) fn check(&self, index: usize) -> Result<(), AssemblyError> {
        let require = |holds: bool, what, value, needed| {
            let error = AssemblyError::UnusablePenalty {
                index,
                what,
                value,
                needed,
            };
            if holds { Ok(()) } else { Err(error) }
        };
        let finite = |place: &[f64; D], what| {
            let bad = place.iter().find(|x| !x.is_finite());
            bad.map_or(Ok(()), |&x| require(false, what, x, "finite"))
        };
        let positive = |what, x: f64| {
            let holds = x > 0.0 && x.is_finite();
            require(holds, what, x, "finite and greater than 0")
        };
        positive("the stiffness", self.stiffness)?;
        match &self.obstacle {
            Obstacle::Sphere { center, radius } => {
                finite(center, "a coordinate of the center")?;
                positive("the radius", *radius)
            }
            Obstacle::HalfSpace { point, normal } => {
                finite(point, "a coordinate of the point")?;
                let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
                let unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
                require(unit, "the length of the normal", length, "1")
            }
        }
    }

    fn contact(&self, at: Configuration<D>, stencil: usize) -> Option<Contact<D>> {
        self.obstacle.contact(&at.positions()[self.nodes[stencil]])
    }

    fn energy_of(&self, contact: &Contact<D>) -> f64 {
        0.5 * self.stiffness * contact.depth * contact.depth
    }

    /// ∂²/∂x² of ε/2 depth²: ε n nᵀ − ε depth/r (I − n nᵀ). The second part is negative: a projection
    /// clamps or reflects it, which is exact because the two parts act on orthogonal directions.
    fn stiffness_block(&self, contact: &Contact<D>, projection: HessianProjection) -> Mat<f64, D> {
        let along = Mat::outer(contact.normal, contact.normal);
        let sliding = -contact.depth * contact.curvature;
        let sliding = match projection {
            HessianProjection::None => sliding,
            HessianProjection::Clamp => sliding.max(0.0),
            HessianProjection::Absolute => sliding.abs(),
        };
        (along + (Mat::identity() - along).scale(sliding)).scale(self.stiffness)
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
            sink.energy(s, contact.map_or(0.0, |c| self.energy_of(&c)));
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        for s in stencils {
            let Some(contact) = self.contact(at, s) else {
                continue;
            };
            sink.energy(s, self.energy_of(&contact));
            let push = self.stiffness * contact.depth;
            sink.add(s, 0, contact.normal.map(|n| -(push * n)));
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
            if let Some(contact) = self.contact(at, s) {
                sink.add(s, 0, 0, self.stiffness_block(&contact, projection).0);
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
            obstacle: Obstacle::Sphere { center, radius },
        }
    }

    fn plane(point: [f64; 2], normal: [f64; 2]) -> Penalty<2> {
        Penalty {
            nodes: vec![0],
            stiffness: 1.0,
            obstacle: Obstacle::HalfSpace { point, normal },
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
