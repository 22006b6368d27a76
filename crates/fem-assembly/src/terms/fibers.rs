//! Muscle fibers over a mesh, each in its own element and direction, activated by a control.

use crate::builder::AssemblyBuilder;
use crate::direction::UNIT_TOLERANCE;
use crate::element_group::{ElementGroup, Entry};
use crate::error::AssemblyError;
use crate::shape::ElementShape;
use fem_materials::curves::TensionCurve;
use fem_materials::{FiberLaw, FiberTerm};

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

impl<S: ElementShape<3>> AssemblyBuilder<3, S> {
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
        let of = |entry: Entry| {
            let fiber = &fibers[entry.index as usize];
            FiberTerm {
                direction: fiber.direction,
                max_isometric_stress: fiber.max_isometric_stress,
                optimal_stretch: fiber.optimal_stretch,
                activation: 0.0,
            }
        };
        let control = |entry: Entry| fibers[entry.index as usize].control;
        let group = ElementGroup::<3, S, _>::pack(law, &entries, self.elements(), of)
            .controlled(&entries, controls, control)
            .lifted(self.threshold());
        self.term(group)
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
