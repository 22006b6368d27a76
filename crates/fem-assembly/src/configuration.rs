//! Where an energy is evaluated: positions and controls, checked once.

use crate::error::AssemblyError;

/// Positions of all nodes (meters) and values of all controls, of the right lengths and finite.
///
/// A control is a number in which the energy is affine while the other controls stand still: the
/// activation of a muscle (unitless), the factor of a [`Scaled`](crate::Scaled) load, the pressure of a
/// [`Cavity`](crate::Cavity). [`Assembly::configuration`](crate::Assembly::configuration)
/// makes one; it borrows and is cheap to copy.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a, const D: usize> {
    positions: &'a [[f64; D]],
    controls: &'a [f64],
}

impl<'a, const D: usize> Configuration<'a, D> {
    pub(crate) fn checked(
        positions: &'a [[f64; D]],
        controls: &'a [f64],
        (nodes, expected): (usize, usize),
    ) -> Result<Self, AssemblyError> {
        let lengths = [
            ("positions", positions.len(), nodes),
            ("controls", controls.len(), expected),
        ];
        for (what, found, expected) in lengths {
            if found != expected {
                return Err(AssemblyError::WrongLength {
                    what,
                    found,
                    expected,
                });
            }
        }
        let not_finite = |what, index| Err(AssemblyError::NotFinite { what, index });
        let infinite = |p: &[f64; D]| p.iter().any(|c| !c.is_finite());
        if let Some(index) = positions.iter().position(infinite) {
            return not_finite("the position of node", index);
        }
        match controls.iter().position(|c| !c.is_finite()) {
            Some(index) => not_finite("control", index),
            None => Ok(Self::trusted(positions, controls)),
        }
    }

    /// For lengths that were checked before. A solver may try numbers that are not finite; they
    /// become an infinite energy.
    pub(crate) fn trusted(positions: &'a [[f64; D]], controls: &'a [f64]) -> Self {
        Self {
            positions,
            controls,
        }
    }

    /// Position of every node, meters.
    #[inline(always)]
    pub fn positions(&self) -> &'a [[f64; D]] {
        self.positions
    }
    /// Value of every control.
    #[inline(always)]
    pub fn controls(&self) -> &'a [f64] {
        self.controls
    }
}
