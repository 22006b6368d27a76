//! The Newton loop.

use super::forcing::Forcing;
use super::line_search::{Accepted, Start, by_gradient, search};
use super::padded;
use super::repair::{Direction, Workspace};
use super::shift::{ShareRule, Shift};
use super::target::{Target, Targets};
use super::{
    DescentDirection, HessianProjection, Merit, NewtonError, NewtonFailure, NewtonInfo,
    NewtonIteration, NewtonParams, NonlinearProblem, ProjectionPolicy, StopReason, Watch,
};
use crate::block_matrix::BlockSymmetric;
use crate::cholesky::{CholeskyFactor, SymbolicCholesky};
use crate::vector::{dot, first_non_finite, norm, norm_inf};
use std::sync::Arc;

/// Newton's method for one pattern: keeps the ordering, the analysis and all memory between solves.
/// `'d` is what directions of one's own may borrow; without them it is `'static`.
pub struct Newton<'d, const D: usize> {
    workspace: Workspace<'d, D>,
    watch: Option<Watch>,
}

/// Roundings of `x` that the sums of a gradient are allowed to amount to.
const ROUNDING_UNITS: f64 = 4.0;

/// A start whose gradient is this share of its target or less is far from a solution.
const FAR: f64 = 1e-5;

/// Where a solve stands.
struct State {
    gradient: Vec<f64>,
    energy: f64,
    /// Largest absolute energy of the last steps, older ones counted for less.
    energy_scale: f64,
    trial: Vec<f64>,
    trial_gradient: Vec<f64>,
    info: NewtonInfo,
}

/// A step taken.
struct Step {
    /// Was the direction that of the exact Hessian?
    exact: bool,
    report: NewtonIteration,
    /// The energy did not fall noticeably, nor did the gradient after the first step.
    stalled: bool,
}

impl Step {
    /// The tolerance that says so by the step alone.
    fn was_last(&self, params: &NewtonParams, merit: Merit) -> Option<StopReason> {
        let whole = self.report.t == 1.0;
        let by_decrement = params.decrement_tolerance > 0.0 && merit == Merit::Energy && self.exact;
        if whole && self.report.step <= params.step_tolerance {
            Some(StopReason::Step)
        } else if whole && by_decrement && self.report.decrement <= params.decrement_tolerance {
            Some(StopReason::Decrement)
        } else {
            None
        }
    }
}

impl State {
    fn new(unknowns: usize) -> Self {
        Self {
            gradient: vec![0.0; unknowns],
            energy: f64::NAN,
            energy_scale: f64::NAN,
            trial: vec![0.0; unknowns],
            trial_gradient: vec![0.0; unknowns],
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
        }
    }

    /// Evaluates the starting point.
    fn start<const D: usize>(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
    ) -> Result<(), NewtonFailure> {
        let energy = problem.energy_and_gradient(x, &mut self.gradient);
        (self.energy, self.energy_scale) = (energy, energy.abs());
        self.info.evaluations += 1;
        if energy.is_nan() && problem.merit() == Merit::Energy {
            return Err(NewtonFailure::NonFinite {
                what: "the energy of the starting point",
                index: 0,
            });
        }
        if energy == f64::INFINITY {
            return Err(NewtonFailure::OutsideDomain { energy });
        }
        if let Some(index) = first_non_finite(&self.gradient) {
            return Err(NewtonFailure::NonFinite {
                what: "the gradient",
                index,
            });
        }
        self.info.gradient_norm = norm_inf(&self.gradient);
        Ok(())
    }

    /// Moves to where the line search left the trial.
    fn accept(&mut self, x: &mut [f64], accepted: &Accepted) {
        x.copy_from_slice(&self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        self.energy = accepted.energy;
        // A start far away has an energy that soon says nothing about the rounding of the present.
        self.energy_scale = (0.1 * self.energy_scale).max(accepted.energy.abs());
        self.info.evaluations += accepted.evaluations;
        self.info.iterations += 1;
        self.info.gradient_norm = norm_inf(&self.gradient);
    }
}

impl NewtonIteration {
    fn start(state: &State) -> Self {
        Self {
            iteration: 0,
            energy: state.energy,
            gradient_norm: state.info.gradient_norm,
            step: 0.0,
            t: 0.0,
            decrement: 0.0,
            linear_iterations: 0,
            projection: HessianProjection::None,
            shift: 0.0,
        }
    }
}

impl<'d, const D: usize> Newton<'d, D> {
    /// A solver for every problem with the same pattern as this one.
    pub fn new(problem: &(impl NonlinearProblem<D> + ?Sized)) -> Self {
        Self {
            workspace: Workspace::new(problem),
            watch: None,
        }
    }

