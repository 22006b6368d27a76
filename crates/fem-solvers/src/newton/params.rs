//! Settings, results and errors of Newton's method.

use crate::cholesky::CholeskyError;
use crate::pcg::PcgError;
use crate::preconditioner::PreconditionerError;
use fem_kinematics::HessianProjection;
use thiserror::Error;

/// How the Newton direction is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LinearSolver {
    /// Sparse Cholesky, `f64`.
    Direct,
    /// Sparse Cholesky in `f32`, made exact by conjugate gradients in `f64`: half the time and memory.
    /// The factor is kept for later steps and solves as long as a few iterations on it suffice, so
    /// that neighboring frames of a sequence often need no factorization at all.
    DirectSingle,
    /// Inexact Newton: conjugate gradients to the accuracy that the current step deserves
    /// (Eisenstat & Walker 1996, choice 2).
    Pcg {
        /// The preconditioner.
        preconditioner: PreconditionerChoice,
        /// Iterations per Newton step before the direct solver takes over.
        max_iterations: usize,
    },
    /// Dense QR: the least-squares solution of `K dx = −g` (document 000, section 5.1), of small systems only.
    QrLeastSquares,
    /// Small systems: [`Direct`](Self::Direct). Larger ones: conjugate gradients with block IC(0), from
    /// which a solid in space ([`near_kernel`](super::NonlinearProblem::near_kernel)) goes on to a multigrid
    /// hierarchy, where that is cheaper than a factorization, once its steps have lost as much as a first
    /// hierarchy costs; [`DirectSingle`](Self::DirectSingle) once a step takes as many operations as a
    /// factorization. What is remembered of it goes with the pattern of the matrix, a hierarchy also with a
    /// matrix that is indefinite. Every choice rests on counts, not on clocks.
    Auto,
}

impl LinearSolver {
    /// Most unknowns of [`LinearSolver::QrLeastSquares`].
    pub const LARGEST_QR: usize = 3_000;
}

/// Which preconditioner conjugate gradients use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PreconditionerChoice {
    /// None: document 000, Algorithm 1.
    Identity,
    /// The inverse of the block diagonal.
    BlockJacobi,
    /// Incomplete Cholesky without fill.
    BlockIc0,
}

/// When to use a projected Hessian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ProjectionPolicy {
    /// The exact one first; the projected one for a step whose matrix shows negative curvature.
    ExactFirst,
    /// The exact one first; with absolute eigenvalues for a step whose matrix shows negative curvature.
    ExactThenAbsolute,
    /// Always the projected one.
    AlwaysProjected,
    /// The exact one first; where it shows negative curvature, a share of its own diagonal is added to
    /// it, about as much as it takes. The share is remembered: it shrinks after full steps and grows
    /// after shortened ones (Levenberg 1944). Unlike a projection this leaves the stable part of the
    /// matrix as it is and assembles nothing twice.
    ExactThenShifted,
    /// The exact one `K` first; where it shows negative curvature, `K + s (|K| − K)` with absolute
    /// eigenvalues of every element in `|K|`, and the share `s` in (0, 1] about as small as makes that
    /// definite. The share is remembered as under [`ExactThenShifted`](Self::ExactThenShifted). What
    /// buckles is stiffened where it buckles, and hardly elsewhere.
    ExactThenBlended,
}

/// Backtracking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSearchParams {
    /// Share of the predicted decrease that a step must reach (Armijo 1966), in (0, ½).
    pub sufficient_decrease: f64,
    /// Halvings before the search fails.
    pub max_backtracks: usize,
    /// Differences of energy below this share of the largest energy met, counted a tenth for each
    /// step ago, are rounding.
    pub rounding: f64,
}

impl Default for LineSearchParams {
    fn default() -> Self {
        Self {
            sufficient_decrease: 1e-4,
            max_backtracks: 40,
            rounding: 1e-11,
        }
    }
}

/// Settings of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonParams {
    /// Converged when the largest gradient entry is at most this, in the unit of the gradient.
    pub gradient_tolerance: f64,
    /// … or when every entry is at most this share of its reference.
    pub relative_gradient_tolerance: f64,
    /// Size of a typical gradient entry; if `None`, each entry's own
    /// ([`gradient_scales`](super::NonlinearProblem::gradient_scales)), and the largest entry at the start
    /// where the problem knows none.
    pub reference: Option<f64>,
    /// … or when the largest entry of a full step is at most this, in the unit of `x`.
    pub step_tolerance: f64,
    /// … or when a full step along the exact Hessian's direction was expected to lower the energy by at
    /// most this, in the unit of the energy: the Newton decrement ½ gᵀK⁻¹g = −½ gᵀd, which depends on
    /// neither the unit of `x` nor the mesh. Directions of conjugate gradients count as far as they
    /// were solved. Not asked where the merit is no energy.
    pub decrement_tolerance: f64,
    /// Most Newton steps.
    pub max_iterations: usize,
    /// How directions are computed.
    pub linear_solver: LinearSolver,
    /// Which Hessian is used.
    pub projection: ProjectionPolicy,
    /// Backtracking.
    pub line_search: LineSearchParams,
}

