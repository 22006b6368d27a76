//! The KKT systems alone: closed form, and what it says of input that makes no sense.
use aniso_mpm::MpmError;
use aniso_mpm::kkt::{ConstrainedProblem, Constraints, Kkt};

/// min ½ |x − target|² with x₀ + x₁ = sum.
struct Nearest {
    target: [f64; 2],
    sum: f64,
}
impl ConstrainedProblem for Nearest {
    fn unknowns(&self) -> usize {
        2
    }
    fn constraints(&self) -> usize {
        1
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let squares = (0..2).map(|i| (x[i] - self.target[i]).powi(2));
        0.5 * squares.sum::<f64>()
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        for i in 0..2 {
            g[i] = x[i] - self.target[i];
        }
    }
    fn hessian(&self, _: &[f64], d: &[f64], y: &mut [f64]) {
        y.copy_from_slice(d);
    }
    fn diagonal(&self, _: &[f64], stiffness: f64, diagonal: &mut [f64]) {
        diagonal.fill(1.0 + stiffness);
    }
    fn constraint(&self, x: &[f64], c: &mut [f64]) {
        c[0] = x[0] + x[1] - self.sum;
    }
    fn jacobian(&self, d: &[f64], y: &mut [f64]) {
        y[0] = d[0] + d[1];
    }
    fn jacobian_transpose(&self, lambda: &[f64], y: &mut [f64]) {
        y.fill(lambda[0]);
    }
}

const STIFFNESS: f64 = 1e6;
const SOLVER: Kkt = Kkt {
    constraints: Constraints::Relaxed {
        stiffness: STIFFNESS,
    },
    tolerance: 1e-12,
    max_iterations: 10,
};

#[test]
fn the_nearest_point_of_a_line_is_found() {
    let problem = Nearest {
        target: [1.0, 4.0],
        sum: 2.0,
    };
    let solution = SOLVER.solve(&problem, &[0.0, 0.0]).unwrap();
    // With κ: x = target − κ c, so c (1 + 2κ) = Σ target − sum.
    let c = 3.0 / (1.0 + 2.0 * STIFFNESS);
    let lambda = -STIFFNESS * c;
    assert!((solution.lambda[0] - lambda).abs() < 1e-12);
    for i in 0..2 {
        assert!((solution.x[i] - (problem.target[i] + lambda)).abs() < 1e-12);
    }
}

#[test]
fn a_problem_that_is_not_a_number_has_no_solution() {
    for (target, sum, start) in [
        ([f64::NAN, 4.0], 2.0, [0.0; 2]),
        ([1.0, f64::INFINITY], 2.0, [0.0; 2]),
        ([1.0, 4.0], f64::NAN, [0.0; 2]),
        ([1.0, 4.0], 2.0, [0.0, f64::NAN]),
    ] {
        let error = SOLVER.solve(&Nearest { target, sum }, &start).unwrap_err();
        assert!(
            matches!(error, MpmError::Solve { .. }),
            "{target:?} {sum} {start:?}: {error}"
        );
        assert!(error.to_string().contains("after 0 steps"), "{error}");
    }
}

#[test]
fn nonsense_is_named_and_the_last_iterate_kept() {
    let problem = Nearest {
        target: [1.0, 4.0],
        sum: 2.0,
    };
    for stiffness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let solver = Kkt {
            constraints: Constraints::Relaxed { stiffness },
            ..SOLVER
        };
        let error = solver.solve(&problem, &[0.0; 2]).unwrap_err();
        assert!(matches!(error, MpmError::Parameter { .. }), "{error}");
    }
    let error = SOLVER.solve(&problem, &[0.0; 3]).unwrap_err();
    assert!(
        matches!(error, MpmError::Length { found: 3, .. }),
        "{error}"
    );
    for tolerance in [0.0, -1e-9, f64::NAN] {
        let error = Kkt {
            tolerance,
            ..SOLVER
        }
        .solve(&problem, &[0.0; 2]);
        let error = error.unwrap_err();
        assert!(matches!(error, MpmError::Parameter { .. }), "{error}");
    }
    let hasty = Kkt {
        max_iterations: 1,
        ..SOLVER
    };
    let problem = Twice {
        weights: [1.0, 3.0, 0.1],
        sum: 4.0,
        second: 4.0,
    };
    let error = hasty.solve(&problem, &[0.0; 3]).unwrap_err();
    let MpmError::Newton { last, .. } = &error else {
        panic!("{error}");
    };
    // The linear constraint is met by the first step, the minimum is not.
    assert!((last.iter().sum::<f64>() - 4.0).abs() < 1e-4, "{last:?}");
}

