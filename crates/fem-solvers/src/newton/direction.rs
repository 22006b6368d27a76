//! The Newton direction: one linear solve, repaired where the Hessian is indefinite.

use super::shift::Shift;
use super::{
    DescentDirection, DescentOutcome, HessianProjection, LinearSolver, NewtonFailure, NewtonParams,
    NonlinearProblem, PreconditionerChoice, ProjectionPolicy,
};
use crate::block_matrix::BlockSymmetric;
use crate::cholesky::{CholeskyError, CholeskyFactor, SymbolicCholesky};
use crate::dense_qr::PivotedQr;
use crate::operator::{AssumedPositiveDefinite, Preconditioner};
use crate::pcg::{PcgError, PcgParams, pcg};
use crate::preconditioner::{BlockIc0, BlockJacobi, Identity, PreconditionerError};
use crate::vector::{dot, first_non_finite};
use std::sync::Arc;

/// Largest system for dense QR.
const QR_LIMIT: usize = 3_000;
/// Flops of a factorization below which nothing else is tried.
const CHEAP_FACTOR: f64 = 4e8;
/// Flops of a dense front that take as long as moving one byte of a sparse product.
const FLOPS_PER_BYTE: f64 = 4.0;

/// What is kept between steps and between solves.
pub(super) struct Workspace<const D: usize> {
    pub symbolic: Option<Arc<SymbolicCholesky<D>>>,
    pub coordinates: Option<Vec<[f64; D]>>,
    pub factor: Option<CholeskyFactor<f64, D>>,
    /// The last single-precision factor, of an earlier step or an earlier solve.
    pub single: Option<CholeskyFactor<f32, D>>,
    pub matrix: BlockSymmetric<D>,
    /// In place of the linear solver of the settings.
    pub custom: Option<Box<dyn DescentDirection<D>>>,
    /// Set once conjugate gradients proved dearer than factorizing.
    pub prefer_direct: bool,
    /// Share of the diagonal to start the next step with, under
    /// [`ProjectionPolicy::ExactThenShifted`]; forgotten between solves.
    pub shift: Shift,
}

/// A descent direction and what it took.
pub(super) struct Direction {
    pub dx: Vec<f64>,
    pub projection: HessianProjection,
    pub linear_iterations: usize,
    pub factorizations: usize,
    pub shift: f64,
}

impl<const D: usize> Workspace<D> {
    /// The analysis, made on first use.
    pub fn symbolic(&mut self) -> &Arc<SymbolicCholesky<D>> {
        let (pattern, coordinates) = (self.matrix.pattern(), &self.coordinates);
        self.symbolic.get_or_insert_with(|| {
            Arc::new(match coordinates {
                Some(points) => SymbolicCholesky::with_coordinates(pattern, points),
                None => SymbolicCholesky::new(pattern),
            })
        })
    }

    /// Factors the matrix as it stands.
    pub fn factor(&mut self) -> Result<&CholeskyFactor<f64, D>, CholeskyError> {
        let symbolic = self.symbolic().clone();
        let factor = self
            .factor
            .get_or_insert_with(|| CholeskyFactor::allocate(&symbolic));
        factor.refactor(&self.matrix)?;
        Ok(factor)
    }

    /// A direction `dx` with `K dx ≈ −g` and `gᵀdx < 0`, `‖K dx + g‖ ≤ forcing ‖g‖`.
    pub fn direction(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        g: &[f64],
        forcing: f64,
        params: &NewtonParams,
    ) -> Result<Direction, NewtonFailure> {
        let stages: &[HessianProjection] = match params.projection {
            ProjectionPolicy::ExactFirst => &[HessianProjection::None, HessianProjection::Clamp],
            ProjectionPolicy::ExactThenAbsolute => {
                &[HessianProjection::None, HessianProjection::Absolute]
            }
            ProjectionPolicy::AlwaysProjected => &[HessianProjection::Clamp],
            ProjectionPolicy::ExactThenShifted => &[],
        };
        let mut result = Direction {
            dx: Vec::new(),
            projection: HessianProjection::None,
            linear_iterations: 0,
            factorizations: 0,
            shift: 0.0,
        };
        let rhs: Vec<f64> = g.iter().map(|v| -v).collect();
        for &projection in stages {
            problem.hessian(x, projection, &mut self.matrix);
            self.check_finite()?;
            result.projection = projection;
            if self.attempt(&rhs, forcing, params, &mut result)? {
                return Ok(result);
            }
        }
        if stages.is_empty() {
            problem.hessian(x, HessianProjection::None, &mut self.matrix);
            self.check_finite()?;
            if self.shifted(&rhs, forcing, params, &mut result)? {
                return Ok(result);
            }
            // Shares of a diagonal that has zeros do not help; what follows starts from the plain matrix.
            problem.hessian(x, HessianProjection::None, &mut self.matrix);
            result.shift = 0.0;
        }
        // A projected matrix can still be singular: add to its diagonal until it is not.
        let scale = self
            .matrix
            .diagonal()
            .iter()
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut shift = 1e-9 * if scale > 0.0 { scale } else { 1.0 };
        let mut added = 0.0;
        let mut last = CholeskyError::NotPositiveDefinite { block_row: 0 };
        for _ in 0..14 {
            self.matrix.shift_diagonal(shift - added);
            added = shift;
            result.factorizations += 1;
            match self.factor() {
                Ok(factor) => {
                    let mut dx = rhs.clone();
                    factor.solve_in_place(&mut dx);
                    if descends(&dx, &rhs) {
                        result.dx = dx;
                        return Ok(result);
                    }
                }
                Err(error @ CholeskyError::NotPositiveDefinite { .. }) => last = error,
                Err(error) => return Err(error.into()),
            }
            shift *= 10.0;
        }
        Err(last.into())
    }

