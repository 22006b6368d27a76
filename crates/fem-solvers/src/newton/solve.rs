//! The Newton loop.

use super::direction::Workspace;
use super::line_search::{Start, search};
use super::shift::Shift;
use super::{
    HessianProjection, Merit, NewtonError, NewtonFailure, NewtonInfo, NewtonIteration,
    NewtonParams, NonlinearProblem, StopReason,
};
use crate::block_matrix::BlockSymmetric;
use crate::cholesky::{CholeskyFactor, SymbolicCholesky};
use crate::vector::{dot, first_non_finite, norm, norm_inf};
use std::sync::Arc;

/// Newton's method for one pattern: keeps the ordering, the analysis and all memory between solves.
pub struct Newton<const D: usize> {
    workspace: Workspace<D>,
}

/// Where a solve stands.
struct State {
    gradient: Vec<f64>,
    energy: f64,
    info: NewtonInfo,
}

impl<const D: usize> Newton<D> {
    /// A solver for every problem with the same pattern as this one.
    pub fn new(problem: &(impl NonlinearProblem<D> + ?Sized)) -> Self {
        let matrix = BlockSymmetric::zeros(problem.pattern());
        Self {
            workspace: Workspace {
                symbolic: None,
                coordinates: problem.coordinates(),
                factor: None,
                single: None,
                matrix,
                prefer_direct: false,
                shift: Shift::default(),
            },
        }
    }

    /// Minimizes from `x`; `x` becomes the solution.
    ///
    /// # Errors
    /// See [`NewtonFailure`]; `x` then holds the last accepted state.
    pub fn solve(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &mut [f64],
        params: &NewtonParams,
    ) -> Result<NewtonInfo, NewtonError> {
        self.solve_observed(problem, x, params, &mut |_| {})
    }

    /// [`solve`](Self::solve), reporting the starting point and every step.
    ///
    /// # Errors
    /// See [`NewtonFailure`]; `x` then holds the last accepted state.
    pub fn solve_observed(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &mut [f64],
        params: &NewtonParams,
        observer: &mut dyn FnMut(&NewtonIteration),
    ) -> Result<NewtonInfo, NewtonError> {
        let mut state = State {
            gradient: vec![0.0; x.len()],
            energy: f64::NAN,
            info: NewtonInfo {
                iterations: 0,
                energy: f64::NAN,
                gradient_norm: f64::NAN,
                stop: StopReason::Gradient,
                factorizations: 0,
                linear_iterations: 0,
                evaluations: 0,
                projected_steps: 0,
            },
        };
        self.run(problem, x, params, observer, &mut state)
            .map_err(|reason| NewtonError {
                iteration: state.info.iterations,
                energy: state.energy,
                gradient_norm: state.info.gradient_norm,
                reason,
            })?;
        state.info.energy = state.energy;
        Ok(state.info)
    }

