//! Newton's method on small problems with known minima.

use crate::promise::{Newton, Summed};
use crate::rosenbrock::Rosenbrock;
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, LinearSolver, Merit, NewtonFailure,
    NewtonParams, NonlinearProblem, PreconditionerChoice, ProjectionPolicy, StopReason,
};
use std::sync::Arc;

fn solvers() -> [LinearSolver; 7] {
    let pcg = |preconditioner| LinearSolver::Pcg {
        preconditioner,
        max_iterations: 500,
    };
    [
        LinearSolver::Direct,
        LinearSolver::DirectSingle,
        LinearSolver::Auto,
        LinearSolver::QrLeastSquares,
        pcg(PreconditionerChoice::Identity),
        pcg(PreconditionerChoice::BlockJacobi),
        pcg(PreconditionerChoice::BlockIc0),
    ]
}

#[test]
fn every_linear_solver_finds_the_minimum_of_rosenbrock() {
    for linear_solver in solvers() {
        let problem = Rosenbrock::new(1, 0.0);
        let mut x = [-1.2, 1.0];
        let params = NewtonParams {
            linear_solver,
            gradient_tolerance: 1e-12,
            relative_gradient_tolerance: 0.0,
            ..Default::default()
        };
        // Exact steps need 21; inexact ones, which stop early by design, more of cheaper ones.
        let limit = if linear_solver == LinearSolver::Direct {
            25
        } else {
            40
        };
        let info = Newton::new(&problem)
            .solve(&problem, &mut x, &params)
            .unwrap();
        assert!(
            (x[0] - 1.0).abs() < 1e-10 && (x[1] - 1.0).abs() < 1e-10,
            "{linear_solver:?} {x:?}"
        );
        assert!(info.iterations <= limit, "{linear_solver:?} {info:?}");
    }
}

#[test]
fn an_indefinite_start_takes_projected_steps_and_then_none() {
    let problem = Rosenbrock::new(40, 3.0);
    // b > a²: negative curvature everywhere.
    let mut x: Vec<f64> = (0..80)
        .map(|i| if i % 2 == 0 { 0.1 } else { 2.0 })
        .collect();
    let mut seen = Vec::new();
    let params = NewtonParams {
        linear_solver: LinearSolver::Direct,
        gradient_tolerance: 1e-11,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let info = Newton::new(&problem)
        .solve_observed(&problem, &mut x, &params, &mut |i| seen.push(*i))
        .unwrap();
    assert!(info.projected_steps >= 1);
    assert_eq!(seen.len(), info.iterations + 1);
    assert_eq!(seen[1].projection, HessianProjection::Clamp);
    assert_eq!(seen.last().unwrap().projection, HessianProjection::None);
    assert!(seen.windows(2).all(|w| w[1].energy <= w[0].energy + 1e-12));
    assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-9), "{x:?}");
    // Quadratic at the end: the last step more than squares.
    let g: Vec<f64> = seen.iter().map(|i| i.gradient_norm).collect();
    assert!(g[g.len() - 1] < 1e-2 * g[g.len() - 2]);
}

#[test]
fn an_indefinite_start_takes_shifted_steps_and_then_none() {
    let problem = Rosenbrock::new(40, 3.0);
    let start: Vec<f64> = (0..80)
        .map(|i| if i % 2 == 0 { 0.1 } else { 2.0 })
        .collect();
    let mut x = start.clone();
    let mut seen = Vec::new();
    let params = NewtonParams {
        linear_solver: LinearSolver::Direct,
        projection: ProjectionPolicy::ExactThenShifted,
        gradient_tolerance: 1e-11,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let mut newton = Newton::new(&problem);
    let info = newton
        .solve_observed(&problem, &mut x, &params, &mut |i| seen.push(*i))
        .unwrap();
    assert_eq!(
        info.projected_steps,
        seen.iter().filter(|i| i.shift > 0.0).count()
    );
    assert!(seen[1].shift > 0.0 && seen[1].projection == HessianProjection::None);
    assert_eq!(seen.last().unwrap().shift, 0.0);
    assert!(seen.windows(2).all(|w| w[1].energy <= w[0].energy + 1e-12));
    assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-9), "{x:?}");
    // No share is remembered from one solve to the next, not even from one that was cut short.
    let cut = NewtonParams {
        max_iterations: 1,
        ..params
    };
    let mut y = start.clone();
    newton.solve(&problem, &mut y, &cut).unwrap_err();
    let mut y = start;
    let again = newton.solve(&problem, &mut y, &params).unwrap();
    assert!(again == info && y == x);
}