impl Default for NewtonParams {
    fn default() -> Self {
        Self {
            gradient_tolerance: 0.0,
            relative_gradient_tolerance: 1e-8,
            reference: None,
            step_tolerance: 0.0,
            decrement_tolerance: 0.0,
            max_iterations: 100,
            linear_solver: LinearSolver::Auto,
            projection: ProjectionPolicy::ExactFirst,
            line_search: LineSearchParams::default(),
        }
    }
}

impl NewtonParams {
    /// Refuses settings that are negative, not a number or outside their range.
    pub(super) fn check(&self) -> Result<(), NewtonFailure> {
        let share = self.line_search.sufficient_decrease;
        if !(share > 0.0 && share < 0.5) {
            return Err(NewtonFailure::Params {
                what: "line_search.sufficient_decrease",
                value: share,
                allowed: "(0, 1/2)",
            });
        }
        for (what, value) in [
            ("gradient_tolerance", self.gradient_tolerance),
            (
                "relative_gradient_tolerance",
                self.relative_gradient_tolerance,
            ),
            ("reference", self.reference.unwrap_or(0.0)),
            ("step_tolerance", self.step_tolerance),
            ("decrement_tolerance", self.decrement_tolerance),
            ("line_search.rounding", self.line_search.rounding),
        ] {
            if !(0.0..f64::INFINITY).contains(&value) {
                let allowed = "[0, ∞)";
                return Err(NewtonFailure::Params {
                    what,
                    value,
                    allowed,
                });
            }
        }
        Ok(())
    }
}

/// Which test ended a converged solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopReason {
    /// The absolute gradient tolerance.
    Gradient,
    /// The gradient tolerance relative to the reference.
    RelativeGradient,
    /// The step tolerance.
    Step,
    /// The tolerance of the Newton decrement.
    Decrement,
    /// Converged to rounding: the tolerances ask for less than rounding leaves of the gradient, and
    /// every entry `g_i` is at most its tolerance, `4 ε Σ_j |K_ij| |x_j|`, or its
    /// [`gradient_rounding`](super::NonlinearProblem::gradient_rounding), whichever is largest.
    Rounding,
}

/// One step, for an observer. `t = 0` and `step = 0` in the report of the starting point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewtonIteration {
    /// Steps taken so far.
    pub iteration: usize,
    /// Energy after the step.
    pub energy: f64,
    /// Largest gradient entry after the step.
    pub gradient_norm: f64,
    /// Largest entry of the step taken.
    pub step: f64,
    /// Share of the Newton direction taken.
    pub t: f64,
    /// By how much the quadratic model of the energy fell along the whole direction, −½ gᵀd: the Newton
    /// decrement where the Hessian was exact.
    pub decrement: f64,
    /// Conjugate gradient iterations; 0 for a direct solve.
    pub linear_iterations: usize,
    /// The Hessian that gave the direction.
    pub projection: HessianProjection,
    /// Share of the Hessian's own diagonal that was added to it, or of the way from the Hessian to its
    /// `projection` under [`ProjectionPolicy::ExactThenBlended`]; 0 for none.
    pub shift: f64,
}

impl NewtonIteration {
    /// The step in a few words.
    fn told(&self) -> String {
        let hessian = match (self.projection, self.shift) {
            (HessianProjection::None, 0.0) => "the exact Hessian".into(),
            (HessianProjection::None, share) => format!("{share:.1e} of its diagonal added"),
            (projection, 0.0) => format!("{projection:?} Hessian"),
            (projection, share) => format!("{share:.2} of the way to the {projection:?} Hessian"),
        };
        let Self { step, t, .. } = self;
        format!(" (last step {step:.1e}, {t:.2} of Newton's, {hessian})")
    }
}