    /// The same with directions of one's own; [`NewtonParams::linear_solver`] is then not asked.
    pub fn with_direction(
        problem: &(impl NonlinearProblem<D> + ?Sized),
        direction: impl DescentDirection<D> + 'd,
    ) -> Self {
        Self::new(problem).directed_by(direction)
    }

    /// This solver, its analysis kept, with directions of one's own.
    #[must_use]
    pub fn directed_by(mut self, direction: impl DescentDirection<D> + 'd) -> Self {
        self.workspace.bring(direction);
        self
    }

    /// This solver, asking `watch` at the start and after every step of every solve.
    #[must_use]
    pub fn watched_by(mut self, watch: Watch) -> Self {
        self.watch = Some(watch);
        self
    }

    /// Makes this a solver for every problem with the pattern of `problem`; directions of one's own
    /// stay.
    pub fn renew(&mut self, problem: &(impl NonlinearProblem<D> + ?Sized)) {
        self.workspace.renew(problem);
    }

    /// Lets the next solve depend on none before it: factors and hierarchies that serve as long as they are
    /// good enough are dropped, the analysis stays.
    pub fn forget(&mut self) {
        self.workspace.forget();
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
        let mut state = State::new(x.len());
        let mut last = None;
        let mut observer = |step: &NewtonIteration| {
            last = (step.iteration > 0).then_some(*step);
            observer(step);
        };
        state.info.stop = self
            .run(problem, x, params, &mut observer, &mut state)
            .map_err(|reason| NewtonError {
                iteration: state.info.iterations,
                factorizations: state.info.factorizations,
                linear_iterations: state.info.linear_iterations,
                last: last.map(Box::new),
                energy: state.energy,
                gradient_norm: state.info.gradient_norm,
                undetermined: match reason.may_be_undetermined() {
                    true => problem.undetermined(x).map(String::into_boxed_str),
                    false => None,
                },
                reason,
            })?;
        state.info.energy = state.energy;
        Ok(state.info)
    }

    /// Steps until a test is met; whatever stops it, a gradient that is all rounding is a success.
    fn run(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &mut [f64],
        params: &NewtonParams,
        observer: &mut dyn FnMut(&NewtonIteration),
        state: &mut State,
    ) -> Result<StopReason, NewtonFailure> {
        params.check()?;
        self.check(problem, x)?;
        state.start(problem, x)?;
        observer(&NewtonIteration::start(state));
        let start = state.info.gradient_norm;
        self.workspace.shift = Shift::default();
        let mut forcing = Forcing::default();
        let targets = Targets::new(problem, params, x.len(), start);
        let mut target = targets.at(problem, x);
        let met = target.met_by(&state.gradient);
        // Without a step: what starts at its own solution has nothing to gain from one.
        let rounding = met.is_none() && self.is_rounding(problem, x, state, &target);
        self.workspace.current = met.is_none();
        let mut leaves_saddle = false;
        if let Some(stop) = met.or(rounding.then_some(StopReason::Rounding)) {
            if self.is_minimum(problem, x, params, state) {
                return Ok(stop);
            }
            leaves_saddle = true;
            self.workspace.current = false;
            self.workspace.shift = Shift::default();
        }
        if target.remaining(&state.gradient) < FAR {
            self.workspace.shift = Shift::FAR;
        }
        let mut last = NewtonIteration::start(state);
        loop {
            if self.watch.as_ref().is_some_and(|watch| watch.ends(&last)) {
                return Err(NewtonFailure::Cancelled);
            }
            let eta = forcing.next(norm(&state.gradient), target.remaining(&state.gradient));
            let step = match self.step(problem, x, eta, params, state) {
                Ok(step) => step,
                Err(_) if self.is_rounding(problem, x, state, &targets.at(problem, x)) => {
                    return Ok(StopReason::Rounding);
                }
                Err(failure) => return Err(failure),
            };
            observer(&step.report);
            last = step.report;
            target = targets.after_step(problem, x, &state.gradient, step.stalled);
            if let Some(stop) = target.met_by(&state.gradient) {
                if !leaves_saddle || step.stalled || self.is_minimum(problem, x, params, state) {
                    return Ok(stop);
                }
                continue;
            }
            if let Some(stop) = step.was_last(params, problem.merit()) {
                return Ok(stop);
            }
            if step.stalled && self.is_rounding(problem, x, state, &target) {
                return Ok(StopReason::Rounding);
            }
        }
    }

