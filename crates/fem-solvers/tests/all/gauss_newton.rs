//! Nonlinear least squares against known optima.

use crate::fit_promise::{gauss_newton, gauss_newton_observed};
use fem_solvers::{
    Bounds, Damping, GaussNewtonFailure, GaussNewtonParams, GaussNewtonStop, LeastSquares, Loss,
    Prior, StepMethod,
};

/// A problem from two closures; fails on demand.
pub struct Problem<R, J> {
    pub m: usize,
    pub n: usize,
    pub r: R,
    pub j: J,
}

impl<R, J> LeastSquares for Problem<R, J>
where
    R: FnMut(&[f64], &mut [f64]) -> Result<(), String>,
    J: FnMut(&[f64], &mut [f64]),
{
    type Error = String;
    fn residuals(&self) -> usize {
        self.m
    }
    fn parameters(&self) -> usize {
        self.n
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), String> {
        (self.r)(theta, r)
    }
    fn jacobian(&mut self, theta: &[f64], j: &mut [f64]) -> Result<(), String> {
        (self.j)(theta, j);
        Ok(())
    }
}

/// `y = a e^{b t}` on exact data, a = 2, b = −0.7.
pub fn exponential() -> impl LeastSquares<Error = String> {
    let times: Vec<f64> = (0..20).map(|i| 0.2 * i as f64).collect();
    let (t1, t2) = (times.clone(), times);
    Problem {
        m: 20,
        n: 2,
        r: move |p: &[f64], r: &mut [f64]| {
            for (r, t) in r.iter_mut().zip(&t1) {
                *r = p[0] * (p[1] * t).exp() - 2.0 * (-0.7 * t).exp();
            }
            Ok(())
        },
        j: move |p: &[f64], j: &mut [f64]| {
            for (i, t) in t2.iter().enumerate() {
                j[i] = (p[1] * t).exp();
                j[20 + i] = p[0] * t * (p[1] * t).exp();
            }
        },
    }
}

#[test]
fn every_method_finds_the_exponential() {
    for method in [StepMethod::Qr, StepMethod::NormalEquations] {
        for damping in [
            Damping::None,
            Damping::Levenberg { initial: 1e-3 },
            Damping::Marquardt { initial: 1e-3 },
        ] {
            let mut theta = [1.5, -0.4];
            let params = GaussNewtonParams {
                method,
                damping,
                residual_tolerance: 1e-11,
                ..Default::default()
            };
            let info = gauss_newton(&mut exponential(), &mut theta, &params).unwrap();
            assert!(
                (theta[0] - 2.0).abs() < 1e-9 && (theta[1] + 0.7).abs() < 1e-9,
                "{method:?} {damping:?}"
            );
            assert!(
                info.iterations <= 12 && info.jacobian_evaluations <= 13,
                "{info:?}"
            );
            assert_eq!(info.stop, GaussNewtonStop::Residual);
        }
    }
}

#[test]
fn undamped_steps_are_the_exact_gauss_newton_steps() {
    let mut theta = [1.5, -0.4];
    let mut path = Vec::new();
    let params = GaussNewtonParams {
        damping: Damping::None,
        max_iterations: 4,
        ..Default::default()
    };
    let outcome = gauss_newton_observed(&mut exponential(), &mut theta, &params, &mut |i| {
        path.push(i.theta.to_vec())
    });
    assert!(matches!(
        outcome.unwrap_err().reason,
        GaussNewtonFailure::NotConverged
    ));
    let mut expected = vec![1.5, -0.4];
    for visited in path {
        for k in 0..2 {
            assert!((visited[k] - expected[k]).abs() < 1e-12);
        }
        // d = −(JᵀJ)⁻¹ Jᵀr by Cramer's rule
        let mut problem = exponential();
        let (mut r, mut j) = (vec![0.0; 20], vec![0.0; 40]);
        problem.residual(&expected, &mut r).unwrap();
        problem.jacobian(&expected, &mut j).unwrap();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (a, b) = j.split_at(20);
        let (aa, ab, bb, ar, br) = (dot(a, a), dot(a, b), dot(b, b), dot(a, &r), dot(b, &r));
        let det = aa * bb - ab * ab;
        expected[0] -= (bb * ar - ab * br) / det;
        expected[1] -= (aa * br - ab * ar) / det;
    }
}