/// A converged solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewtonInfo {
    /// Newton steps.
    pub iterations: usize,
    /// Energy at the solution.
    pub energy: f64,
    /// Largest gradient entry at the solution.
    pub gradient_norm: f64,
    /// The test that was met.
    pub stop: StopReason,
    /// Numeric factorizations done.
    pub factorizations: usize,
    /// Conjugate gradient iterations, all steps together.
    pub linear_iterations: usize,
    /// Energy evaluations, those with the gradient included.
    pub evaluations: usize,
    /// Steps that needed a projected or shifted Hessian.
    pub projected_steps: usize,
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NewtonFailure {
    /// A setting that is negative, not a number or outside its range.
    #[error("{what} is {value}, allowed is {allowed}")]
    Params {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// `max_iterations` steps were not enough.
    #[error("not converged")]
    NotConverged,
    /// A [`Watch`](super::Watch) ended it.
    #[error("cancelled")]
    Cancelled,
    /// No share of the direction lowers the energy.
    #[error("the line search found no decrease along the last direction (slope {slope:e})")]
    LineSearchFailed {
        /// `gᵀ dx` of the direction.
        slope: f64,
    },
    /// The start lies outside the domain.
    #[error(
        "the starting point lies outside the domain: its energy is {energy}; start where it is finite, and go on from there in parts (`follow_path`)"
    )]
    OutsideDomain {
        /// The energy.
        energy: f64,
    },
    /// NaN or infinity in what the problem returned.
    #[error("{what} is not finite at index {index}")]
    NonFinite {
        /// Which quantity.
        what: &'static str,
        /// First bad index.
        index: usize,
    },
    /// A slice does not have the problem's length.
    #[error("x has length {found}, the problem has {expected} unknowns")]
    Dimension {
        /// Length of `x`.
        found: usize,
        /// `D · blocks`.
        expected: usize,
    },
    /// The problem's pattern is not the one this solver was made for.
    #[error(
        "the problem's pattern differs from the one the solver was made for; make a new solver"
    )]
    PatternMismatch,
    /// A factorization failed.
    #[error("linear solve: {0}")]
    Cholesky(#[from] CholeskyError),
    /// Conjugate gradients failed.
    #[error("linear solve: {0}")]
    Pcg(#[from] PcgError),
    /// No preconditioner.
    #[error("linear solve: {0}")]
    Preconditioner(#[from] PreconditionerError),
    /// The tangent is not positive definite, whatever is added to its diagonal.
    #[error("the tangent is not positive definite, not even with {shift:e} on its diagonal")]
    Indefinite {
        /// The last number that was added, in the unit of the Hessian.
        shift: f64,
        /// The block row that a factorization refused last, where there is a matrix to factor.
        block_row: Option<usize>,
    },
    /// The linear solver needs a matrix, the problem gives only products with its Hessian.
    #[error(
        "the problem gives only products with its Hessian: use conjugate gradients with a preconditioner that needs no matrix"
    )]
    NeedsMatrix,
    /// Dense QR was asked for too large a system.
    #[error(
        "dense QR is limited to {limit} unknowns, the problem has {found}; use another linear solver"
    )]
    TooLargeForQr {
        /// Unknowns.
        found: usize,
        /// The limit.
        limit: usize,
    },
}

impl NewtonFailure {
    /// Could a problem that does not determine its solution fail like this?
    pub(super) fn may_be_undetermined(&self) -> bool {
        !matches!(
            self,
            Self::Params { .. }
                | Self::Cancelled
                | Self::Dimension { .. }
                | Self::PatternMismatch
                | Self::NeedsMatrix
                | Self::TooLargeForQr { .. }
        )
    }
}

/// A solve that did not converge; `x` holds the last accepted state, which these numbers describe.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "Newton's method stopped after {iteration} steps at energy {energy:e}, gradient {gradient_norm:e}{}: {reason}{}",
    last.as_ref().map_or_else(String::new, |step| step.told()),
    undetermined.as_ref().map_or_else(String::new, |what| format!("; {what}"))
)]
#[non_exhaustive]
pub struct NewtonError {
    /// Steps accepted.
    pub iteration: usize,
    /// Numeric factorizations done.
    pub factorizations: usize,
    /// Conjugate gradient iterations, all steps together.
    pub linear_iterations: usize,
    /// The last step taken, if any was.
    pub last: Option<Box<NewtonIteration>>,
    /// Energy of the last accepted state.
    pub energy: f64,
    /// Its largest gradient entry.
    pub gradient_norm: f64,
    /// Why it stopped.
    #[source]
    pub reason: NewtonFailure,
    /// What nothing determines where the solve ended, where the problem knows of any
    /// ([`NonlinearProblem::undetermined`](super::NonlinearProblem::undetermined)): what comes first to mind
    /// as the cause.
    pub undetermined: Option<Box<str>>,
}