    /// Direction, line search, bookkeeping.
    fn step(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &mut [f64],
        eta: f64,
        params: &NewtonParams,
        state: &mut State,
    ) -> Result<Step, NewtonFailure> {
        if state.info.iterations >= params.max_iterations {
            return Err(NewtonFailure::NotConverged);
        }
        let direction = self.prepared_direction(problem, x, eta, params, state)?;
        if !direction.is_exact() {
            state.info.projected_steps += 1;
        }
        let start = Start {
            x,
            direction: &direction.dx,
            gradient: &state.gradient,
            energy: state.energy,
            energy_scale: state.energy_scale,
        };
        let (trial, gradient) = (&mut state.trial, &mut state.trial_gradient);
        let accepted =
            search(problem, &start, &params.line_search, trial, gradient).or_else(|| {
                let rounding = self.energy_rounding(problem, x);
                by_gradient(problem, &start, rounding, trial, gradient)
            });
        let Some(accepted) = accepted else {
            let slope = dot(&state.gradient, &direction.dx);
            return Err(NewtonFailure::LineSearchFailed { slope });
        };
        let before = state.info.gradient_norm;
        let decrement = -0.5 * dot(&state.gradient, &direction.dx);
        state.accept(x, &accepted);
        let left = state.info.gradient_norm / before;
        let rule = match params.projection {
            ProjectionPolicy::ExactThenBlended => ShareRule::PROJECTION,
            _ => ShareRule::DIAGONAL,
        };
        self.workspace.shift.stepped(rule, accepted.t, left);
        let fell = left <= 0.5;
        Ok(Step {
            exact: direction.is_exact(),
            stalled: !accepted.clear && (state.info.iterations == 1 || !fell),
            report: NewtonIteration {
                iteration: state.info.iterations,
                energy: state.energy,
                gradient_norm: state.info.gradient_norm,
                step: accepted.t * norm_inf(&direction.dx),
                t: accepted.t,
                decrement,
                linear_iterations: direction.linear_iterations,
                projection: direction.projection,
                shift: direction.shift,
            },
        })
    }

    /// The direction of a step, downhill in the problem as it is prepared for that step.
    fn prepared_direction(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        eta: f64,
        params: &NewtonParams,
        state: &mut State,
    ) -> Result<Direction, NewtonFailure> {
        let mut direction = self.counted_direction(problem, x, eta, params, state)?;
        if problem.prepare(x, &direction.dx) {
            state.energy = problem.energy_and_gradient(x, &mut state.gradient);
            state.energy_scale = state.energy_scale.max(state.energy.abs());
            state.info.evaluations += 1;
            state.info.gradient_norm = norm_inf(&state.gradient);
            if !(dot(&state.gradient, &direction.dx) < 0.0) {
                direction = self.counted_direction(problem, x, eta, params, state)?;
            }
        }
        Ok(direction)
    }

    fn counted_direction(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        eta: f64,
        params: &NewtonParams,
        state: &mut State,
    ) -> Result<Direction, NewtonFailure> {
        self.workspace.follow(problem);
        let direction = self
            .workspace
            .direction(problem, x, &state.gradient, eta, params)?;
        state.info.factorizations += direction.factorizations;
        state.info.linear_iterations += direction.linear_iterations;
        Ok(direction)
    }

    /// Whether the Hessian at a stationary start is positive definite as it is: forces that cancel at
    /// a saddle are no equilibrium that lasts, and steps lead away from it.
    fn is_minimum(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        params: &NewtonParams,
        state: &mut State,
    ) -> bool {
        // Nothing leads away from a gradient of zeros, and a residual need not be a gradient.
        if state.info.gradient_norm == 0.0 || problem.merit() != Merit::Energy {
            return true;
        }
        self.workspace.follow(problem);
        let first = Forcing::FIRST;
        let found = self
            .workspace
            .direction(problem, x, &state.gradient, first, params);
        found.is_ok_and(|found| {
            state.info.factorizations += found.factorizations;
            state.info.linear_iterations += found.linear_iterations;
            found.is_exact()
        })
    }

