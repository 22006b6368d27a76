//! [`LinearSolver::Direct`](crate::LinearSolver): sparse Cholesky in `f64`.

use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem};
use crate::cholesky::CholeskyError;
use crate::newton::NewtonFailure;

/// Factors every matrix; the memory of the factor is the solver's own.
pub(super) struct Direct;

impl<const D: usize> DescentDirection<D> for Direct {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        solve(system, dx)
    }
}

pub(super) fn solve<const D: usize>(
    system: &mut NewtonSystem<'_, D>,
    dx: &mut [f64],
) -> Result<Descent, NewtonFailure> {
    let matrix = system.tangent.assembled()?;
    let outcome = match system.factorizer.factor(matrix) {
        Ok(factor) => {
            for (dx, g) in dx.iter_mut().zip(system.gradient) {
                *dx = -g;
            }
            factor.solve_in_place(dx);
            DescentOutcome::Found
        }
        Err(CholeskyError::NotPositiveDefinite { .. }) => DescentOutcome::Indefinite,
        Err(error) => return Err(error.into()),
    };
    Ok(Descent::factored(outcome))
}
