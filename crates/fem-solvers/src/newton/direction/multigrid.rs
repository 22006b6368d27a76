//! Conjugate gradients on a multigrid hierarchy.

use super::pcg::{iterate, proceed};
use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem};
use crate::cholesky::SymbolicCholesky;
use crate::multigrid::{Multigrid, MultigridParams};
use crate::newton::NewtonFailure;
use crate::operator::MatrixPreconditioner;
use crate::preconditioner::PreconditionerError;

/// Conjugate gradients with a smoothed-aggregation hierarchy in `f32`, `K` vectors of near kernel
/// ([`NonlinearProblem::near_kernel`](crate::NonlinearProblem::near_kernel)).
///
/// A hierarchy serves later steps and solves as long as they do not take many more iterations than its
/// first one, then its values are renewed; its aggregates, once new values do not help any more. When a
/// fresh hierarchy does not help either, a factorization takes over for the step.
#[derive(Debug)]
pub struct MultigridDirection<const D: usize, const K: usize> {
    multigrid: Option<Multigrid<D, K>>,
    params: MultigridParams,
    /// Iterations for each decimal digit of the residual when the values were new.
    rate: f64,
    /// The same when the aggregates were new.
    first_rate: Option<f64>,
}

/// Iterations on a fresh hierarchy before a factorization takes over: at least, at most, and in between
/// as many as move as many bytes as a factorization takes flops over [`FLOPS_PER_BYTE`].
const FEWEST: usize = 30;
const MOST: usize = 1_000;
/// Flops of a dense front that take as long as moving one byte of a sparse product.
pub(crate) const FLOPS_PER_BYTE: f64 = 4.0;
/// Bytes that a cycle and an iteration move, over those of the matrix: four products on levels half
/// again as large as the finest, one with the matrix itself, prolongators and vectors.
pub(super) const BYTES_PER_ITERATION: f64 = 8.0;
/// A usual step: about ten iterations' worth of setup, and fifteen iterations.
const USUAL_STEP: f64 = 25.0;
/// New values cost about as much as ten iterations: an old hierarchy may take this many more than it did
/// when it was new.
pub(super) const RENEWAL: f64 = 10.0;
/// Part of a digit by which a step is measured at least: the first iterations find the most.
const FEWEST_DIGITS: f64 = -1.0;
/// Growth of the iterations from which on aggregates are looked for again.
const WORSE: f64 = 2.0;

impl<const D: usize, const K: usize> MultigridDirection<D, K> {
    /// With these settings.
    pub fn new(params: MultigridParams) -> Self {
        Self {
            multigrid: None,
            params,
            rate: 0.0,
            first_rate: None,
        }
    }

    /// The hierarchy of the last step; `None` before the first.
    pub fn multigrid(&self) -> Option<&Multigrid<D, K>> {
        self.multigrid.as_ref()
    }

    /// Whether this many usual steps move fewer bytes than a factorization takes flops over four; counts,
    /// not clocks, so that a run can be repeated bit by bit.
    pub fn is_cheaper_than(symbolic: &SymbolicCholesky<D>, steps: f64) -> bool {
        is_cheaper_than(symbolic, steps)
    }

    /// New values, and new aggregates where there are none. `false` where the matrix is not positive definite.
    fn renew(&mut self, system: &NewtonSystem<'_, D>) -> Result<bool, NewtonFailure> {
        let matrix = system.tangent.assembled()?;
        let kernel = system.near_kernel();
        let multigrid = match &mut self.multigrid {
            Some(made) => {
                made.set_near_kernel(kernel);
                made
            }
            None => self.multigrid.insert(Multigrid::new(kernel, self.params)),
        };
        match multigrid.update(matrix) {
            Ok(()) => Ok(true),
            Err(
                PreconditionerError::NotPositiveDefinite { .. }
                | PreconditionerError::NegativeCurvature { .. },
            ) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }
}

/// [`MultigridDirection::is_cheaper_than`], which no near kernel changes.
pub(super) fn is_cheaper_than<const D: usize>(symbolic: &SymbolicCholesky<D>, steps: f64) -> bool {
    steps * USUAL_STEP < iterations_of_a_factorization(symbolic)
}

/// Decimal digits that a step's forcing asks of the residual.
pub(super) fn digits(forcing: f64) -> f64 {
    -forcing.log10().min(FEWEST_DIGITS)
}

fn iterations_of_a_factorization<const D: usize>(symbolic: &SymbolicCholesky<D>) -> f64 {
    symbolic.flops() / (FLOPS_PER_BYTE * bytes_of_an_iteration(symbolic))
}

/// What an iteration on a hierarchy moves.
pub(crate) fn bytes_of_an_iteration<const D: usize>(symbolic: &SymbolicCholesky<D>) -> f64 {
    let matrix = (8 * D * D * symbolic.pattern().stored()) as f64;
    BYTES_PER_ITERATION * matrix
}

impl<const D: usize, const K: usize> DescentDirection<D> for MultigridDirection<D, K> {
    fn forget(&mut self) {
        *self = Self::new(self.params);
    }
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let worth = iterations_of_a_factorization(&*system.symbolic()?);
        let budget = (worth as usize).clamp(FEWEST, MOST);
        let matrix = system.tangent.assembled()?;
        let forcing = system.forcing;
        let digits = digits(forcing);
        let mut done = Descent::iterated(DescentOutcome::TooSlow, 0);
        if let Some(old) = self.multigrid.as_ref().filter(|old| old.fits(matrix)) {
            let budget = (self.rate * digits + RENEWAL) as usize;
            done = iterate(system, old, forcing, budget, dx)?;
            if done.outcome != DescentOutcome::TooSlow {
                return Ok(done);
            }
        }
        if self
            .first_rate
            .is_some_and(|first| self.rate > WORSE * first)
        {
            self.multigrid = None;
            self.first_rate = None;
        }
        if !self.renew(system)? {
            let indefinite = Descent::iterated(DescentOutcome::Indefinite, 0);
            return Ok(indefinite.after(done));
        }
        let Some(fresh) = &self.multigrid else {
            return Ok(done);
        };
        let found = proceed(system, fresh, forcing, budget, dx)?;
        if found.outcome == DescentOutcome::Found {
            self.rate = found.linear_iterations as f64 / digits;
            self.first_rate.get_or_insert(self.rate);
        }
        Ok(found.after(done))
    }
}
