//! Where an energy is evaluated: positions and controls, checked once.

use crate::error::{AssemblyError, check_length};

/// Positions of all nodes (meters), as many as the assembly has and finite: where a question is one of
/// geometry alone. [`Assembly::positions`](crate::Assembly::positions) makes them, and every
/// [`Configuration`] has them.
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a, const D: usize>(&'a [[f64; D]]);

impl<'a, const D: usize> Positions<'a, D> {
    pub(crate) fn checked(
        positions: &'a [[f64; D]],
        expected: usize,
    ) -> Result<Self, AssemblyError> {
        check_length("positions", positions.len(), expected)?;
        let infinite = |p: &[f64; D]| p.iter().any(|c| !c.is_finite());
        match positions.iter().position(infinite) {
            None => Ok(Self(positions)),
            Some(index) => Err(AssemblyError::NotFinite {
                what: "the position of node",
                index,
            }),
        }
    }

    /// Position of every node, meters.
    #[inline(always)]
    pub fn as_slice(&self) -> &'a [[f64; D]] {
        self.0
    }
}

impl<'a, const D: usize> From<Configuration<'a, D>> for Positions<'a, D> {
    fn from(at: Configuration<'a, D>) -> Self {
        at.positions
    }
}

/// Positions of all nodes (meters) and values of all controls, of the right lengths and finite.
///
/// A control is a number in which the energy is affine while the other controls stand still: the
/// activation of a muscle (unitless), the factor of a [`Scaled`](crate::Scaled) load, the pressure of a
/// [`Cavity`](crate::Cavity). [`Assembly::configuration`](crate::Assembly::configuration)
/// makes one; it borrows and is cheap to copy.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a, const D: usize> {
    positions: Positions<'a, D>,
    controls: &'a [f64],
}

impl<'a, const D: usize> Configuration<'a, D> {
    pub(crate) fn checked(
        positions: &'a [[f64; D]],
        controls: &'a [f64],
        (nodes, expected): (usize, usize),
    ) -> Result<Self, AssemblyError> {
        let positions = Positions::checked(positions, nodes)?;
        check_length("controls", controls.len(), expected)?;
        match controls.iter().position(|c| !c.is_finite()) {
            Some(index) => Err(AssemblyError::NotFinite {
                what: "control",
                index,
            }),
            None => Ok(Self {
                positions,
                controls,
            }),
        }
    }

    /// For lengths that were checked before. A solver may try numbers that are not finite; they
    /// become an infinite energy.
    pub(crate) fn trusted(positions: &'a [[f64; D]], controls: &'a [f64]) -> Self {
        Self {
            positions: Positions(positions),
            controls,
        }
    }

    /// Position of every node, meters.
    #[inline(always)]
    pub fn positions(&self) -> &'a [[f64; D]] {
        self.positions.as_slice()
    }
    /// Value of every control.
    #[inline(always)]
    pub fn controls(&self) -> &'a [f64] {
        self.controls
    }
}

#[cfg(test)]
mod tests {
    use super::{Configuration, Positions};
    use crate::error::AssemblyError;

    const X: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

    #[test]
    fn positions_are_as_many_as_nodes_and_finite() {
        assert_eq!(Positions::checked(&X, 3).unwrap().as_slice(), X);
        for count in [2, 4] {
            let error = Positions::checked(&X, count).unwrap_err();
            let wrong = AssemblyError::WrongLength {
                what: "positions",
                found: 3,
                expected: count,
            };
            assert_eq!(error, wrong);
        }
        for number in [f64::NAN, f64::INFINITY] {
            let mut x = X;
            x[1][1] = number;
            let error = Positions::checked(&x, 3).unwrap_err();
            assert!(
                matches!(error, AssemblyError::NotFinite { index: 1, .. }),
                "{error}"
            );
        }
    }

    #[test]
    fn a_configuration_refuses_what_positions_refuse_and_wrong_controls() {
        let at = Configuration::checked(&X, &[0.5], (3, 1)).unwrap();
        assert_eq!(Positions::from(at).as_slice(), X);
        for (nodes, controls) in [(4, [0.5]), (3, [f64::NAN])] {
            assert!(Configuration::checked(&X, &controls, (nodes, 1)).is_err());
        }
        let error = Configuration::checked(&X, &[], (3, 1)).unwrap_err();
        let wrong = AssemblyError::WrongLength {
            what: "controls",
            found: 0,
            expected: 1,
        };
        assert_eq!(error, wrong);
    }
}