/// Linear residuals `A θ − b`.
pub fn linear(a: Vec<Vec<f64>>, b: Vec<f64>) -> impl LeastSquares<Error = String> {
    let (m, n) = (b.len(), a[0].len());
    let a2 = a.clone();
    Problem {
        m,
        n,
        r: move |p: &[f64], r: &mut [f64]| {
            for i in 0..m {
                r[i] = (0..n).map(|k| a[i][k] * p[k]).sum::<f64>() - b[i];
            }
            Ok(())
        },
        j: move |_: &[f64], j: &mut [f64]| {
            for i in 0..m {
                for k in 0..n {
                    j[k * m + i] = a2[i][k];
                }
            }
        },
    }
}

fn three() -> impl LeastSquares<Error = String> {
    linear(
        vec![
            vec![2.0, 1.0, 0.0],
            vec![1.0, 3.0, 1.0],
            vec![0.0, 1.0, 4.0],
            vec![1.0, 1.0, 1.0],
        ],
        vec![1.0, 10.0, -3.0, 2.0],
    )
}

/// The optimality conditions of a bounded problem, checked from scratch.
fn check_kkt(problem: &mut impl LeastSquares<Error = String>, theta: &[f64], bounds: &Bounds) {
    let (m, n) = (problem.residuals(), problem.parameters());
    let (mut r, mut j) = (vec![0.0; m], vec![0.0; m * n]);
    problem.residual(theta, &mut r).unwrap();
    problem.jacobian(theta, &mut j).unwrap();
    for k in 0..n {
        let g: f64 = (0..m).map(|i| j[k * m + i] * r[i]).sum();
        if theta[k] == bounds.lower[k] {
            assert!(g > -1e-8, "{k}: {g}");
        } else if theta[k] == bounds.upper[k] {
            assert!(g < 1e-8, "{k}: {g}");
        } else {
            assert!(g.abs() < 1e-7, "{k}: {g}");
        }
    }
}

#[test]
fn bounded_linear_problems_satisfy_the_optimality_conditions() {
    for (lower, upper) in [(-10.0, 10.0), (-0.5, 2.0), (0.0, 1.0), (0.3, 0.4)] {
        for damping in [Damping::None, Damping::Marquardt { initial: 1e-3 }] {
            for method in [StepMethod::Qr, StepMethod::NormalEquations] {
                let bounds = Bounds {
                    lower: vec![lower; 3],
                    upper: vec![upper; 3],
                };
                let params = GaussNewtonParams {
                    bounds: Some(bounds.clone()),
                    damping,
                    method,
                    ..Default::default()
                };
                let mut theta = [5.0, -5.0, 0.35];
                if lower > -5.0 {
                    let refused = gauss_newton(&mut three(), &mut theta, &params).unwrap_err();
                    assert!(matches!(refused.reason, GaussNewtonFailure::Params { .. }));
                    assert_eq!(theta, [5.0, -5.0, 0.35]);
                }
                let mut theta = theta.map(|t: f64| t.clamp(lower, upper));
                gauss_newton(&mut three(), &mut theta, &params).unwrap();
                assert!(theta.iter().all(|t| (lower..=upper).contains(t)));
                check_kkt(&mut three(), &theta, &bounds);
            }
        }
    }
}