#[test]
fn an_indefinite_start_takes_blended_steps_and_then_none() {
    let problem = Rosenbrock::new(40, 3.0);
    let start: Vec<f64> = (0..80)
        .map(|i| if i % 2 == 0 { 0.1 } else { 2.0 })
        .collect();
    let params = NewtonParams {
        linear_solver: LinearSolver::Direct,
        projection: ProjectionPolicy::ExactThenBlended,
        gradient_tolerance: 1e-11,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let (mut x, mut seen) = (start, Vec::new());
    let info = Newton::new(&problem)
        .solve_observed(&problem, &mut x, &params, &mut |i| seen.push(*i))
        .unwrap();
    let blended = seen.iter().filter(|i| i.shift > 0.0);
    assert!(blended.clone().count() > 0 && info.projected_steps == blended.clone().count());
    for step in blended {
        assert!(step.shift <= 1.0 && step.projection == HessianProjection::Absolute);
    }
    let last = seen.last().unwrap();
    assert_eq!(
        (last.shift, last.projection),
        (0.0, HessianProjection::None)
    );
    assert!(seen.windows(2).all(|w| w[1].energy <= w[0].energy + 1e-12));
    assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-9), "{x:?}");
}

#[test]
fn a_second_solve_with_the_same_object_takes_no_step() {
    let problem = Rosenbrock::new(10, 1.0);
    let mut newton = Newton::new(&problem);
    let params = NewtonParams {
        gradient_tolerance: 1e-10,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let mut x = vec![0.5; 20];
    newton.solve(&problem, &mut x, &params).unwrap();
    let again = newton.solve(&problem, &mut x, &params).unwrap();
    assert_eq!((again.iterations, again.stop), (0, StopReason::Gradient));
    // The one that tells a minimum from a saddle.
    assert!(again.factorizations <= 1);
}

/// `½ k Σ (x_i − x_{i−1} − 1)⁴ + offset`: stiff, huge constant, so that energies round.
struct Offset(Rosenbrock, f64);

impl NonlinearProblem<2> for Offset {
    fn blocks(&self) -> usize {
        self.0.blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        self.0.pattern()
    }
    fn energy(&self, x: &[f64]) -> f64 {
        self.0.energy(x) + self.1
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.0.gradient(x, g);
    }
    fn hessian(&self, x: &[f64], d: HessianProjection, out: &mut BlockSymmetric<2>) {
        self.0.hessian(x, d, out);
    }
}

impl Summed<2> for Offset {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        self.0.terms(x)
    }
}

#[test]
fn gradients_fall_to_the_rounding_floor_though_energies_cannot_tell() {
    for offset in [0.0, 1e3, 1e6, -1e9] {
        for linear_solver in solvers() {
            let problem = Offset(Rosenbrock::new(6, 2.0), offset);
            let mut x = vec![0.7; 12];
            let params = NewtonParams {
                linear_solver,
                gradient_tolerance: 1e-12,
                relative_gradient_tolerance: 0.0,
                ..Default::default()
            };
            let info = Newton::new(&problem).solve(&problem, &mut x, &params);
            let info = info.unwrap_or_else(|e| panic!("{offset:e} {linear_solver:?}: {e}"));
            assert!(info.gradient_norm <= 1e-12);
        }
    }
}

/// `−ln x − ln(2 − x)` per unknown plus a pull: domain (0, 2).
struct Barrier {
    pattern: Arc<BlockPattern>,
    cap: Cap,
}

#[derive(PartialEq)]
enum Cap {
    None,
    Known,
}