/// min Σ wᵢ xᵢ²/2 + xᵢ⁴/4 with the same constraint twice: x₀ + x₁ + x₂ = sum, and twice that = twice
/// `second`.
struct Twice {
    weights: [f64; 3],
    sum: f64,
    second: f64,
}
impl ConstrainedProblem for Twice {
    fn unknowns(&self) -> usize {
        3
    }
    fn constraints(&self) -> usize {
        2
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let part = |i: usize| 0.5 * self.weights[i] * x[i].powi(2) + 0.25 * x[i].powi(4);
        (0..3).map(part).sum()
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        for i in 0..3 {
            g[i] = self.weights[i] * x[i] + x[i].powi(3);
        }
    }
    fn hessian(&self, x: &[f64], d: &[f64], y: &mut [f64]) {
        for i in 0..3 {
            y[i] = (self.weights[i] + 3.0 * x[i] * x[i]) * d[i];
        }
    }
    fn diagonal(&self, x: &[f64], stiffness: f64, diagonal: &mut [f64]) {
        for i in 0..3 {
            diagonal[i] = self.weights[i] + 3.0 * x[i] * x[i] + 5.0 * stiffness;
        }
    }
    fn constraint(&self, x: &[f64], c: &mut [f64]) {
        let sum: f64 = x.iter().sum();
        c.copy_from_slice(&[sum - self.sum, 2.0 * (sum - self.second)]);
    }
    fn jacobian(&self, d: &[f64], y: &mut [f64]) {
        let sum: f64 = d.iter().sum();
        y.copy_from_slice(&[sum, 2.0 * sum]);
    }
    fn jacobian_transpose(&self, lambda: &[f64], y: &mut [f64]) {
        y.fill(lambda[0] + 2.0 * lambda[1]);
    }
}

/// The step of a problem in another unit is the step in that unit: nothing is measured against 1.
#[test]
fn a_step_does_not_depend_on_the_unit() {
    let exact = Kkt {
        constraints: Constraints::Exact,
        ..SOLVER
    };
    for unit in [1e-18, 1.0, 1e18] {
        let problem = Nearest {
            target: [1.0 * unit, 4.0 * unit],
            sum: 2.0 * unit,
        };
        let step = exact.step(&problem, &[0.0; 2]).unwrap();
        for (dx, expected) in step.dx.iter().zip([-0.5, 2.5]) {
            assert!((dx / unit - expected).abs() < 1e-13, "{unit}: {dx}");
        }
        assert!((step.lambda[0] / unit + 1.5).abs() < 1e-12, "{unit}");
    }
}

#[test]
fn exact_constraints_are_met_exactly() {
    let exact = Kkt {
        constraints: Constraints::Exact,
        ..SOLVER
    };
    let mut problem = Twice {
        weights: [1.0, 3.0, 0.1],
        sum: 4.0,
        second: 4.0,
    };
    let solution = exact.solve(&problem, &[5.0, -3.0, 0.0]).unwrap();
    let x = &solution.x;
    assert!((x.iter().sum::<f64>() - 4.0).abs() < 1e-13);
    // Stationary: every ∂E/∂xᵢ is the same number, the force of both rows together.
    let force = solution.lambda[0] + 2.0 * solution.lambda[1];
    for i in 0..3 {
        let slope = problem.weights[i] * x[i] + x[i].powi(3);
        assert!((slope - force).abs() < 1e-11, "{slope} {force}");
    }
    // Hard constraints are the limit of relaxed ones: the distance falls like 1/κ.
    let distance = |stiffness: f64| {
        let relaxed = Kkt {
            constraints: Constraints::Relaxed { stiffness },
            ..SOLVER
        };
        let near = relaxed.solve(&problem, &[0.0; 3]).unwrap();
        let squares = near.x.iter().zip(x).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let ratio = distance(1e4) / distance(1e6);
    assert!((ratio - 100.0).abs() < 1.0, "{ratio}");
    // Started at its own solution it stays there.
    let again = exact.solve(&problem, x).unwrap();
    assert!(again.iterates.len() <= 2, "{:?}", again.iterates);
    // Rows that contradict each other have no solution.
    problem.second = 5.0;
    let error = exact.solve(&problem, &[0.0; 3]).unwrap_err();
    assert!(
        error.to_string().contains("no point meets the constraints"),
        "{error}"
    );
}
