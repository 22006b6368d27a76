//! KKT systems for linear constraints, exact and relaxed (document 001, section 4.3).
//!
//! The problem is min E(x) with c(x) = 0 and constant ∇c. Newton's step and the multipliers λ solve
//! eq. 15,
//!
//! ```text
//! | ∇²E  −∇cᵀ | |Δx|   |−∇E|
//! | −∇c    0  | |λ | = |  c |.
//! ```
//!
//! The document adds (1/η) I to the lower right block (eq. 16) and asks for η → −∞. Here the same
//! number is a positive stiffness κ = −η: eliminating λ = η (c + ∇c Δx) from eq. 16 leaves
//!
//! ```text
//! (∇²E + κ ∇cᵀ∇c) Δx = −(∇E + κ ∇cᵀ c),
//! ```
//!
//! Newton's method on the penalty function E + κ/2 |c|² (eq. 20). That system is symmetric
//! positive definite where the KKT matrix is only quasi-definite, so conjugate gradients solve
//! it; with a negative κ (a positive η) it would reward violated constraints. The exact system is
//! solved by the same elimination, refined on the residuals of eq. 15 itself.
//!
//! Steps, line search and stop rules are those of [`Newton`].

mod direction;
mod merit;

pub use direction::KktStep;

use crate::error::{MpmError, NewtonEnd, SolveError, positive, same_length};
use direction::{KktDirection, kkt_step, nearest};
use fem_solvers::{Newton, NewtonError, NewtonFailure, NewtonIteration, NewtonParams};
use merit::Penalty;

/// A convex energy with linear constraints.
pub trait ConstrainedProblem: Sync {
    /// Number of unknowns.
    fn unknowns(&self) -> usize;
    /// Number of constraints.
    fn constraints(&self) -> usize;
    /// E(x).
    fn energy(&self, x: &[f64]) -> f64;
    /// ∇E(x).
    fn gradient(&self, x: &[f64], g: &mut [f64]);
    /// y = ∇²E(x) d.
    fn hessian(&self, x: &[f64], d: &[f64], y: &mut [f64]);
    /// The diagonal of ∇²E(x) + κ ∇cᵀ∇c, or anything positive close to it.
    fn diagonal(&self, x: &[f64], stiffness: f64, diagonal: &mut [f64]);
    /// c(x).
    fn constraint(&self, x: &[f64], c: &mut [f64]);
    /// y = ∇c d.
    fn jacobian(&self, d: &[f64], y: &mut [f64]);
    /// y = ∇cᵀ λ.
    fn jacobian_transpose(&self, lambda: &[f64], y: &mut [f64]);
}

/// How hard the constraints are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constraints {
    /// c = 0 (eq. 15). The iteration starts at the nearest point that meets them.
    Exact,
    /// Eq. 16; c = 0 is met to O(1/κ).
    Relaxed {
        /// κ = −η > 0.
        stiffness: f64,
    },
}

/// How hard the constraints are and when to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kkt {
    /// How hard the constraints are.
    pub constraints: Constraints,
    /// Stop when a full step changes no unknown by more than this, in their unit.
    pub tolerance: f64,
    /// Give up after this many Newton steps.
    pub max_iterations: usize,
}

/// A minimizer of the constrained or the relaxed problem.
#[derive(Clone, Debug, PartialEq)]
pub struct KktSolution {
    /// x*.
    pub x: Vec<f64>,
    /// λ*, as a KKT system at x* gave it. Relaxed it is η c(x*) = −κ c(x*), eq. 18 (κ c itself
    /// would lose digits).
    pub lambda: Vec<f64>,
    /// Every iterate, the start included.
    pub iterates: Vec<Vec<f64>>,
}

impl Kkt {
    /// Newton's method on eq. 15 or 16 from `x`.
    ///
    /// # Errors
    /// A stiffness or tolerance that is not positive, a start of the wrong length, constraints that
    /// contradict each other, a linear solve that failed, an energy that is not convex, a gradient or
    /// constraint that is not a number, or no convergence.
    pub fn solve(
        &self,
        problem: &impl ConstrainedProblem,
        x: &[f64],
    ) -> Result<KktSolution, MpmError> {
        self.check(problem, x)?;
        positive("tolerance of the KKT system", self.tolerance)?;
        let mut x = x.to_vec();
        if self.constraints == Constraints::Exact {
            nearest(problem, &mut x).map_err(|error| MpmError::Solve {
                system: SYSTEM,
                source: SolveError::Contradiction(error),
            })?;
        }
        let mut iterates = Vec::new();
        self.minimize(problem, &mut x, &mut iterates)
            .map_err(|(error, change)| self.failure(&error, change, &x))?;
        if iterates.last() != Some(&x) {
            iterates.push(x.clone());
        }
        let lambda = self.step(problem, &x)?.lambda;
        Ok(KktSolution {
            x,
            lambda,
            iterates,
        })
    }

    /// The solution of eq. 15 or 16 at `x`: Newton's full step.
    ///
    /// # Errors
    /// A stiffness that is not positive, a point of the wrong length, or a linear solve that failed.
    pub fn step(&self, problem: &impl ConstrainedProblem, x: &[f64]) -> Result<KktStep, MpmError> {
        self.check(problem, x)?;
        kkt_step(problem, self.constraints, x).map_err(|error| MpmError::Solve {
            system: SYSTEM,
            source: error.into(),
        })
    }

    fn check(&self, problem: &impl ConstrainedProblem, x: &[f64]) -> Result<(), MpmError> {
        if let Constraints::Relaxed { stiffness } = self.constraints {
            positive("stiffness of the relaxed constraints", stiffness)?;
        }
        same_length("start of the KKT system", x.len(), problem.unknowns())
    }

    /// Minimizes from `x` and lists where steps started; an error comes with the last change.
    fn minimize<P: ConstrainedProblem>(
        &self,
        problem: &P,
        x: &mut [f64],
        iterates: &mut Vec<Vec<f64>>,
    ) -> Result<(), (NewtonError, f64)> {
        let penalty = Penalty {
            problem,
            constraints: self.constraints,
        };
        let direction = KktDirection {
            problem,
            constraints: self.constraints,
            iterates,
        };
        let params = NewtonParams {
            relative_gradient_tolerance: 0.0,
            gradient_tolerance: 0.0,
            step_tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            ..NewtonParams::default()
        };
        let mut change = f64::INFINITY;
        let mut observe = |step: &NewtonIteration| {
            if step.iteration > 0 {
                change = step.step;
            }
        };
        let solved = Newton::with_direction(&penalty, direction).solve_observed(
            &penalty,
            x,
            &params,
            &mut observe,
        );
        match solved {
            Ok(_) => Ok(()),
            Err(error) => Err((error, change)),
        }
    }

    fn failure(&self, error: &NewtonError, change: f64, last: &[f64]) -> MpmError {
        match error.reason {
            NewtonFailure::NotConverged => MpmError::Newton {
                system: SYSTEM,
                reason: NewtonEnd::NotConverged,
                iterations: error.iteration,
                change,
                tolerance: self.tolerance,
                last: last.to_vec(),
            },
            _ => MpmError::Solve {
                system: SYSTEM,
                source: error.clone().into(),
            },
        }
    }
}

const SYSTEM: &str = "KKT system";
