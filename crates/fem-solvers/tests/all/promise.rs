//! What a solve promises, checked by sums of its own: in these tests [`Newton`] stands for that of the
//! crate, and trusts no `Ok`.

use fem_solvers::{
    BlockSymmetric, DescentDirection, HessianProjection, NewtonError, NewtonInfo, NewtonIteration,
    NewtonParams, NonlinearProblem, StopReason, Watch,
};
use std::ops::{Deref, DerefMut};

/// A problem whose gradient is written twice.
pub trait Summed<const D: usize>: NonlinearProblem<D> {
    /// For each unknown the terms of ∂E/∂x, multiplied out.
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>>;
}

/// A solver whose every `Ok` is checked.
pub struct Newton<'d, const D: usize>(fem_solvers::Newton<'d, D>);

impl<'d, const D: usize> Newton<'d, D> {
    pub fn new(problem: &impl NonlinearProblem<D>) -> Self {
        Self(fem_solvers::Newton::new(problem))
    }

    pub fn with_direction(
        problem: &impl NonlinearProblem<D>,
        direction: impl DescentDirection<D> + 'd,
    ) -> Self {
        Self(fem_solvers::Newton::with_direction(problem, direction))
    }

    pub fn watched_by(self, watch: Watch) -> Self {
        Self(self.0.watched_by(watch))
    }

    #[track_caller]
    pub fn solve(
        &mut self,
        problem: &impl Summed<D>,
        x: &mut [f64],
        params: &NewtonParams,
    ) -> Result<NewtonInfo, NewtonError> {
        self.solve_observed(problem, x, params, &mut |_| {})
    }

    #[track_caller]
    pub fn solve_observed(
        &mut self,
        problem: &impl Summed<D>,
        x: &mut [f64],
        params: &NewtonParams,
        observer: &mut dyn FnMut(&NewtonIteration),
    ) -> Result<NewtonInfo, NewtonError> {
        let start = x.to_vec();
        let info = self.0.solve_observed(problem, x, params, observer)?;
        kept(problem, &start, x, params, info.stop);
        Ok(info)
    }
}

impl<'d, const D: usize> Deref for Newton<'d, D> {
    type Target = fem_solvers::Newton<'d, D>;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<const D: usize> DerefMut for Newton<'_, D> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// From the last term to the first, with what the additions lose (Neumaier 1974); and what a sum in
/// another order may differ by.
fn sum(terms: &[f64]) -> (f64, f64) {
    let (mut sum, mut lost, mut size) = (0.0_f64, 0.0, 0.0);
    for &term in terms.iter().rev() {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() {
            (sum - next) + term
        } else {
            (term - next) + sum
        };
        sum = next;
        size += term.abs();
    }
    (sum + lost, 4.0 * f64::EPSILON * size)
}

/// Fails unless every entry of the gradient at `x` is what a solve that began at `start` and ended with
/// `stop` allows.
#[track_caller]
pub fn kept<const D: usize>(
    problem: &impl Summed<D>,
    start: &[f64],
    x: &[f64],
    params: &NewtonParams,
    stop: StopReason,
) {
    let largest = |terms: Vec<Vec<f64>>| terms.iter().fold(0.0_f64, |m, t| m.max(sum(t).0.abs()));
    let scales = match params.reference {
        Some(reference) => vec![reference; x.len()],
        None => (problem.gradient_scales(x))
            .unwrap_or_else(|| vec![largest(problem.terms(start)); x.len()]),
    };
    let floor = rounding(problem, x);
    let terms = problem.terms(x);
    assert_eq!(terms.len(), x.len());
    for (i, terms) in terms.iter().enumerate() {
        let share = params.relative_gradient_tolerance * scales[i];
        let share = params.gradient_tolerance.max(share);
        let allowed = match stop {
            StopReason::Gradient => params.gradient_tolerance,
            StopReason::RelativeGradient => share,
            StopReason::Rounding => share.max(floor[i]),
            // Neither a short step nor a small decrement promises a gradient.
            _ => f64::INFINITY,
        };
        let (left, order) = sum(terms);
        assert!(
            left.abs() <= allowed + order,
            "{left:e} left of unknown {i}, {allowed:e} promised by {stop:?}"
        );
    }
}

/// 4 ε Σⱼ |Kᵢⱼ| |xⱼ| over the dense matrix, or what the problem says of its own sums where that is more.
fn rounding<const D: usize>(problem: &impl NonlinearProblem<D>, x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut floor = problem.gradient_rounding(x).unwrap_or(vec![0.0; n]);
    if let Some(pattern) = problem.pattern() {
        let mut matrix = BlockSymmetric::<D>::zeros(pattern);
        problem.hessian(x, HessianProjection::None, &mut matrix);
        let dense = matrix.to_dense();
        for (i, floor) in floor.iter_mut().enumerate() {
            let moved: f64 = (0..n).map(|j| (dense[i * n + j] * x[j]).abs()).sum();
            *floor = floor.max(4.0 * f64::EPSILON * moved);
        }
    }
    floor
}

#[test]
fn a_solve_that_claims_too_much_is_caught() {
    use crate::rosenbrock::Rosenbrock;
    let problem = Rosenbrock::new(6, 2.0);
    let start = vec![0.7; 12];
    let (mut x, params) = (start.clone(), NewtonParams::default());
    let info = Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    let claims = |x: &[f64], stop| {
        std::panic::catch_unwind(|| kept(&problem, &start, x, &params, stop)).is_ok()
    };
    assert!(claims(&x, info.stop));
    // Ten times what is allowed, in one unknown; what a tolerance of 0 would take; a NaN.
    let curvature = 200.0;
    let mut off = x.clone();
    off[1] += 10.0 * 1e-8 * 400.0 / curvature;
    assert!(!claims(&off, StopReason::RelativeGradient));
    assert!(!claims(&off, StopReason::Rounding) && !claims(&x, StopReason::Gradient));
    off[1] = f64::NAN;
    assert!(!claims(&off, StopReason::RelativeGradient));
}
