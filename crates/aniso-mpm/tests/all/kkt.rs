//! The relaxed KKT system alone: closed form, and what it says of input that makes no sense.
use aniso_mpm::MpmError;
use aniso_mpm::kkt::{ConstrainedProblem, RelaxedKkt};

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

const SOLVER: RelaxedKkt = RelaxedKkt {
    stiffness: 1e6,
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
    let c = 3.0 / (1.0 + 2.0 * SOLVER.stiffness);
    let lambda = -SOLVER.stiffness * c;
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
        assert!(error.to_string().contains("Newton step 0"), "{error}");
    }
}

#[test]
fn nonsense_is_named_and_the_last_iterate_kept() {
    let problem = Nearest {
        target: [1.0, 4.0],
        sum: 2.0,
    };
    for stiffness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let solver = RelaxedKkt {
            stiffness,
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
    // One step reaches the solution and a second one sees that it has; one alone does not know.
    let hasty = RelaxedKkt {
        max_iterations: 1,
        ..SOLVER
    };
    let error = hasty.solve(&problem, &[0.0; 2]).unwrap_err();
    let MpmError::Newton { last, .. } = &error else {
        panic!("{error}");
    };
    assert!((last[0] + last[1] - 2.0).abs() < 1e-5, "{last:?}");
}