impl NonlinearProblem<1> for Barrier {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        if x[0] > 0.0 && x[0] < 2.0 {
            -x[0].ln() - (2.0 - x[0]).ln() - 50.0 * x[0]
        } else {
            f64::INFINITY
        }
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = -1.0 / x[0] + 1.0 / (2.0 - x[0]) - 50.0;
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        out.values_mut()[0] = [[x[0].powi(-2) + (2.0 - x[0]).powi(-2)]];
    }
    fn largest_step(&self, x: &[f64], dx: &[f64]) -> f64 {
        let room = if dx[0] > 0.0 { 2.0 - x[0] } else { x[0] };
        if self.cap == Cap::Known && dx[0] != 0.0 {
            (0.99 * room / dx[0].abs()).min(1.0)
        } else {
            1.0
        }
    }
}

impl Summed<1> for Barrier {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![-1.0 / x[0], 1.0 / (2.0 - x[0]), -50.0]]
    }
}

#[test]
fn infinite_energy_outside_the_domain_only_shortens_steps() {
    // −1/x + 1/(2−x) = 50
    let exact = {
        let (mut lo, mut hi) = (1.0_f64, 2.0);
        for _ in 0..200 {
            let mid = 0.5 * (lo + hi);
            if -1.0 / mid + 1.0 / (2.0 - mid) < 50.0 {
                lo = mid
            } else {
                hi = mid
            }
        }
        lo
    };
    for cap in [Cap::None, Cap::Known] {
        let problem = Barrier {
            pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
            cap,
        };
        let mut x = [1.0];
        let params = NewtonParams {
            gradient_tolerance: 1e-9,
            relative_gradient_tolerance: 0.0,
            ..Default::default()
        };
        Newton::new(&problem)
            .solve(&problem, &mut x, &params)
            .unwrap();
        assert!((x[0] - exact).abs() < 1e-12);
        let mut outside = [2.5];
        let error = Newton::new(&problem)
            .solve(&problem, &mut outside, &params)
            .unwrap_err();
        assert!(
            matches!(error.reason, NewtonFailure::OutsideDomain { .. }),
            "{error}"
        );
        assert_eq!(outside, [2.5]);
    }
}

/// A rotation-like field without an energy: `g = (x + y³ − 1, y − x/2)`; its symmetric part as matrix.
struct Field(Arc<BlockPattern>);

impl NonlinearProblem<2> for Field {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.0.clone())
    }
    fn energy(&self, _: &[f64]) -> f64 {
        0.0
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = x[0] + 0.1 * x[1].powi(3) - 1.0;
        g[1] = x[1] - 0.1 * x[0];
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<2>) {
        let off = 0.5 * (0.3 * x[1] * x[1] - 0.1);
        out.values_mut()[0] = [[1.0, off], [off, 1.0]];
    }
    fn merit(&self) -> Merit {
        Merit::ResidualNorm
    }
}

impl Summed<2> for Field {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let first = vec![x[0], 0.1 * x[1] * x[1] * x[1], -1.0];
        vec![first, vec![x[1], -0.1 * x[0]]]
    }
}

