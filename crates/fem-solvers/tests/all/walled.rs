//! Least squares whose steps cannot all be evaluated.

use crate::fit_promise::gauss_newton;
use fem_solvers::{GaussNewtonFailure, GaussNewtonParams, LeastSquares};

/// r = θ − 1 from θ = 0, where only `reach` of the way can be evaluated.
struct Walled {
    reach: f64,
}

impl LeastSquares for Walled {
    type Error = String;
    fn residuals(&self) -> usize {
        1
    }
    fn parameters(&self) -> usize {
        1
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), String> {
        if theta[0] > self.reach {
            return Err(format!("nothing at {}", theta[0]));
        }
        r[0] = theta[0] - 1.0;
        Ok(())
    }
    fn jacobian(&mut self, _: &[f64], j: &mut [f64]) -> Result<(), String> {
        j[0] = 1.0;
        Ok(())
    }
}

#[test]
fn trials_that_all_fail_are_no_convergence() {
    // No step but 0 can be evaluated; then steps up to a thousandth of the way.
    for reach in [0.0, 1e-3] {
        let params = GaussNewtonParams {
            residual_change: 1e-4,
            step_tolerance: 1e-9,
            ..GaussNewtonParams::default()
        };
        let mut theta = [0.0];
        let error = gauss_newton(&mut Walled { reach }, &mut theta, &params).unwrap_err();
        assert!(
            matches!(&error.reason, GaussNewtonFailure::Evaluation(e) if e.starts_with("nothing at"))
                || matches!(error.reason, GaussNewtonFailure::NotConverged),
            "{error}"
        );
        assert!(theta[0] <= reach && error.cost <= 0.5);
        if reach == 0.0 {
            assert!(matches!(error.reason, GaussNewtonFailure::Evaluation(_)));
        }
    }
    let mut theta = [0.0];
    gauss_newton(
        &mut Walled { reach: 2.0 },
        &mut theta,
        &GaussNewtonParams::default(),
    )
    .unwrap();
    assert!((theta[0] - 1.0).abs() < 1e-9);
}