#[test]
fn bounded_rosenbrock_stops_on_the_bound() {
    // r = (10 (y − x²), 1 − x), x ≤ 0.8: the optimum is (0.8, 0.64).
    let mut problem = Problem {
        m: 2,
        n: 2,
        r: |p: &[f64], r: &mut [f64]| {
            r.copy_from_slice(&[10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]);
            Ok(())
        },
        j: |p: &[f64], j: &mut [f64]| j.copy_from_slice(&[-20.0 * p[0], -1.0, 10.0, 0.0]),
    };
    let mut theta = [-1.2, 1.0];
    let bounds = Bounds {
        lower: vec![f64::NEG_INFINITY; 2],
        upper: vec![0.8, f64::INFINITY],
    };
    let params = GaussNewtonParams {
        bounds: Some(bounds),
        ..Default::default()
    };
    let info = gauss_newton(&mut problem, &mut theta, &params).unwrap();
    assert!(
        (theta[0] - 0.8).abs() < 1e-12 && (theta[1] - 0.64).abs() < 1e-9,
        "{theta:?}"
    );
    assert_eq!(info.at_bound, 1);
    let mut theta = [-1.2, 1.0];
    gauss_newton(&mut problem, &mut theta, &GaussNewtonParams::default()).unwrap();
    assert!((theta[0] - 1.0).abs() < 1e-9 && (theta[1] - 1.0).abs() < 1e-9);
}

#[test]
fn a_prior_pulls_as_its_weight_says() {
    // One residual θ − 1 and a prior w (θ − 5)²: θ = (1 + 5 w) / (1 + w).
    for w in [0.0, 0.5, 3.0] {
        for method in [StepMethod::Qr, StepMethod::NormalEquations] {
            let prior = Prior {
                weights: vec![w],
                values: vec![5.0],
            };
            let params = GaussNewtonParams {
                prior: Some(prior),
                method,
                damping: Damping::None,
                ..Default::default()
            };
            let mut theta = [0.0];
            gauss_newton(&mut linear(vec![vec![1.0]], vec![1.0]), &mut theta, &params).unwrap();
            assert!((theta[0] - (1.0 + 5.0 * w) / (1.0 + w)).abs() < 1e-14);
        }
    }
}

#[test]
fn robust_losses_are_smooth_and_ignore_an_outlier() {
    let losses = [
        Loss::Huber { scale: 0.1 },
        Loss::Cauchy { scale: 0.1 },
        Loss::GemanMcClure { scale: 0.1 },
    ];
    for loss in losses {
        for s in [1e-6, 0.005, 0.02, 3.0] {
            let h = 1e-6 * s;
            let slope = (loss.value(s + h) - loss.value(s - h)) / (2.0 * h);
            assert!((slope - loss.weight(s)).abs() < 1e-6, "{loss:?} {s}");
        }
        // Points in the plane on a common offset (0.3, −0.2), one of them 10 away.
        let mut b: Vec<f64> = (0..10).flat_map(|_| [0.3, -0.2]).collect();
        b[6] += 10.0;
        let a = (0..20)
            .map(|i| {
                if i % 2 == 0 {
                    vec![1.0, 0.0]
                } else {
                    vec![0.0, 1.0]
                }
            })
            .collect();
        let params = GaussNewtonParams {
            loss,
            group_size: 2,
            ..Default::default()
        };
        let mut theta = [0.0, 0.0];
        gauss_newton(&mut linear(a, b), &mut theta, &params).unwrap();
        // The mean would be off by 1; Huber's bound on the pull of one in ten is scale/9.
        assert!(
            (theta[0] - 0.3).abs() < 0.0125 && (theta[1] + 0.2).abs() < 1e-3,
            "{loss:?} {theta:?}"
        );
    }
}

