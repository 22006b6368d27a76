//! [`LinearSolver::Pcg`](crate::LinearSolver): conjugate gradients, with or without a matrix.

use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem};
use crate::newton::NewtonFailure;
use crate::operator::{AssumedPositiveDefinite, MatrixPreconditioner, Preconditioner};
use crate::pcg::{PcgError, PcgParams, pcg};
use crate::preconditioner::PreconditionerError;

/// Conjugate gradients with any preconditioner that follows the tangent.
#[derive(Clone, Debug)]
pub struct PcgDirection<P> {
    preconditioner: P,
    max_iterations: usize,
}

impl<P> PcgDirection<P> {
    /// At most `max_iterations` in each step before a factorization takes over.
    pub fn new(preconditioner: P, max_iterations: usize) -> Self {
        Self {
            preconditioner,
            max_iterations,
        }
    }

    pub(super) fn set_budget(&mut self, max_iterations: usize) {
        self.max_iterations = max_iterations;
    }
}

impl<P: MatrixPreconditioner<D> + Send + Sync, const D: usize> DescentDirection<D>
    for PcgDirection<P>
{
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let tangent = system.tangent();
        let updated = match tangent.matrix() {
            Some(matrix) => self.preconditioner.update(matrix),
            None => self.preconditioner.update_products(&tangent),
        };
        match updated {
            Ok(()) => {}
            Err(
                error @ (PreconditionerError::NonFinite { .. }
                | PreconditionerError::NearKernel(_)
                | PreconditionerError::Coarse(_)
                | PreconditionerError::NeedsMatrix),
            ) => return Err(error.into()),
            // Without a definite preconditioner the matrix is indefinite or nearly so.
            Err(_) => return Ok(Descent::iterated(DescentOutcome::Indefinite, 0)),
        }
        iterate(
            system,
            &self.preconditioner,
            system.forcing,
            self.max_iterations,
            dx,
        )
    }
}

/// Conjugate gradients on trust, from zero; the verdict on what they met.
pub(super) fn iterate<const D: usize>(
    system: &NewtonSystem<'_, D>,
    preconditioner: &impl Preconditioner,
    forcing: f64,
    budget: usize,
    dx: &mut [f64],
) -> Result<Descent, NewtonFailure> {
    dx.fill(0.0);
    proceed(system, preconditioner, forcing, budget, dx)
}

/// The same from where `dx` stands.
pub(super) fn proceed<const D: usize>(
    system: &NewtonSystem<'_, D>,
    preconditioner: &impl Preconditioner,
    forcing: f64,
    budget: usize,
    dx: &mut [f64],
) -> Result<Descent, NewtonFailure> {
    let params = PcgParams {
        relative_tolerance: forcing,
        max_iterations: budget,
        ..PcgParams::default()
    };
    let (op, rhs) = (
        AssumedPositiveDefinite(&system.tangent),
        system.right_hand_side(),
    );
    let (outcome, iterations) = match pcg(&op, preconditioner, &rhs, dx, &params) {
        Ok(info) => (DescentOutcome::Found, info.iterations),
        Err(PcgError::NegativeCurvature { iteration, .. }) => {
            (DescentOutcome::Indefinite, iteration)
        }
        Err(
            PcgError::NotConverged { iterations, .. }
            | PcgError::Stagnated { iterations, .. }
            | PcgError::Preconditioner {
                iteration: iterations,
            },
        ) => (DescentOutcome::TooSlow, iterations),
        Err(error) => return Err(error.into()),
    };
    Ok(Descent::iterated(outcome, iterations))
}