    /// Adds as little of the diagonal as makes the matrix positive definite; `false` if nothing does.
    fn shifted(
        &mut self,
        rhs: &[f64],
        forcing: f64,
        params: &NewtonParams,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        let weights = self.matrix.mean_diagonals();
        let mut added = 0.0;
        for _ in 0..Shift::ATTEMPTS {
            let share = self.shift.share();
            self.matrix.add_to_diagonals(&weights, share - added);
            (added, result.shift) = (share, share);
            if self.attempt(rhs, forcing, params, result)? {
                return Ok(true);
            }
            self.shift.refused();
        }
        Ok(false)
    }

    fn check_finite(&self) -> Result<(), NewtonFailure> {
        let bad = self
            .matrix
            .values()
            .iter()
            .position(|b| b.iter().flatten().any(|v| !v.is_finite()));
        match bad {
            None => Ok(()),
            Some(index) => Err(NewtonFailure::NonFinite {
                what: "the Hessian (stored block)",
                index,
            }),
        }
    }

    /// One linear solve with the matrix as it stands; `false` when the matrix is not positive definite.
    fn attempt(
        &mut self,
        rhs: &[f64],
        forcing: f64,
        params: &NewtonParams,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        if self.custom.is_some() {
            return self.brought(rhs, forcing, result);
        }
        match params.linear_solver {
            LinearSolver::Direct => self.direct(rhs, result),
            LinearSolver::DirectSingle => self.single(rhs, forcing, result),
            LinearSolver::QrLeastSquares => self.dense_qr(rhs, result),
            LinearSolver::Pcg {
                preconditioner,
                max_iterations,
            } => {
                let budget = max_iterations;
                match self.iterative(rhs, forcing, preconditioner, budget, result)? {
                    Outcome::Done => Ok(true),
                    Outcome::Indefinite => Ok(false),
                    Outcome::TooSlow => self.direct(rhs, result),
                }
            }
            LinearSolver::Auto => {
                let flops = self.symbolic().flops();
                if flops < CHEAP_FACTOR {
                    return self.direct(rhs, result);
                }
                if self.prefer_direct {
                    return self.single(rhs, forcing, result);
                }
                // One iteration moves the matrix and its incomplete factor, the latter twice.
                let bytes = 3.0 * (8 * D * D * self.matrix.pattern().stored()) as f64;
                let budget = (flops / (FLOPS_PER_BYTE * bytes)).ceil() as usize;
                match self.iterative(
                    rhs,
                    forcing,
                    PreconditionerChoice::BlockIc0,
                    budget,
                    result,
                )? {
                    Outcome::Done => Ok(true),
                    Outcome::Indefinite => Ok(false),
                    Outcome::TooSlow => {
                        self.prefer_direct = true;
                        self.single(rhs, forcing, result)
                    }
                }
            }
        }
    }

    /// The direction that the user brought.
    fn brought(
        &mut self,
        rhs: &[f64],
        forcing: f64,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        let Some(custom) = &mut self.custom else {
            return self.direct(rhs, result);
        };
        let gradient: Vec<f64> = rhs.iter().map(|v| -v).collect();
        let mut dx = vec![0.0; rhs.len()];
        let found = custom.direction(&self.matrix, &gradient, forcing, &mut dx)?;
        result.linear_iterations += found.linear_iterations;
        result.factorizations += found.factorizations;
        match found.outcome {
            DescentOutcome::Found => {
                let good = descends(&dx, rhs);
                result.dx = dx;
                Ok(good)
            }
            DescentOutcome::Indefinite => Ok(false),
            DescentOutcome::TooSlow => self.direct(rhs, result),
        }
    }