#[test]
fn a_lost_rank_is_named_and_damping_or_a_prior_cures_it() {
    let make = || {
        linear(
            vec![vec![1.0, 2.0], vec![2.0, 4.0], vec![-1.0, -2.0]],
            vec![1.0, 2.0, -1.0],
        )
    };
    for method in [StepMethod::Qr, StepMethod::NormalEquations] {
        let params = GaussNewtonParams {
            method,
            damping: Damping::None,
            ..Default::default()
        };
        let mut theta = [0.0, 0.0];
        let error = gauss_newton(&mut make(), &mut theta, &params).unwrap_err();
        assert!(
            matches!(
                error.reason,
                GaussNewtonFailure::RankDeficient {
                    rank: 1,
                    free: 2,
                    ..
                }
            ),
            "{error}"
        );
        assert_eq!(theta, [0.0, 0.0]);
        let damped = GaussNewtonParams {
            method,
            residual_tolerance: 1e-9,
            ..Default::default()
        };
        gauss_newton(&mut make(), &mut theta, &damped).unwrap();
        assert!((theta[0] + 2.0 * theta[1] - 1.0).abs() < 1e-8);
        let prior = Some(Prior {
            weights: vec![1e-3; 2],
            values: vec![0.0; 2],
        });
        let params = GaussNewtonParams {
            method,
            damping: Damping::None,
            prior,
            ..Default::default()
        };
        assert!(gauss_newton(&mut make(), &mut [0.0, 0.0], &params).is_ok());
    }
    // Fewer residuals than parameters.
    let params = GaussNewtonParams {
        damping: Damping::None,
        ..Default::default()
    };
    let error = gauss_newton(
        &mut linear(vec![vec![1.0, 2.0]], vec![1.0]),
        &mut [0.0, 0.0],
        &params,
    )
    .unwrap_err();
    assert!(matches!(
        error.reason,
        GaussNewtonFailure::RankDeficient { rank: 1, .. }
    ));
}

#[test]
fn errors_of_the_problem_pass_through_and_damping_steps_around_them() {
    let make = || Problem {
        m: 1,
        n: 1,
        // Defined for θ > 0 only; ln θ from θ = 20 overshoots.
        r: |p: &[f64], r: &mut [f64]| {
            if p[0] <= 0.0 {
                return Err(format!("undefined at {}", p[0]));
            }
            r[0] = p[0].ln();
            Ok(())
        },
        j: |p: &[f64], j: &mut [f64]| j[0] = 1.0 / p[0],
    };
    let params = GaussNewtonParams {
        damping: Damping::None,
        ..Default::default()
    };
    let mut theta = [20.0];
    let error = gauss_newton(&mut make(), &mut theta, &params).unwrap_err();
    assert!(
        matches!(&error.reason, GaussNewtonFailure::Evaluation(e) if e.starts_with("undefined at -")),
        "{error}"
    );
    assert_eq!(theta, [20.0]);
    let mut theta = [20.0];
    gauss_newton(&mut make(), &mut theta, &GaussNewtonParams::default()).unwrap();
    assert!((theta[0] - 1.0).abs() < 1e-9);
    let error = gauss_newton(&mut make(), &mut [-1.0], &GaussNewtonParams::default()).unwrap_err();
    assert!(matches!(error.reason, GaussNewtonFailure::Evaluation(_)) && error.iteration == 0);
}

