//! Where least squares may end.

use crate::fit_promise::{gauss_newton, gauss_newton_observed};
use crate::gauss_newton::{Problem, exponential, linear};
use fem_solvers::{
    Bounds, Damping, GaussNewtonFailure, GaussNewtonParams, GaussNewtonStop, LeastSquares,
};

#[test]
fn a_step_shortened_by_its_damping_is_no_end() {
    for initial in [1e-3, 1e3, 1e9, 1e12] {
        for damping in [
            Damping::Levenberg { initial },
            Damping::Marquardt { initial },
        ] {
            for scale in [1.0, 1e-4, 1e4] {
                let params = GaussNewtonParams {
                    damping,
                    residual_change: 1e-6 * scale,
                    step_tolerance: 1e-6,
                    ..Default::default()
                };
                let mut theta = [1.5, -0.4];
                let mut problem = Scaled(exponential(), scale);
                let info = gauss_newton(&mut problem, &mut theta, &params).unwrap();
                let off = (theta[0] - 2.0).abs().max((theta[1] + 0.7).abs());
                assert!(off < 1e-4, "{damping:?} {scale}: {theta:?} {info:?}");
            }
        }
    }
}

/// A problem in another unit of residuals.
struct Scaled<P>(P, f64);

impl<P: LeastSquares> LeastSquares for Scaled<P> {
    type Error = P::Error;
    fn residuals(&self) -> usize {
        self.0.residuals()
    }
    fn parameters(&self) -> usize {
        self.0.parameters()
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), P::Error> {
        self.0.residual(theta, r)?;
        r.iter_mut().for_each(|r| *r *= self.1);
        Ok(())
    }
    fn jacobian(&mut self, theta: &[f64], j: &mut [f64]) -> Result<(), P::Error> {
        self.0.jacobian(theta, j)?;
        j.iter_mut().for_each(|j| *j *= self.1);
        Ok(())
    }
}

/// θ to (1, 3), of which a bound lets the first go to 0.4 only: started there it is at its end, a
/// thousandth away it is not, and a start that the bound does not touch is none.
#[test]
fn a_start_without_a_free_gradient_is_the_end() {
    let mut problem = linear(vec![vec![1.0, 0.0], vec![0.0, 1.0]], vec![1.0, 3.0]);
    let params = GaussNewtonParams {
        damping: Damping::None,
        gradient_tolerance: 1e-6,
        bounds: Some(Bounds {
            lower: vec![0.0; 2],
            upper: vec![0.4, 9.0],
        }),
        ..Default::default()
    };
    for (start, steps) in [([0.4, 3.0], 0), ([0.4, 3.001], 1), ([0.3, 3.0], 1)] {
        let mut theta = start;
        let info = gauss_newton(&mut problem, &mut theta, &params).unwrap();
        assert_eq!(
            (info.stop, info.iterations),
            (GaussNewtonStop::Gradient, steps),
            "{start:?}"
        );
        assert!(
            (theta[0] - 0.4).abs() < 1e-9 && (theta[1] - 3.0).abs() < 1e-9,
            "{theta:?}"
        );
    }
}

#[test]
fn a_jacobian_that_leads_uphill_is_no_convergence() {
    let mut problem = Problem {
        m: 1,
        n: 1,
        r: |p: &[f64], r: &mut [f64]| {
            r[0] = p[0] - 1.0;
            Ok(())
        },
        j: |_: &[f64], j: &mut [f64]| j[0] = -1.0,
    };
    let error = gauss_newton(&mut problem, &mut [3.0], &Default::default()).unwrap_err();
    assert!(
        matches!(error.reason, GaussNewtonFailure::NoDecrease { .. }),
        "{error}"
    );
}