    fn direct(&mut self, rhs: &[f64], result: &mut Direction) -> Result<bool, NewtonFailure> {
        result.factorizations += 1;
        match self.factor() {
            Ok(factor) => {
                let mut dx = rhs.to_vec();
                factor.solve_in_place(&mut dx);
                let good = descends(&dx, rhs);
                result.dx = dx;
                Ok(good)
            }
            Err(CholeskyError::NotPositiveDefinite { .. }) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    fn dense_qr(&mut self, rhs: &[f64], result: &mut Direction) -> Result<bool, NewtonFailure> {
        let n = rhs.len();
        if n > QR_LIMIT {
            return Err(NewtonFailure::TooLargeForQr {
                found: n,
                limit: QR_LIMIT,
            });
        }
        result.factorizations += 1;
        let dx = PivotedQr::new(self.matrix.to_dense(), n, n).least_squares(rhs);
        let good = descends(&dx, rhs);
        result.dx = dx;
        Ok(good)
    }

    /// Conjugate gradients on an `f32` factor: the last one while it serves, then a fresh one.
    fn single(
        &mut self,
        rhs: &[f64],
        forcing: f64,
        result: &mut Direction,
    ) -> Result<bool, NewtonFailure> {
        let symbolic = self.symbolic().clone();
        if let Some(stale) = &self.single {
            let budget = stale_budget(&symbolic);
            match conjugate(&self.matrix, stale, rhs, forcing, budget, result)? {
                Outcome::Done => return Ok(true),
                Outcome::Indefinite => return Ok(false),
                Outcome::TooSlow => {}
            }
        }
        let mut factor = match self.single.take() {
            Some(factor) => factor,
            None => CholeskyFactor::allocate(&symbolic),
        };
        result.factorizations += 1;
        if factor.refactor(&self.matrix).is_err() {
            // Indefinite, or definite but not in single precision: double precision knows.
            return self.direct(rhs, result);
        }
        let fresh = self.single.insert(factor);
        // One or two iterations of a fresh factor are worth a nearly exact step.
        match conjugate(
            &self.matrix,
            fresh,
            rhs,
            forcing.min(1e-4),
            FRESH_BUDGET,
            result,
        )? {
            Outcome::Done => Ok(true),
            Outcome::Indefinite => Ok(false),
            Outcome::TooSlow => self.direct(rhs, result),
        }
    }

    fn iterative(
        &mut self,
        rhs: &[f64],
        forcing: f64,
        preconditioner: PreconditionerChoice,
        budget: usize,
        result: &mut Direction,
    ) -> Result<Outcome, NewtonFailure> {
        let matrix = &self.matrix;
        match preconditioner {
            PreconditionerChoice::Identity => {
                conjugate(matrix, &Identity, rhs, forcing, budget, result)
            }
            PreconditionerChoice::BlockJacobi => match BlockJacobi::new(matrix) {
                Ok(m) => conjugate(matrix, &m, rhs, forcing, budget, result),
                Err(error) => no_preconditioner(error),
            },
            PreconditionerChoice::BlockIc0 => match BlockIc0::new(matrix) {
                Ok(m) => conjugate(matrix, &m, rhs, forcing, budget, result),
                Err(error) => no_preconditioner(error),
            },
        }
    }
}

/// Iterations on a fresh single-precision factor before double precision takes over.
const FRESH_BUDGET: usize = 40;

/// Iterations on an old factor that cost about a third of a new one: a factorization does some
/// 70 flops in the time in which a solve reads one entry of the factor.
fn stale_budget<const D: usize>(symbolic: &SymbolicCholesky<D>) -> usize {
    ((symbolic.flops() / (70.0 * symbolic.fill().max(1) as f64) / 3.0) as usize).clamp(3, 12)
}

/// Conjugate gradients on trust; the verdict on what they met.
fn conjugate<const D: usize>(
    matrix: &BlockSymmetric<D>,
    preconditioner: &impl Preconditioner,
    rhs: &[f64],
    forcing: f64,
    budget: usize,
    result: &mut Direction,
) -> Result<Outcome, NewtonFailure> {
    let op = AssumedPositiveDefinite(matrix);
    let params = PcgParams {
        relative_tolerance: forcing,
        max_iterations: budget,
        ..PcgParams::default()
    };
    let mut dx = vec![0.0; rhs.len()];
    match pcg(&op, preconditioner, rhs, &mut dx, &params) {
        Ok(info) => {
            result.linear_iterations += info.iterations;
            let good = descends(&dx, rhs);
            result.dx = dx;
            Ok(if good {
                Outcome::Done
            } else {
                Outcome::Indefinite
            })
        }
        Err(PcgError::NegativeCurvature { iteration, .. }) => {
            result.linear_iterations += iteration;
            Ok(Outcome::Indefinite)
        }
        Err(
            PcgError::NotConverged { iterations, .. }
            | PcgError::Stagnated { iterations, .. }
            | PcgError::Preconditioner {
                iteration: iterations,
            },
        ) => {
            result.linear_iterations += iterations;
            Ok(Outcome::TooSlow)
        }
        Err(error) => Err(error.into()),
    }
}

/// Without a definite preconditioner the matrix is indefinite or nearly so.
fn no_preconditioner(error: PreconditionerError) -> Result<Outcome, NewtonFailure> {
    match error {
        PreconditionerError::NonFinite { .. } => Err(error.into()),
        _ => Ok(Outcome::Indefinite),
    }
}

enum Outcome {
    Done,
    Indefinite,
    TooSlow,
}

/// Finite and downhill: `gᵀdx < 0` with `rhs = −g`.
fn descends(dx: &[f64], rhs: &[f64]) -> bool {
    first_non_finite(dx).is_none() && dot(dx, rhs) > 0.0
}