    fn run(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &mut [f64],
        params: &NewtonParams,
        observer: &mut dyn FnMut(&NewtonIteration),
        state: &mut State,
    ) -> Result<(), NewtonFailure> {
        self.check(problem, x)?;
        state.energy = problem.energy_and_gradient(x, &mut state.gradient);
        state.info.evaluations += 1;
        if state.energy.is_nan() && problem.merit() == Merit::Energy {
            return Err(NewtonFailure::NonFinite {
                what: "the energy of the starting point",
                index: 0,
            });
        }
        if state.energy == f64::INFINITY {
            return Err(NewtonFailure::OutsideDomain {
                energy: state.energy,
            });
        }
        if let Some(index) = first_non_finite(&state.gradient) {
            return Err(NewtonFailure::NonFinite {
                what: "the gradient",
                index,
            });
        }
        state.info.gradient_norm = norm_inf(&state.gradient);
        let relative = params.relative_gradient_tolerance > 0.0;
        let reference = params.reference.unwrap_or_else(|| {
            // The problem may have to assemble something to tell, so it is asked only if it matters.
            let own = relative.then(|| problem.gradient_scale()).flatten();
            state.info.gradient_norm.min(own.unwrap_or(f64::INFINITY))
        });
        let mut report = NewtonIteration {
            iteration: 0,
            energy: state.energy,
            gradient_norm: state.info.gradient_norm,
            step: 0.0,
            t: 0.0,
            linear_iterations: 0,
            projection: HessianProjection::None,
            shift: 0.0,
        };
        observer(&report);

        let target = params
            .gradient_tolerance
            .max(params.relative_gradient_tolerance * reference);
        let mut forcing = Forcing::default();
        self.workspace.shift = Shift::default();
        let mut energy_scale = state.energy.abs();
        let mut trial = vec![0.0; x.len()];
        let mut gradient = vec![0.0; x.len()];
        loop {
            if state.info.gradient_norm <= params.gradient_tolerance {
                state.info.stop = StopReason::Gradient;
                return Ok(());
            }
            if state.info.gradient_norm <= params.relative_gradient_tolerance * reference {
                state.info.stop = StopReason::RelativeGradient;
                return Ok(());
            }
            if state.info.iterations == params.max_iterations {
                return Err(NewtonFailure::NotConverged);
            }
            let eta = forcing.next(norm(&state.gradient), target / state.info.gradient_norm);
            let direction = self
                .workspace
                .direction(problem, x, &state.gradient, eta, params)?;
            state.info.factorizations += direction.factorizations;
            state.info.linear_iterations += direction.linear_iterations;
            if direction.projection != HessianProjection::None || direction.shift > 0.0 {
                state.info.projected_steps += 1;
            }
            let start = Start {
                x,
                direction: &direction.dx,
                gradient: &state.gradient,
                energy: state.energy,
                energy_scale,
            };
            let Some(accepted) = search(
                problem,
                &start,
                &params.line_search,
                &mut trial,
                &mut gradient,
            ) else {
                let slope = dot(&state.gradient, &direction.dx);
                return Err(NewtonFailure::LineSearchFailed { slope });
            };
            self.workspace.shift.stepped(accepted.t);
            x.copy_from_slice(&trial);
            std::mem::swap(&mut state.gradient, &mut gradient);
            state.energy = accepted.energy;
            // A start far away has an energy that soon says nothing about the rounding of the present.
            energy_scale = (0.1 * energy_scale).max(accepted.energy.abs());
            state.info.evaluations += accepted.evaluations;
            state.info.iterations += 1;
            state.info.gradient_norm = norm_inf(&state.gradient);
            let step = accepted.t * norm_inf(&direction.dx);
            report = NewtonIteration {
                iteration: state.info.iterations,
                energy: state.energy,
                gradient_norm: state.info.gradient_norm,
                step,
                t: accepted.t,
                linear_iterations: direction.linear_iterations,
                projection: direction.projection,
                shift: direction.shift,
            };
            observer(&report);
            if accepted.t == 1.0
                && step <= params.step_tolerance
                && state.info.gradient_norm > target
            {
                state.info.stop = StopReason::Step;
                return Ok(());
            }
        }
    }

    fn check(
        &self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
    ) -> Result<(), NewtonFailure> {
        let expected = D * problem.blocks();
        if x.len() != expected {
            return Err(NewtonFailure::Dimension {
                found: x.len(),
                expected,
            });
        }
        if let Some(index) = first_non_finite(x) {
            return Err(NewtonFailure::NonFinite {
                what: "the starting point",
                index,
            });
        }
        let (own, other) = (self.workspace.matrix.pattern(), problem.pattern());
        if !(Arc::ptr_eq(own, &other) || **own == *other) || own.blocks() != problem.blocks() {
            return Err(NewtonFailure::PatternMismatch);
        }
        Ok(())
    }

    /// Factors the exact Hessian at `x`, usually a solution: for sensitivities, to be used with
    /// [`CholeskyFactor::solve_many`].
    ///
    /// # Errors
    /// [`NewtonFailure::Cholesky`] when it is not positive definite: `x` is no strict minimum.
    pub fn factor_at(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
    ) -> Result<&CholeskyFactor<f64, D>, NewtonFailure> {
        self.check(problem, x)?;
        problem.hessian(x, HessianProjection::None, &mut self.workspace.matrix);
        Ok(self.workspace.factor()?)
    }

    /// The ordering and storage plan, made on first use.
    pub fn symbolic(&mut self) -> &Arc<SymbolicCholesky<D>> {
        self.workspace.symbolic()
    }

    /// The Hessian that was assembled last.
    pub fn matrix(&self) -> &BlockSymmetric<D> {
        &self.workspace.matrix
    }
}

/// Eisenstat & Walker (1996), choice 2 with its safeguard: `η = 0.9 (‖g‖/‖g₋₁‖)²`.
#[derive(Default)]
struct Forcing {
    previous: Option<(f64, f64)>,
}

impl Forcing {
    const FIRST: f64 = 0.1;
    const LARGEST: f64 = 0.3;
    const SMALLEST: f64 = 1e-12;

    /// `remaining` is the reduction that still separates the gradient from its target.
    fn next(&mut self, gradient: f64, remaining: f64) -> f64 {
        let eta = match self.previous {
            None => Self::FIRST,
            Some((before, eta)) => {
                let quadratic = 0.9 * (gradient / before).powi(2);
                let safeguard = 0.9 * eta * eta;
                if safeguard > 0.1 {
                    quadratic.max(safeguard)
                } else {
                    quadratic
                }
            }
        };
        // No more accuracy than the last step needs.
        let eta = eta
            .min(Self::LARGEST)
            .max(0.2 * remaining.min(1.0))
            .max(Self::SMALLEST);
        self.previous = Some((gradient, eta));
        eta
    }
}