#[test]
fn wrong_settings_and_bad_numbers_are_refused() {
    let reason = |params: GaussNewtonParams| {
        gauss_newton(&mut three(), &mut [0.0; 3], &params)
            .unwrap_err()
            .reason
    };
    let base = GaussNewtonParams::default;
    for (name, params) in [
        (
            "group_size",
            GaussNewtonParams {
                group_size: 3,
                ..base()
            },
        ),
        (
            "group_size",
            GaussNewtonParams {
                group_size: 0,
                ..base()
            },
        ),
        (
            "the scale of the loss",
            GaussNewtonParams {
                loss: Loss::Huber { scale: f64::NAN },
                ..base()
            },
        ),
        (
            "the first damping",
            GaussNewtonParams {
                damping: Damping::Levenberg { initial: 0.0 },
                ..base()
            },
        ),
        (
            "a lower bound",
            GaussNewtonParams {
                bounds: Some(Bounds {
                    lower: vec![1.0; 3],
                    upper: vec![0.0; 3],
                }),
                ..base()
            },
        ),
        (
            "a lower bound",
            GaussNewtonParams {
                bounds: Some(Bounds {
                    lower: vec![f64::NAN; 3],
                    upper: vec![0.0; 3],
                }),
                ..base()
            },
        ),
        (
            "a prior weight",
            GaussNewtonParams {
                prior: Some(Prior {
                    weights: vec![-1.0; 3],
                    values: vec![0.0; 3],
                }),
                ..base()
            },
        ),
    ] {
        let found = reason(params);
        assert!(
            matches!(found, GaussNewtonFailure::Params { what, .. } if what == name),
            "{name}: {found:?}"
        );
    }
    let short = GaussNewtonParams {
        prior: Some(Prior {
            weights: vec![1.0; 2],
            values: vec![0.0; 2],
        }),
        ..base()
    };
    let expected = GaussNewtonFailure::Length {
        what: "prior.weights",
        found: 2,
        expected: 3,
    };
    assert_eq!(reason(short), expected);
    let error = gauss_newton(&mut three(), &mut [0.0, f64::NAN, 0.0], &base()).unwrap_err();
    assert!(matches!(
        error.reason,
        GaussNewtonFailure::NonFinite {
            what: "theta",
            index: 1
        }
    ));
    let mut nan = Problem {
        m: 1,
        n: 1,
        r: |_: &[f64], r: &mut [f64]| {
            r[0] = 1.0;
            Ok(())
        },
        j: |_: &[f64], j: &mut [f64]| j[0] = f64::NAN,
    };
    let error = gauss_newton(&mut nan, &mut [0.0], &base()).unwrap_err();
    assert!(matches!(
        error.reason,
        GaussNewtonFailure::NonFinite {
            what: "the Jacobian",
            index: 0
        }
    ));
    // Nothing to fit.
    let mut nothing = Problem {
        m: 0,
        n: 0,
        r: |_: &[f64], _: &mut [f64]| Ok(()),
        j: |_: &[f64], _: &mut [f64]| {},
    };
    assert!(gauss_newton(&mut nothing, &mut [], &base()).is_ok());
}

/// `r = θ − far`, which must never be asked beyond `upper`.
struct Fenced {
    far: f64,
    upper: f64,
}

impl LeastSquares for Fenced {
    type Error = String;
    fn residuals(&self) -> usize {
        1
    }
    fn parameters(&self) -> usize {
        1
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), String> {
        if theta[0] > self.upper {
            return Err(format!("{} is beyond {}", theta[0], self.upper));
        }
        r[0] = theta[0] - self.far;
        Ok(())
    }
    fn jacobian(&mut self, _: &[f64], j: &mut [f64]) -> Result<(), String> {
        j[0] = 1.0;
        Ok(())
    }
}

#[test]
fn rounding_does_not_carry_a_step_over_its_bound() {
    let mut rounded_over = 0;
    for k in 0..200 {
        let (start, upper) = (-0.1 * f64::from(k) - 0.013, 0.7 + 0.001 * f64::from(k));
        rounded_over += usize::from(start + (upper - start) > upper);
        for damping in [Damping::None, Damping::Marquardt { initial: 1e-9 }] {
            let params = GaussNewtonParams {
                damping,
                bounds: Some(Bounds {
                    lower: vec![-1e3],
                    upper: vec![upper],
                }),
                ..Default::default()
            };
            let mut theta = [start];
            let mut problem = Fenced { far: 1e3, upper };
            gauss_newton(&mut problem, &mut theta, &params).unwrap();
            assert!(theta[0] <= upper && upper - theta[0] < 1e-14, "{damping:?}");
        }
    }
    assert!(rounded_over > 10, "{rounded_over}");
}