#[test]
fn a_bound_holds_whatever_the_steps_are_damped_with() {
    // Both parameters want beyond the box; without the clamp they would leave it in the first step.
    for damping in [Damping::None, Damping::Marquardt { initial: 1e-12 }] {
        let params = GaussNewtonParams {
            damping,
            bounds: Some(Bounds {
                lower: vec![-0.25, f64::NEG_INFINITY],
                upper: vec![f64::INFINITY, 0.125],
            }),
            ..Default::default()
        };
        // Coupled: the free parameter is solved with the other one on its bound, in the same step.
        let (a, b) = (vec![vec![1.0, 0.5], vec![0.0, 1.0]], vec![4.0, 7.0]);
        let mut theta = [0.0, 0.0];
        gauss_newton(
            &mut linear(a, b),
            &mut theta,
            &GaussNewtonParams {
                max_iterations: 1,
                ..params.clone()
            },
        )
        .unwrap_err();
        assert!(
            (theta[0] - 3.9375).abs() < 1e-9 && theta[1] == 0.125,
            "{theta:?}"
        );
        let (a, b) = (vec![vec![1.0, 0.0], vec![0.0, 1.0]], vec![-3.0, 7.0]);
        let mut theta = [0.0, 0.0];
        let mut largest: [f64; 2] = theta;
        let info = gauss_newton_observed(&mut linear(a, b), &mut theta, &params, &mut |i| {
            largest = [largest[0].min(i.theta[0]), largest[1].max(i.theta[1])];
        })
        .unwrap();
        assert_eq!(theta, [-0.25, 0.125]);
        assert_eq!((largest, info.at_bound), ([-0.25, 0.125], 2));
    }
}

/// r = (θ − 1, 4, 0; 0, 0, 12).
struct Groups;

impl LeastSquares for Groups {
    type Error = std::convert::Infallible;
    fn residuals(&self) -> usize {
        6
    }
    fn parameters(&self) -> usize {
        1
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), Self::Error> {
        r.copy_from_slice(&[theta[0] - 1.0, 4.0, 0.0, 0.0, 0.0, 12.0]);
        Ok(())
    }
    fn jacobian(&mut self, _: &[f64], j: &mut [f64]) -> Result<(), Self::Error> {
        j.copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Ok(())
    }
}

/// √((4² + 12²)/2), and a start that is off by less than its cost can show is at its end.
#[test]
fn a_residual_is_the_root_mean_square_of_its_groups() {
    let params = GaussNewtonParams {
        group_size: 3,
        ..GaussNewtonParams::default()
    };
    let mut theta = [5.0];
    let info = gauss_newton(&mut Groups, &mut theta, &params).unwrap();
    assert!((info.residual - 80.0_f64.sqrt()).abs() < 1e-12, "{info:?}");
    assert!((info.cost - 80.0).abs() < 1e-12);
    let strict = GaussNewtonParams {
        gradient_tolerance: 0.0,
        step_tolerance: 0.0,
        cost_tolerance: 0.0,
        ..params
    };
    let mut theta = [1.0 + 1e-9];
    let info = gauss_newton(&mut Groups, &mut theta, &strict).unwrap();
    assert!((theta[0] - 1.0).abs() < 1.1e-9, "{theta:?} {info:?}");
    assert!(info.residual_evaluations <= 2, "{info:?}");
}

/// r = 1 + cos θ from 0.3: the first step lands at 5.95, almost as high on the other side, where the model
/// saw the bottom. That gain of 0.01 is no end; the bottom is at π.
#[test]
fn a_step_that_gains_far_less_than_was_predicted_is_no_end() {
    let mut problem = Problem {
        m: 1,
        n: 1,
        r: |theta: &[f64], r: &mut [f64]| {
            r[0] = 1.0 + theta[0].cos();
            Ok(())
        },
        j: |theta: &[f64], j: &mut [f64]| j[0] = -theta[0].sin(),
    };
    let params = GaussNewtonParams {
        damping: Damping::Marquardt { initial: 0.171 },
        residual_change: 0.05,
        ..GaussNewtonParams::default()
    };
    let (mut theta, mut residuals) = ([0.3], Vec::new());
    let info = gauss_newton_observed(&mut problem, &mut theta, &params, &mut |i| {
        residuals.push(i.residual);
    })
    .unwrap();
    assert!((residuals[0] - residuals[1]).abs() < 0.05, "{residuals:?}");
    assert!(info.residual < 0.2, "{theta:?} {residuals:?}");
    assert_eq!(info.stop, GaussNewtonStop::ResidualChange);
}
