//! Directions and preconditioners that others bring.

use super::NewtonFailure;
use crate::block_matrix::BlockSymmetric;
use crate::operator::{AssumedPositiveDefinite, MatrixPreconditioner};
use crate::pcg::{PcgError, PcgParams, pcg};
use crate::preconditioner::PreconditionerError;

/// What a [`DescentDirection`] found out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescentOutcome {
    /// `dx` is a direction; Newton's method still checks that it is finite and leads downhill.
    Found,
    /// The matrix is not positive definite: Newton's method repairs it and asks again.
    Indefinite,
    /// Not worth more work: a sparse factorization takes over for this step.
    TooSlow,
}

/// An outcome and the work that it took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descent {
    /// What was found out.
    pub outcome: DescentOutcome,
    /// Iterations of a linear solver.
    pub linear_iterations: usize,
    /// Factorizations.
    pub factorizations: usize,
}

/// How Newton's method gets its direction, in place of a [`LinearSolver`](super::LinearSolver);
/// what it keeps in itself it remembers from step to step and from solve to solve.
pub trait DescentDirection<const D: usize>: Send + Sync {
    /// Writes `dx` with `‖K dx + g‖ ≤ forcing ‖g‖`, `K` the Hessian or what a
    /// [`ProjectionPolicy`](super::ProjectionPolicy) makes of it. `dx` has the length of `g` and is
    /// zero on entry.
    ///
    /// # Errors
    /// What ends the whole solve; a matrix that is only indefinite is an outcome.
    fn direction(
        &mut self,
        hessian: &BlockSymmetric<D>,
        gradient: &[f64],
        forcing: f64,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure>;
}

/// Conjugate gradients with any preconditioner that follows the matrix.
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
}

impl<P: MatrixPreconditioner<D> + Send + Sync, const D: usize> DescentDirection<D>
    for PcgDirection<P>
{
    fn direction(
        &mut self,
        hessian: &BlockSymmetric<D>,
        gradient: &[f64],
        forcing: f64,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let descent = |outcome, linear_iterations| Descent {
            outcome,
            linear_iterations,
            factorizations: 0,
        };
        match self.preconditioner.update(hessian) {
            Ok(()) => {}
            Err(error @ PreconditionerError::NonFinite { .. }) => return Err(error.into()),
            Err(_) => return Ok(descent(DescentOutcome::Indefinite, 0)),
        }
        let rhs: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let params = PcgParams {
            relative_tolerance: forcing,
            max_iterations: self.max_iterations,
            ..PcgParams::default()
        };
        let op = AssumedPositiveDefinite(hessian);
        match pcg(&op, &self.preconditioner, &rhs, dx, &params) {
            Ok(info) => Ok(descent(DescentOutcome::Found, info.iterations)),
            Err(PcgError::NegativeCurvature { iteration, .. }) => {
                Ok(descent(DescentOutcome::Indefinite, iteration))
            }
            Err(
                PcgError::NotConverged { iterations, .. }
                | PcgError::Stagnated { iterations, .. }
                | PcgError::Preconditioner {
                    iteration: iterations,
                },
            ) => Ok(descent(DescentOutcome::TooSlow, iterations)),
            Err(error) => Err(error.into()),
        }
    }
}