#[test]
fn a_field_that_is_no_gradient_converges_by_its_norm() {
    let problem = Field(Arc::new(BlockPattern::from_adjacency(1, []).unwrap()));
    let mut x = [3.0, -2.0];
    let params = NewtonParams {
        gradient_tolerance: 1e-13,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap();
    assert!((x[1] - 0.1 * x[0]).abs() < 1e-12 && (x[0] + 0.1 * x[1].powi(3) - 1.0).abs() < 1e-12);
}

#[test]
fn failures_say_where_and_leave_the_last_good_state() {
    let problem = Rosenbrock::new(1, 0.0);
    let start = [-1.2, 1.0];
    let mut x = start;
    let params = NewtonParams {
        max_iterations: 3,
        gradient_tolerance: 1e-12,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let error = Newton::new(&problem)
        .solve(&problem, &mut x, &params)
        .unwrap_err();
    assert_eq!(error.reason, NewtonFailure::NotConverged);
    assert_eq!(error.iteration, 3);
    assert_eq!(error.energy, problem.energy(&x));
    assert!(error.energy < problem.energy(&start));

    let mut nan = [f64::NAN, 0.0];
    let error = Newton::new(&problem)
        .solve(&problem, &mut nan, &params)
        .unwrap_err();
    assert!(matches!(
        error.reason,
        NewtonFailure::NonFinite {
            what: "the starting point",
            index: 0
        }
    ));
    let error = Newton::new(&problem)
        .solve(&problem, &mut [0.0; 4], &params)
        .unwrap_err();
    assert_eq!(
        error.reason,
        NewtonFailure::Dimension {
            found: 4,
            expected: 2
        }
    );
    let other = Rosenbrock::new(2, 1.0);
    let error = Newton::new(&problem)
        .solve(&other, &mut [0.0; 4], &params)
        .unwrap_err();
    assert_eq!(error.reason, NewtonFailure::PatternMismatch);
    // An unreachable tolerance is an error with the gradient that was reached.
    let mut x = start;
    let params = NewtonParams {
        relative_gradient_tolerance: 0.0,
        gradient_tolerance: 1e-300,
        ..Default::default()
    };
    let outcome = Newton::new(&problem).solve(&problem, &mut x, &params);
    assert!(outcome.is_ok_and(|i| i.gradient_norm == 0.0) || (x[0] - 1.0).abs() < 1e-10);
}

#[test]
fn a_problem_without_unknowns_is_solved() {
    let problem = Rosenbrock::new(0, 0.0);
    let info = Newton::new(&problem)
        .solve(&problem, &mut [], &NewtonParams::default())
        .unwrap();
    assert_eq!(info.iterations, 0);
}

#[test]
fn a_solve_that_starts_at_its_own_solution_is_converged_to_rounding() {
    for linear_solver in solvers() {
        for tolerance in [1e-8, 0.0] {
            let params = NewtonParams {
                linear_solver,
                relative_gradient_tolerance: tolerance,
                ..Default::default()
            };
            let problem = Rosenbrock::new(8, 2.0);
            let mut x = vec![0.3; 16];
            let mut newton = Newton::new(&problem);
            let first = newton.solve(&problem, &mut x, &params);
            let first = first.unwrap_or_else(|e| panic!("{linear_solver:?} {tolerance}: {e}"));
            assert!(first.gradient_norm < 1e-4);
            let mut steps = Vec::new();
            for _ in 0..4 {
                let again = newton.solve(&problem, &mut x, &params);
                let again = again.unwrap_or_else(|e| panic!("{linear_solver:?} {tolerance}: {e}"));
                steps.push(again.iterations);
            }
            assert!(steps[2..].iter().all(|&s| s <= 1), "{steps:?}");
            let mut g = vec![0.0; 16];
            problem.gradient(&x, &mut g);
            // |K| is about 1000, |x| is 1.
            assert!(g.iter().all(|g| g.abs() < 4e-12), "{linear_solver:?} {g:?}");
        }
    }
}

#[test]
fn a_gradient_above_rounding_is_never_called_rounding() {
    let problem = Rosenbrock::new(8, 2.0);
    let mut x = vec![0.3; 16];
    let params = NewtonParams {
        max_iterations: 2,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let error = Newton::new(&problem).solve(&problem, &mut x, &params);
    assert_eq!(error.unwrap_err().reason, NewtonFailure::NotConverged);
}

#[test]
fn settings_that_are_no_sizes_are_refused() {
    let problem = Rosenbrock::new(1, 0.0);
    let default = NewtonParams::default;
    for bad in [-1e-9, f64::NAN, f64::INFINITY] {
        let mut decrease = default();
        decrease.line_search.sufficient_decrease = bad;
        let mut rounding = default();
        rounding.line_search.rounding = bad;
        let all = [
            NewtonParams {
                gradient_tolerance: bad,
                ..default()
            },
            NewtonParams {
                relative_gradient_tolerance: bad,
                ..default()
            },
            NewtonParams {
                reference: Some(bad),
                ..default()
            },
            NewtonParams {
                step_tolerance: bad,
                ..default()
            },
            NewtonParams {
                decrement_tolerance: bad,
                ..default()
            },
            decrease,
            rounding,
        ];
        for params in all {
            let mut x = [0.2, 0.3];
            let error = Newton::new(&problem).solve(&problem, &mut x, &params);
            let reason = error.unwrap_err().reason;
            assert!(
                matches!(reason, NewtonFailure::Params { value, .. } if value.to_bits() == bad.to_bits())
            );
        }
    }
}

/// (x² − 1)²/4 + y²/2, said to be a sum of large forces.
struct Saddle(Arc<BlockPattern>);

impl NonlinearProblem<2> for Saddle {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.0.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        0.25 * (x[0] * x[0] - 1.0).powi(2) + 0.5 * x[1] * x[1]
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g.copy_from_slice(&[(x[0] * x[0] - 1.0) * x[0], x[1]]);
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<2>) {
        let curvature = 3.0 * x[0] * x[0] - 1.0;
        let along = match projection {
            HessianProjection::None => curvature,
            _ => curvature.abs(),
        };
        out.values_mut()[0] = [[along, 0.0], [0.0, 1.0]];
    }
    fn gradient_scales(&self, _: &[f64]) -> Option<Vec<f64>> {
        Some(vec![1e5; 2])
    }
}

impl Summed<2> for Saddle {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![x[0] * x[0] * x[0], -x[0]], vec![x[1]]]
    }
}

