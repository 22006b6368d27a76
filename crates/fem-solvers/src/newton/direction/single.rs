//! [`LinearSolver::DirectSingle`](crate::LinearSolver): conjugate gradients on an `f32` factor.

use super::pcg::iterate;
use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem};
use crate::cholesky::{CholeskyFactor, SymbolicCholesky};
use crate::newton::NewtonFailure;

/// Iterations on a fresh single-precision factor before double precision takes over.
const FRESH_BUDGET: usize = 40;
/// One or two iterations of a fresh factor are worth a nearly exact step.
const FRESH_FORCING: f64 = 1e-4;

/// Remembers its factor, of an earlier step or an earlier solve, and uses it while it serves.
pub(super) struct Single<const D: usize> {
    factor: Option<CholeskyFactor<f32, D>>,
}

impl<const D: usize> Default for Single<D> {
    fn default() -> Self {
        Self { factor: None }
    }
}

impl<const D: usize> DescentDirection<D> for Single<D> {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let symbolic = system.symbolic()?;
        let mut done = Descent::iterated(DescentOutcome::TooSlow, 0);
        if let Some(stale) = &self.factor {
            done = iterate(system, stale, system.forcing, stale_budget(&symbolic), dx)?;
            if done.outcome != DescentOutcome::TooSlow {
                return Ok(done);
            }
        }
        let mut factor = match self.factor.take() {
            Some(factor) => factor,
            None => CholeskyFactor::allocate(&symbolic),
        };
        done.factorizations += 1;
        if factor.refactor(system.tangent.assembled()?).is_err() {
            // Indefinite, or definite but not in single precision: double precision knows.
            return Ok(system.solve_directly(dx)?.after(done));
        }
        let fresh = self.factor.insert(factor);
        let forcing = system.forcing.min(FRESH_FORCING);
        let found = iterate(system, fresh, forcing, FRESH_BUDGET, dx)?.after(done);
        match found.outcome {
            DescentOutcome::TooSlow => Ok(system.solve_directly(dx)?.after(found)),
            _ => Ok(found),
        }
    }
}

/// Iterations on an old factor that cost about a third of a new one: a factorization does some
/// 70 flops in the time in which a solve reads one entry of the factor.
fn stale_budget<const D: usize>(symbolic: &SymbolicCholesky<D>) -> usize {
    ((symbolic.flops() / (70.0 * symbolic.fill().max(1) as f64) / 3.0) as usize).clamp(3, 12)
}