    /// Whether no entry of the gradient is larger than its tolerance or rounding: that of `x` itself,
    /// which moves entry `i` by `ε Σ_j |K_ij| |x_j|`, or what the problem knows of its own sums.
    fn is_rounding(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        state: &State,
        target: &Target,
    ) -> bool {
        let own = problem.gradient_rounding(x);
        let moved = self.moved_by_rounding(problem, x);
        state
            .gradient
            .iter()
            .zip(&moved)
            .enumerate()
            .all(|(i, (g, moved))| {
                let own = own.as_ref().and_then(|own| own.get(i)).copied();
                let own = own.unwrap_or(0.0);
                let floor = ROUNDING_UNITS * f64::EPSILON * moved;
                let floor = if floor >= own { floor } else { own };
                target.allows(i, *g) || (floor < f64::INFINITY && g.abs() <= floor)
            })
    }

    /// `Σ_j |K_ij| |x_j|` of the exact Hessian at `x`; zeros without a matrix.
    fn moved_by_rounding(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
    ) -> Vec<f64> {
        // A step that failed may have been prepared with another pattern.
        self.workspace.follow(problem);
        match &mut self.workspace.matrix {
            Some(matrix) => {
                padded::hessian(problem, x, HessianProjection::None, matrix);
                matrix.absolute_product(x)
            }
            None => vec![0.0; x.len()],
        }
    }

    /// A few `ε |x|ᵀ |K| |x|`: the rounding of an energy whose terms are as large as stiffness times squared
    /// positions. 0 where the merit is none, or without a matrix.
    fn energy_rounding(&mut self, problem: &(impl NonlinearProblem<D> + ?Sized), x: &[f64]) -> f64 {
        if problem.merit() != Merit::Energy {
            return 0.0;
        }
        let moved = self.moved_by_rounding(problem, x);
        let terms = x.iter().zip(&moved).map(|(x, moved)| x.abs() * moved);
        ROUNDING_UNITS * f64::EPSILON * terms.sum::<f64>()
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
        let fits = match (&self.workspace.matrix, problem.pattern()) {
            (None, None) => true,
            (Some(own), Some(other)) => {
                let own = own.pattern();
                (Arc::ptr_eq(own, &other) || **own == *other) && own.blocks() == problem.blocks()
            }
            _ => false,
        };
        if fits {
            Ok(())
        } else {
            Err(NewtonFailure::PatternMismatch)
        }
    }

    /// Factors the exact Hessian at `x`, usually a solution: for sensitivities, to be used with
    /// [`CholeskyFactor::solve_many`]. The solver gives its memory away with it.
    ///
    /// # Errors
    /// [`NewtonFailure::Cholesky`] when it is not positive definite: `x` is no strict minimum;
    /// [`NewtonFailure::NeedsMatrix`] when the problem gives none.
    pub fn factor_at(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
    ) -> Result<CholeskyFactor<f64, D>, NewtonFailure> {
        self.check(problem, x)?;
        let Workspace {
            matrix, factorizer, ..
        } = &mut self.workspace;
        let matrix = matrix.as_mut().ok_or(NewtonFailure::NeedsMatrix)?;
        padded::hessian(problem, x, HessianProjection::None, matrix);
        factorizer.factor(matrix)?.check_pivots(matrix)?;
        factorizer.take().ok_or(NewtonFailure::NeedsMatrix)
    }

    /// Solves `K dx = load` with the Hessian `K` at `x`, as a direction of a step is found: to
    /// `‖K dx − load‖ ≤ forcing ‖load‖`, and where `K` is not positive definite with what
    /// [`NewtonParams::projection`] makes of it.
    ///
    /// # Errors
    /// Whatever stops a step.
    pub fn linearized(
        &mut self,
        problem: &(impl NonlinearProblem<D> + ?Sized),
        x: &[f64],
        load: &[f64],
        forcing: f64,
        params: &NewtonParams,
    ) -> Result<Vec<f64>, NewtonFailure> {
        self.check(problem, x)?;
        if load.iter().all(|&v| v == 0.0) {
            return Ok(vec![0.0; x.len()]);
        }
        self.workspace.shift = Shift::default();
        self.workspace.current = false;
        let against: Vec<f64> = load.iter().map(|v| -v).collect();
        let found = self
            .workspace
            .direction(problem, x, &against, forcing, params)?;
        Ok(found.dx)
    }

    /// The ordering and storage plan, made on first use; `None` for a problem without a pattern.
    pub fn symbolic(&mut self) -> Option<&Arc<SymbolicCholesky<D>>> {
        let Workspace {
            matrix, factorizer, ..
        } = &mut self.workspace;
        matrix.as_ref().map(|matrix| factorizer.symbolic(matrix))
    }

    /// The Hessian that was assembled last; `None` for a problem without a pattern.
    pub fn matrix(&self) -> Option<&BlockSymmetric<D>> {
        self.workspace.matrix.as_ref()
    }
}
