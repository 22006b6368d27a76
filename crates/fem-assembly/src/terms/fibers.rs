//! Muscle fibers over a mesh, each in its own element and direction, activated by a control.

use crate::builder::{AssemblyBuilder, UNIT_TOLERANCE};
use crate::element::LANES;
use crate::element_group::{ElementGroup, Entry};
use crate::error::AssemblyError;
use crate::law::Law;
use fem_kinematics::{F64x8, Lanes, Mat, Pack, Tensor4};
use fem_materials::curves::TensionCurve;
use fem_materials::{FiberLaw, FiberTerm, HessianProjection};

/// One fiber family in one element. An element may carry several; their energies add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fiber {
    /// The element.
    pub element: usize,
    /// The control that is its activation (the muscle).
    pub control: usize,
    /// Direction in the rest shape, of length 1 (to 1e-3; used as given); its sign means nothing.
    pub direction: [f64; 3],
    /// σ_max times the muscle's share of the element, pascals.
    pub max_isometric_stress: f64,
    /// λ_ofl, the stretch at which the active tension peaks.
    pub optimal_stretch: f64,
}

impl AssemblyBuilder<3> {
    /// Adds fibers of one tension curve. `controls` is the number of controls that an evaluation
    /// will be given at least; every fiber names one of them as its activation.
    ///
    /// # Errors
    /// Names the fiber whose element or control does not exist, or whose numbers are unusable.
    pub fn fibers<C>(
        self,
        law: FiberLaw<C>,
        controls: usize,
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
            if !(fiber.max_isometric_stress.is_finite() && fiber.optimal_stretch > 0.0) {
                return Err(AssemblyError::NotFinite {
                    what: "maximal isometric stress or optimal stretch of fiber",
                    index,
                });
            }
            if fiber.control >= controls {
                let (found, expected) = (controls, fiber.control + 1);
                return Err(AssemblyError::WrongLength {
                    what: "controls",
                    found,
                    expected,
                });
            }
        }
        let elements: Vec<usize> = fibers.iter().map(|f| f.element).collect();
        let entries = self.entries(&elements)?;
        let lanes = entries
            .chunks(LANES)
            .map(|group| FiberLanes::pack(group, fibers));
        let law = Fibers {
            law,
            lanes: lanes.collect(),
            controls,
        };
        let group = ElementGroup::pack(law, &entries, self.elements());
        self.term(group)
    }
}

/// Fibers in the order of the batches of their group.
struct Fibers<C> {
    law: FiberLaw<C>,
    lanes: Vec<FiberLanes>,
    controls: usize,
}

/// Eight fibers side by side.
struct FiberLanes {
    direction: [F64x8; 3],
    max_isometric_stress: F64x8,
    optimal_stretch: F64x8,
    control: [usize; LANES],
}

impl FiberLanes {
    fn pack(group: &[Entry], fibers: &[Fiber]) -> Self {
        let at = |lane: usize| &fibers[group[lane.min(group.len() - 1)].index as usize];
        let lanes = |value: &dyn Fn(&Fiber) -> f64| Lanes(std::array::from_fn(|l| value(at(l))));
        Self {
            direction: std::array::from_fn(|i| lanes(&|f| f.direction[i])),
            max_isometric_stress: lanes(&|f| f.max_isometric_stress),
            optimal_stretch: lanes(&|f| f.optimal_stretch),
            control: std::array::from_fn(|l| at(l).control),
        }
    }

    #[inline(always)]
    fn term<V: Pack>(&self, activation: V) -> FiberTerm<V> {
        FiberTerm {
            direction: self.direction.map(V::from_lanes),
            max_isometric_stress: V::from_lanes(self.max_isometric_stress),
            activation,
            optimal_stretch: V::from_lanes(self.optimal_stretch),
        }
    }

    #[inline(always)]
    fn active<V: Pack>(&self, controls: &[f64]) -> FiberTerm<V> {
        let lanes = std::array::from_fn(|l| controls[self.control[l]]);
        self.term(V::from_lanes(Lanes(lanes)))
    }
}

impl<C: TensionCurve> Law<3> for Fibers<C> {
    fn controls(&self) -> usize {
        self.controls
    }
    #[inline(always)]
    fn energy<V: Pack>(&self, batch: usize, controls: &[f64], F: &Mat<V, 3>) -> V {
        self.lanes[batch].active(controls).energy(&self.law, F)
    }
    #[inline(always)]
    fn energy_and_stress<V: Pack>(
        &self,
        batch: usize,
        controls: &[f64],
        F: &Mat<V, 3>,
    ) -> (V, Mat<V, 3>) {
        self.lanes[batch]
            .active(controls)
            .energy_and_stress(&self.law, F)
    }
    #[inline(always)]
    fn stress_differential<V: Pack>(
        &self,
        batch: usize,
        controls: &[f64],
        F: &Mat<V, 3>,
        dF: &Mat<V, 3>,
    ) -> Mat<V, 3> {
        self.lanes[batch]
            .active(controls)
            .stress_differential(&self.law, F, dF)
    }
    #[inline(always)]
    fn derivative<V: Pack>(&self, batch: usize, controls: &[f64], F: &Mat<V, 3>) -> Tensor4<V, 3> {
        self.lanes[batch]
            .active(controls)
            .stress_derivative(&self.law, F)
    }
    #[inline(never)]
    fn filtered_derivative(
        &self,
        (batch, lane): (usize, usize),
        controls: &[f64],
        F: &Mat<f64, 3>,
        filter: HessianProjection,
    ) -> Tensor4<f64, 3> {
        let fibers = &self.lanes[batch];
        let term = FiberTerm {
            direction: fibers.direction.map(|d| d.0[lane]),
            max_isometric_stress: fibers.max_isometric_stress.0[lane],
            activation: controls[fibers.control[lane]],
            optimal_stretch: fibers.optimal_stretch.0[lane],
        };
        term.filtered_derivative(&self.law, F, filter)
    }
    #[inline(always)]
    fn has_control(&self, batch: usize, control: usize) -> bool {
        self.lanes[batch].control.contains(&control)
    }
    #[inline(always)]
    fn stress_by_control<V: Pack>(&self, batch: usize, control: usize, F: &Mat<V, 3>) -> Mat<V, 3> {
        let fibers = &self.lanes[batch];
        let listens = fibers.control.map(|c| f64::from(c == control));
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
                control: 0,
                direction,
                max_isometric_stress: 1e5,
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
