//! Muscle fibers over a mesh, each in its own element, direction and activation channel.

use crate::block::LANES;
use crate::builder::{AssemblyBuilder, Entry, Packing};
use crate::error::AssemblyError;
use crate::law::Law;
use crate::part::{Elements, Part};
use fem_kinematics::{F64x8, Lanes, Mat, Pack, Tensor4};
use fem_materials::curves::TensionCurve;
use fem_materials::{FiberLaw, FiberTerm, HessianProjection};

/// One fiber family in one element. An element may carry several; their energies add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fiber {
    /// The element.
    pub element: usize,
    /// The activation channel (the muscle).
    pub channel: usize,
    /// Direction in the rest shape, of length 1 (to 1e-3; used as given); its sign means nothing.
    pub direction: [f64; 3],
    /// σ_max times the muscle's share of the element, pascals.
    pub peak: f64,
    /// λ_ofl, the stretch at which the active tension peaks.
    pub optimal_stretch: f64,
}

/// How far from 1 the length of a direction may be.
pub(crate) const UNIT_TOLERANCE: f64 = 1e-3;

impl AssemblyBuilder<3> {
    /// Adds fibers of one tension curve. `channels` is the number of activations that an
    /// evaluation will be given; every fiber names one of them.
    ///
    /// # Errors
    /// Names the fiber whose element or channel does not exist, or whose numbers are unusable.
    pub fn fibers<C>(
        mut self,
        law: FiberLaw<C>,
        channels: usize,
        fibers: &[Fiber],
    ) -> Result<Self, AssemblyError>
    where
        C: TensionCurve + Clone + 'static,
    {
        for (index, fiber) in fibers.iter().enumerate() {
            let length = fiber.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            let unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
            if !unit {
                let element = fiber.element;
                return Err(AssemblyError::NoDirection {
                    index,
                    element,
                    length,
                });
            }
            if !(fiber.peak.is_finite() && fiber.optimal_stretch > 0.0) {
                return Err(AssemblyError::NotFinite {
                    what: "peak or optimal stretch of fiber",
                    index,
                });
            }
            if fiber.channel >= channels {
                let (found, expected) = (channels, fiber.channel + 1);
                return Err(AssemblyError::WrongLength {
                    what: "activations",
                    found,
                    expected,
                });
            }
        }
        let elements: Vec<usize> = fibers.iter().map(|f| f.element).collect();
        let element_of_entry = self.existing(&elements)?;
        let fibers = fibers.to_vec();
        let pack = Box::new(
            move |entries: &[Entry], packing: &Packing<3>| -> Box<dyn Part<3>> {
                let lanes = entries
                    .chunks(LANES)
                    .map(|group| FiberLanes::pack(group, &fibers));
                let law = Fibers {
                    law: law.clone(),
                    lanes: lanes.collect(),
                };
                Box::new(Elements::pack(law, entries, packing))
            },
        );
        self.add_layer(element_of_entry, channels, pack);
        Ok(self)
    }
}

/// The fibers of a part, in the order of its blocks.
struct Fibers<C> {
    law: FiberLaw<C>,
    lanes: Vec<FiberLanes>,
}

/// Eight fibers side by side.
struct FiberLanes {
    direction: [F64x8; 3],
    peak: F64x8,
    optimal_stretch: F64x8,
    channel: [usize; LANES],
}

impl FiberLanes {
    fn pack(group: &[Entry], fibers: &[Fiber]) -> Self {
        let at = |lane: usize| &fibers[group[lane.min(group.len() - 1)].index as usize];
        let lanes = |value: &dyn Fn(&Fiber) -> f64| Lanes(std::array::from_fn(|l| value(at(l))));
        Self {
            direction: std::array::from_fn(|i| lanes(&|f| f.direction[i])),
            peak: lanes(&|f| f.peak),
            optimal_stretch: lanes(&|f| f.optimal_stretch),
            channel: std::array::from_fn(|l| at(l).channel),
        }
    }

