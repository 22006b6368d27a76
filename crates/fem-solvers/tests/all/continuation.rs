//! What comes after a solve: sensitivities, load steps, neighboring frames.

use crate::rosenbrock::Rosenbrock;
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, LinearSolver, Newton, NewtonParams,
    NonlinearProblem,
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
    fn pattern(&self) -> Arc<BlockPattern> {
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

#[test]
fn load_steps_shrink_on_failure_and_grow_on_success() {
    use fem_solvers::{LoadSteppingError, LoadSteppingParams, walk_load};
    let mut loads = Vec::new();
    let mut x = 0.0_f64;
    let info = walk_load(
        &mut x,
        &LoadSteppingParams::default(),
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
        &LoadSteppingParams::default(),
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
        Err(LoadSteppingError::Stuck {
            load,
            step,
            source: "wall",
        }) => {
            assert_eq!(load, x);
            assert!(load <= 0.4 && load > 0.39 && step < 0.01);
        }
        other => panic!("{other:?}"),
    }
    let bad = LoadSteppingParams {
        first_step: f64::NAN,
        ..Default::default()
    };
    assert!(matches!(
        walk_load(&mut x, &bad, |_, _| Ok::<(), ()>(())),
        Err(LoadSteppingError::Params)
    ));
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
