//! What comes after a solve: sensitivities, load steps, neighboring frames.

use crate::promise::{Newton, Summed};
use crate::rosenbrock::Rosenbrock;
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, LinearSolver, NewtonParams, NonlinearProblem,
};
use std::sync::Arc;

#[test]
fn the_factor_at_the_solution_gives_sensitivities() {
    // x(c) minimizes Rosenbrock + coupling; compare dx/dcoupling with a difference.
    let solve = |c: f64| {
        let problem = Rosenbrock::new(5, c);
        let mut x: Vec<f64> = (0..10).map(|i| 0.9 + 0.01 * i as f64).collect();
        x[0] = 0.5;
        let params = NewtonParams {
            gradient_tolerance: 1e-12,
            relative_gradient_tolerance: 0.0,
            ..Default::default()
        };
        Newton::new(&problem)
            .solve(&Pulled(&problem), &mut x, &params)
            .unwrap();
        x
    };
    let (c, h) = (2.0, 1e-4);
    let x = solve(c);
    let problem = Rosenbrock::new(5, c);
    let mut newton = Newton::new(&problem);
    // ∂g/∂c
    let mut rhs = vec![0.0; 10];
    for i in 1..5 {
        let gap = x[2 * i - 1] - x[2 * i];
        rhs[2 * i - 1] -= gap;
        rhs[2 * i] += gap;
    }
    newton
        .factor_at(&Pulled(&problem), &x)
        .unwrap()
        .solve_many(&mut rhs, 1);
    let (plus, minus) = (solve(c + h), solve(c - h));
    for i in 0..10 {
        let difference = (plus[i] - minus[i]) / (2.0 * h);
        assert!(
            (rhs[i] - difference).abs() < 1e-7,
            "{i}: {} {difference}",
            rhs[i]
        );
    }
}

/// Rosenbrock with a load, so that the minimum depends on the coupling.
struct Pulled<'a>(&'a Rosenbrock);

impl NonlinearProblem<2> for Pulled<'_> {
    fn blocks(&self) -> usize {
        self.0.blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        self.0.pattern()
    }
    fn energy(&self, x: &[f64]) -> f64 {
        self.0.energy(x) - 0.5 * x[0] - 0.3 * x[9]
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.0.gradient(x, g);
        g[0] -= 0.5;
        g[9] -= 0.3;
    }
    fn hessian(&self, x: &[f64], d: HessianProjection, out: &mut BlockSymmetric<2>) {
        self.0.hessian(x, d, out);
    }
}

impl Summed<2> for Pulled<'_> {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut terms = self.0.terms(x);
        terms[0].push(-0.5);
        terms[9].push(-0.3);
        terms
    }
}

#[test]
fn load_steps_shrink_on_failure_and_grow_on_success() {
    use fem_solvers::{ContinuationError, ContinuationParams, walk_load};
    let mut loads = Vec::new();
    let mut x = 0.0_f64;
    let info = walk_load(
        &mut x,
        &ContinuationParams::default(),
        |load, x: &mut f64| {
            loads.push(load);
            let far = load - *x > 0.3;
            *x = load;
            if far { Err("too far") } else { Ok(()) }
        },
    )
    .unwrap();
    assert_eq!(x, 1.0);
    assert!(info.steps >= 4 && info.failures >= 2 && loads.len() == info.steps + info.failures);
    let mut x = 0.0_f64;
    let outcome = walk_load(
        &mut x,
        &ContinuationParams::default(),
        |load, x: &mut f64| {
            if load > 0.4 {
                Err("wall")
            } else {
                *x = load;
                Ok(())
            }
        },
    );
    match outcome {
        Err(ContinuationError::Stuck {
            reached,
            step,
            info,
            source: "wall",
        }) => {
            assert_eq!(reached, x);
            assert!(reached <= 0.4 && reached > 0.39 && step < 0.01);
            assert!(info.steps > 2 && info.failures > 2);
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(x, x.clamp(0.39, 0.4));
}

#[test]
fn steps_that_make_no_sense_are_refused_by_name() {
    use fem_solvers::{ContinuationError, ContinuationParams, walk_load};
    let good = ContinuationParams::default();
    for (name, bad) in [
        (
            "first_step",
            ContinuationParams {
                first_step: f64::NAN,
                ..good
            },
        ),
        (
            "smallest_step",
            ContinuationParams {
                smallest_step: 1e-300,
                ..good
            },
        ),
        (
            "shrink",
            ContinuationParams {
                shrink: 1.0,
                ..good
            },
        ),
        (
            "growth",
            ContinuationParams {
                growth: 0.5,
                ..good
            },
        ),
    ] {
        let mut untouched = 7.0;
        let outcome = walk_load(&mut untouched, &bad, |_, _| Ok::<(), ()>(()));
        assert!(matches!(outcome, Err(ContinuationError::Params { what, .. }) if what == name));
        assert_eq!(untouched, 7.0);
    }
}

/// `x = s²` by a corrector that can only move by a tenth; with a predictor along the tangent `2 s`.
struct Parabola {
    predicts: bool,
    guesses: Vec<(f64, f64)>,
}

impl fem_solvers::Path for Parabola {
    type State = f64;
    type Error = f64;
    fn predict(&mut self, x: &mut f64, from: f64, to: f64) {
        if self.predicts {
            *x += 2.0 * from * (to - from);
        }
    }
    fn correct(&mut self, s: f64, x: &mut f64) -> Result<(), f64> {
        self.guesses.push((s, *x));
        let gap = s * s - *x;
        *x = s * s;
        if gap.abs() <= 0.1 { Ok(()) } else { Err(gap) }
    }
}

#[test]
fn a_predictor_lengthens_the_steps_and_starts_from_the_last_solution() {
    use fem_solvers::{ContinuationParams, follow_path};
    let walk = |predicts| {
        let mut path = Parabola {
            predicts,
            guesses: Vec::new(),
        };
        let mut x = 0.0;
        let info = follow_path(&mut path, &mut x, &ContinuationParams::default()).unwrap();
        assert_eq!(x, 1.0);
        (info, path.guesses)
    };
    let ((plain, _), (predicted, guesses)) = (walk(false), walk(true));
    // The tangent leaves the square of the step, √0.1 = 0.32; without it a step of ds costs 2 s ds.
    assert!(
        plain.steps >= 10 && predicted.steps <= 6,
        "{plain:?} {predicted:?}"
    );
    let mut last = 0.0;
    for (s, guess) in guesses {
        assert_eq!(guess, last * last + 2.0 * last * (s - last));
        if (s * s - guess).abs() <= 0.1 {
            last = s;
        }
    }
    assert_eq!(last, 1.0);
}

#[test]
fn a_neighboring_frame_is_solved_with_the_factor_of_the_last_one() {
    let params = NewtonParams {
        linear_solver: LinearSolver::DirectSingle,
        gradient_tolerance: 1e-11,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let mut newton = Newton::new(&Rosenbrock::new(30, 1.0));
    let mut x = vec![0.9; 60];
    let first = newton
        .solve(&Rosenbrock::new(30, 1.0), &mut x, &params)
        .unwrap();
    assert!((1..=first.iterations).contains(&first.factorizations));
    x.iter_mut()
        .enumerate()
        .for_each(|(i, v)| *v += 1e-3 * (i as f64).sin());
    let second = newton
        .solve(&Rosenbrock::new(30, 1.001), &mut x, &params)
        .unwrap();
    assert_eq!(second.factorizations, 0, "{second:?}");
    assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-10));
}