    #[inline(always)]
    fn term<V: Pack>(&self, activation: V) -> FiberTerm<V> {
        FiberTerm {
            direction: self.direction.map(V::from_lanes),
            peak: V::from_lanes(self.peak),
            activation,
            optimal_stretch: V::from_lanes(self.optimal_stretch),
        }
    }

    #[inline(always)]
    fn active<V: Pack>(&self, activations: &[f64]) -> FiberTerm<V> {
        let lanes = std::array::from_fn(|l| activations[self.channel[l]]);
        self.term(V::from_lanes(Lanes(lanes)))
    }
}

impl<C: TensionCurve> Law<3> for Fibers<C> {
    #[inline(always)]
    fn energy<V: Pack>(&self, block: usize, activations: &[f64], F: &Mat<V, 3>) -> V {
        self.lanes[block].active(activations).energy(&self.law, F)
    }
    #[inline(always)]
    fn energy_and_stress<V: Pack>(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<V, 3>,
    ) -> (V, Mat<V, 3>) {
        self.lanes[block]
            .active(activations)
            .energy_and_stress(&self.law, F)
    }
    #[inline(always)]
    fn stress_differential<V: Pack>(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<V, 3>,
        dF: &Mat<V, 3>,
    ) -> Mat<V, 3> {
        self.lanes[block]
            .active(activations)
            .stress_differential(&self.law, F, dF)
    }
    #[inline(always)]
    fn derivative<V: Pack>(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<V, 3>,
    ) -> Tensor4<V, 3> {
        self.lanes[block]
            .active(activations)
            .stress_derivative(&self.law, F)
    }
    #[inline(never)]
    fn filtered_derivative(
        &self,
        (block, lane): (usize, usize),
        activations: &[f64],
        F: &Mat<f64, 3>,
        filter: HessianProjection,
    ) -> Tensor4<f64, 3> {
        let fibers = &self.lanes[block];
        let term = FiberTerm {
            direction: fibers.direction.map(|d| d.0[lane]),
            peak: fibers.peak.0[lane],
            activation: activations[fibers.channel[lane]],
            optimal_stretch: fibers.optimal_stretch.0[lane],
        };
        term.filtered_derivative(&self.law, F, filter)
    }
    #[inline(always)]
    fn has_channel(&self, block: usize, channel: usize) -> bool {
        self.lanes[block].channel.contains(&channel)
    }
    #[inline(always)]
    fn stress_by_activation<V: Pack>(
        &self,
        block: usize,
        channel: usize,
        F: &Mat<V, 3>,
    ) -> Mat<V, 3> {
        let fibers = &self.lanes[block];
        let listens = fibers.channel.map(|c| f64::from(c == channel));
        fibers
            .term(V::zero())
            .stress_by_activation(&self.law, F)
            .scale(V::from_lanes(Lanes(listens)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dofs::Dofs;
    use fem_materials::curves::PhysBam;

    #[test]
    fn a_direction_that_is_no_unit_vector_is_refused() {
        let mesh = crate::mesh::kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
        let built = |direction| {
            let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &[0]).unwrap();
            let fiber = Fiber {
                element: 0,
                channel: 0,
                direction,
                peak: 1e5,
                optimal_stretch: 1.0,
            };
            AssemblyBuilder::new(&mesh, dofs)
                .unwrap()
                .fibers(FiberLaw::<PhysBam>::default(), 1, &[fiber])
                .map(|_| ())
        };
        for bad in [
            [0.0; 3],
            [0.6, 0.0, 0.81],
            [2.0, 0.0, 0.0],
            [f64::NAN, 1.0, 0.0],
        ] {
            let refused = built(bad);
            assert!(
                matches!(refused, Err(AssemblyError::NoDirection { index: 0, .. })),
                "{bad:?}: {refused:?}"
            );
        }
        assert_eq!(built([0.6, 0.0, -0.8004]), Ok(()));
    }
}
