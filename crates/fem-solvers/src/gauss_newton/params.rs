//! The problem, the settings, the results.

use super::Loss;
use thiserror::Error;

/// A function `r(θ)` whose squared norm is to be minimized.
pub trait LeastSquares {
    /// What can go wrong in an evaluation; passed through.
    type Error;
    /// Number of residuals, `m`.
    fn residuals(&self) -> usize;
    /// Number of parameters, `n`.
    fn parameters(&self) -> usize;
    /// Writes `r(θ)`, length `m`.
    ///
    /// # Errors
    /// Whatever the evaluation runs into.
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), Self::Error>;
    /// Writes `∂r/∂θ`, column-major `m × n`: entry `k·m + i` is `∂r_i/∂θ_k`.
    ///
    /// # Errors
    /// Whatever the evaluation runs into.
    fn jacobian(&mut self, theta: &[f64], j: &mut [f64]) -> Result<(), Self::Error>;
    /// Is this an error that no shorter step would mend? By default every step is tried.
    fn gives_up(&self, _error: &Self::Error) -> bool {
        false
    }
}

/// How a step `d` with `J d ≈ −r` is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StepMethod {
    /// Column-pivoted QR of `J`: sees a loss of rank.
    Qr,
    /// Cholesky of `JᵀJ`: cheaper, but squares the condition number.
    NormalEquations,
}

/// Whether steps are damped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Damping {
    /// Full Gauss-Newton steps, whatever the cost does.
    None,
    /// `JᵀJ + λ I` (Levenberg 1944); `λ` starts at `initial` times the largest diagonal entry.
    Levenberg {
        /// Relative first damping, for instance 1e-3.
        initial: f64,
    },
    /// `JᵀJ + λ diag(JᵀJ)` (Marquardt 1963): independent of the units of the parameters.
    Marquardt {
        /// First damping, for instance 1e-3.
        initial: f64,
    },
}

/// `lower ≤ θ ≤ upper`, entry by entry; infinite where there is no bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

/// Adds `½ Σ weight_k (θ_k − value_k)²` to the cost (Tikhonov).
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Weights, not negative; in the unit of the cost over that of the parameter squared.
    pub weights: Vec<f64>,
    /// Expected values.
    pub values: Vec<f64>,
}

/// Settings of [`gauss_newton`](super::gauss_newton).
#[derive(Clone, Debug, PartialEq)]
pub struct GaussNewtonParams {
    /// Linear algebra of a step.
    pub method: StepMethod,
    /// Damping.
    pub damping: Damping,
    /// Box bounds.
    pub bounds: Option<Bounds>,
    /// Regularization.
    pub prior: Option<Prior>,
    /// Robust loss of each group of residuals.
    pub loss: Loss,
    /// Residuals per group, for instance 3 for points in space.
    pub group_size: usize,
    /// Most accepted steps.
    pub max_iterations: usize,
    /// Stop when no parameter moves by more than this in a step. This test and the other two of a
    /// step's size count only where the step is predicted to gain half of what one without damping
    /// would, or where that is nothing by the same tests: a step that is short because it is damped is
    /// no end.
    pub step_tolerance: f64,
    /// Stop when a step lowers the cost by less than this share.
    pub cost_tolerance: f64,
    /// Stop when no entry of the gradient, of parameters free to move, exceeds this.
    pub gradient_tolerance: f64,
    /// Stop when the root mean square of the group norms is at most this, in the residuals' unit.
    pub residual_tolerance: f64,
    /// Stop when a step lowers that root mean square by less than this, in the residuals' unit.
    pub residual_change: f64,
}

impl Default for GaussNewtonParams {
    fn default() -> Self {
        Self {
            method: StepMethod::Qr,
            damping: Damping::Marquardt { initial: 1e-3 },
            bounds: None,
            prior: None,
            loss: Loss::Square,
            group_size: 1,
            max_iterations: 100,
            step_tolerance: 1e-10,
            cost_tolerance: 1e-12,
            gradient_tolerance: 0.0,
            residual_tolerance: 0.0,
            residual_change: 0.0,
        }
    }
}

/// Which test ended a converged fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GaussNewtonStop {
    /// `step_tolerance`.
    Step,
    /// `cost_tolerance`.
    Cost,
    /// `gradient_tolerance`.
    Gradient,
    /// `residual_tolerance`.
    Residual,
    /// `residual_change`.
    ResidualChange,
}

/// One accepted step, for an observer; the starting point is reported with `step = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GaussNewtonIteration<'a> {
    /// Steps so far.
    pub iteration: usize,
    /// `½ Σ ρ + ½ Σ prior`.
    pub cost: f64,
    /// Root mean square of the group norms, in the residuals' unit, not weighted.
    pub residual: f64,
    /// Largest entry of the step taken.
    pub step: f64,
    /// Damping of the step taken.
    pub lambda: f64,
    /// The parameters after the step.
    pub theta: &'a [f64],
}

/// A converged fit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GaussNewtonInfo {
    /// Accepted steps.
    pub iterations: usize,
    /// Cost at the solution.
    pub cost: f64,
    /// Root mean square of the group norms, in the residuals' unit.
    pub residual: f64,
    /// The test that was met.
    pub stop: GaussNewtonStop,
    /// Residual evaluations.
    pub residual_evaluations: usize,
    /// Jacobian evaluations.
    pub jacobian_evaluations: usize,
    /// Parameters that sit on a bound.
    pub at_bound: usize,
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GaussNewtonFailure<E> {
    /// `max_iterations` steps were not enough.
    #[error("not converged")]
    NotConverged,
    /// No damping makes a step that lowers the cost, although the model without damping promises more
    /// than rounding: Jacobian and residual do not belong together, or the residual is noisy.
    #[error("no step lowers the cost, up to damping {lambda:e}")]
    NoDecrease {
        /// The largest damping tried.
        lambda: f64,
    },
    /// The parameters are not determined.
    #[error(
        "the Jacobian has rank {rank} for {free} free parameters; parameter {parameter} cannot be told from the others: damp, add a prior, or remove it"
    )]
    RankDeficient {
        /// Numerical rank.
        rank: usize,
        /// Parameters free to move.
        free: usize,
        /// One that depends on the others.
        parameter: usize,
    },
    /// NaN or infinity in what the problem returned.
    #[error("{what} is not finite at index {index}")]
    NonFinite {
        /// Which quantity.
        what: &'static str,
        /// First bad index.
        index: usize,
    },
    /// A list that does not fit the problem.
    #[error("{what} has {found} entries, the problem has {expected} parameters")]
    Length {
        /// Which list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The number of parameters.
        expected: usize,
    },
    /// A setting that is not a number or outside its range.
    #[error("{what} is {value}, allowed is {allowed}")]
    Params {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// An evaluation failed.
    #[error("evaluation: {0}")]
    Evaluation(E),
}

/// A fit that did not converge; `theta` holds the last accepted parameters, which these numbers describe.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("least squares stopped after {iteration} steps at cost {cost:e}: {reason}")]
pub struct GaussNewtonError<E> {
    /// Steps accepted.
    pub iteration: usize,
    /// Cost of the last accepted parameters; NaN if the first evaluation failed.
    pub cost: f64,
    /// Root mean square of the group norms there.
    pub residual: f64,
    /// Why it stopped.
    pub reason: GaussNewtonFailure<E>,
}