#[test]
fn forces_that_cancel_at_a_saddle_are_no_equilibrium() {
    let problem = Saddle(Arc::new(BlockPattern::from_adjacency(1, []).unwrap()));
    for solver in solvers() {
        let params = NewtonParams {
            linear_solver: solver,
            ..NewtonParams::default()
        };
        let mut x = [1e-4, 0.0];
        let info = Newton::new(&problem).solve(&problem, &mut x, &params);
        let info = info.unwrap_or_else(|e| panic!("{solver:?}: {e}"));
        assert!((x[0].abs() - 1.0).abs() < 1e-3, "{solver:?}: {x:?}");
        assert!(info.iterations > 1);
        // At a minimum it takes no step.
        let info = Newton::new(&problem).solve(&problem, &mut x, &params);
        assert_eq!(info.unwrap().iterations, 0, "{solver:?}");
    }
}

#[test]
fn a_solve_ends_where_its_energy_has_nothing_more_to_gain() {
    // The least energy is 0, so a decrement is nearly the energy that a step starts from.
    let problem = Rosenbrock::new(4, 2.0);
    let mut params = NewtonParams {
        relative_gradient_tolerance: 0.0,
        linear_solver: LinearSolver::Direct,
        ..Default::default()
    };
    let solve = |params: &NewtonParams| {
        let (mut x, mut steps) = (vec![0.7; 8], Vec::new());
        let mut observe = |step: &fem_solvers::NewtonIteration| steps.push(*step);
        let mut newton = Newton::new(&problem);
        let info = newton.solve_observed(&problem, &mut x, params, &mut observe);
        (info.unwrap(), steps)
    };
    for tolerance in [1e-3, 1e-6, 1e-9] {
        params.decrement_tolerance = tolerance;
        let (info, steps) = solve(&params);
        assert_eq!(info.stop, StopReason::Decrement);
        let [.., before, last] = &steps[..] else {
            panic!("{steps:?}");
        };
        assert!(last.decrement <= tolerance && before.decrement > tolerance);
        assert!(
            (last.decrement / before.energy - 1.0).abs() < 0.05,
            "{steps:?}"
        );
        assert!(info.energy < 0.05 * tolerance, "{info:?}");
    }
    // The decrement of a projected Hessian says nothing about what is left.
    params.decrement_tolerance = 1e9;
    params.projection = ProjectionPolicy::AlwaysProjected;
    assert_ne!(solve(&params).0.stop, StopReason::Decrement);
}
