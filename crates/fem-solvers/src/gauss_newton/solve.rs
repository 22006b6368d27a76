//! The Gauss-Newton and Levenberg-Marquardt loop.

use super::linear_step::{Model, RankLoss, blocked};
use super::{
    Damping, GaussNewtonError, GaussNewtonFailure, GaussNewtonInfo, GaussNewtonIteration,
    GaussNewtonParams, GaussNewtonStop, LeastSquares,
};
use crate::vector::{first_non_finite, norm_inf};

/// Minimizes `½ Σ_g ρ(‖r_g(θ)‖²) + ½ Σ_k w_k (θ_k − p_k)²` within bounds, from `theta`.
///
/// With [`Damping::None`] every step is the full Gauss-Newton step `θ += d`, `J d ≈ −r`
/// (document 000, section 5.3). With damping, a step must lower the cost; one whose evaluation fails
/// counts as one that does not.
///
/// # Errors
/// [`GaussNewtonError`]; `theta` then holds the last accepted parameters.
///
/// ```
/// use fem_solvers::{gauss_newton, GaussNewtonParams, LeastSquares};
/// struct Circle; // r = (θ₀² + θ₁² − 1, θ₀ − θ₁)
/// impl LeastSquares for Circle {
///     type Error = std::convert::Infallible;
///     fn residuals(&self) -> usize { 2 }
///     fn parameters(&self) -> usize { 2 }
///     fn residual(&mut self, t: &[f64], r: &mut [f64]) -> Result<(), Self::Error> {
///         r.copy_from_slice(&[t[0] * t[0] + t[1] * t[1] - 1.0, t[0] - t[1]]);
///         Ok(())
///     }
///     fn jacobian(&mut self, t: &[f64], j: &mut [f64]) -> Result<(), Self::Error> {
///         j.copy_from_slice(&[2.0 * t[0], 1.0, 2.0 * t[1], -1.0]);
///         Ok(())
///     }
/// }
/// let mut theta = [1.0, 0.2];
/// gauss_newton(&mut Circle, &mut theta, &GaussNewtonParams::default()).unwrap();
/// assert!((theta[0] - 0.5_f64.sqrt()).abs() < 1e-9);
/// ```
pub fn gauss_newton<P: LeastSquares + ?Sized>(
    problem: &mut P,
    theta: &mut [f64],
    params: &GaussNewtonParams,
) -> Result<GaussNewtonInfo, GaussNewtonError<P::Error>> {
    gauss_newton_observed(problem, theta, params, &mut |_| {})
}

/// [`gauss_newton`], reporting the starting point and every accepted step.
///
/// # Errors
/// As [`gauss_newton`].
pub fn gauss_newton_observed<P: LeastSquares + ?Sized>(
    problem: &mut P,
    theta: &mut [f64],
    params: &GaussNewtonParams,
    observer: &mut dyn FnMut(&GaussNewtonIteration<'_>),
) -> Result<GaussNewtonInfo, GaussNewtonError<P::Error>> {
    let mut info = GaussNewtonInfo {
        iterations: 0,
        cost: f64::NAN,
        residual: f64::NAN,
        stop: GaussNewtonStop::Step,
        residual_evaluations: 0,
        jacobian_evaluations: 0,
        at_bound: 0,
    };
    match run(problem, theta, params, observer, &mut info) {
        Ok(stop) => {
            info.stop = stop;
            info.at_bound = params.bounds.as_ref().map_or(0, |b| {
                (0..theta.len())
                    .filter(|&k| theta[k] <= b.lower[k] || theta[k] >= b.upper[k])
                    .count()
            });
            Ok(info)
        }
        Err(reason) => Err(GaussNewtonError {
            iteration: info.iterations,
            cost: info.cost,
            residual: info.residual,
            reason,
        }),
    }
}

/// Largest growth of the damping over its first value before giving up.
const MAX_REJECTIONS: usize = 40;

fn run<P: LeastSquares + ?Sized>(
    problem: &mut P,
    theta: &mut [f64],
    params: &GaussNewtonParams,
    observer: &mut dyn FnMut(&GaussNewtonIteration<'_>),
    info: &mut GaussNewtonInfo,
) -> Result<GaussNewtonStop, GaussNewtonFailure<P::Error>> {
    let (m, n) = (problem.residuals(), problem.parameters());
    check(params, theta, m, n)?;
    let mut r = vec![0.0; m];
    evaluate(problem, theta, &mut r, info)?;
    let mut trial_r = vec![0.0; m];
    let mut j = vec![0.0; m * n];
    let mut damper = Damper::new(params.damping);
    info.cost = cost(&r, theta, params);
    info.residual = root_mean_square(&r, params.group_size);
    observer(&GaussNewtonIteration {
        iteration: 0,
        cost: info.cost,
        residual: info.residual,
        step: 0.0,
        lambda: 0.0,
        theta,
    });
    loop {
        if info.residual <= params.residual_tolerance {
            return Ok(GaussNewtonStop::Residual);
        }
        if info.iterations == params.max_iterations {
            return Err(GaussNewtonFailure::NotConverged);
        }
        problem
            .jacobian(theta, &mut j)
            .map_err(GaussNewtonFailure::Evaluation)?;
        info.jacobian_evaluations += 1;
        if let Some(index) = first_non_finite(&j) {
            return Err(GaussNewtonFailure::NonFinite {
                what: "the Jacobian",
                index,
            });
        }
        let mut weighted_r = r.clone();
        reweight(&mut weighted_r, &mut j, &r, m, params);
        let offsets: Option<Vec<f64>> = params
            .prior
            .as_ref()
            .map(|p| theta.iter().zip(&p.values).map(|(t, v)| t - v).collect());
        let prior = params
            .prior
            .as_ref()
            .zip(offsets.as_ref())
            .map(|(p, e)| (p.weights.as_slice(), e.as_slice()));
        let model = Model {
            m,
            n,
            r: &weighted_r,
            j: &j,
            prior,
        };
        let bounds = params.bounds.as_ref();
        let gradient = model.gradient();
        let free_gradient = (0..n)
            .filter(|&k| !blocked(theta[k], gradient[k], k, bounds))
            .fold(0.0_f64, |largest, k| largest.max(gradient[k].abs()));
        if free_gradient <= params.gradient_tolerance {
            return Ok(GaussNewtonStop::Gradient);
        }

        let (before, residual_before) = (info.cost, info.residual);
        let mut rejections = 0;
        // Until a step is accepted: undamped the first one, damped the first that lowers the cost.
        let (step, lambda) = loop {
            let damping = damper.vector(&model);
            let d = match model.step(params.method, theta, bounds, damping.as_deref()) {
                Ok(d) => d,
                Err(RankLoss {
                    rank,
                    free,
                    parameter,
                }) => {
                    if damping.is_none() || rejections == MAX_REJECTIONS {
                        return Err(GaussNewtonFailure::RankDeficient {
                            rank,
                            free,
                            parameter,
                        });
                    }
                    rejections += 1;
                    damper.reject();
                    continue;
                }
            };
            let step = norm_inf(&d);
            let mut trial: Vec<f64> = theta.iter().zip(&d).map(|(t, d)| t + d).collect();
            if let Some(b) = bounds {
                for k in 0..n {
                    trial[k] = trial[k].clamp(b.lower[k], b.upper[k]);
                }
            }
            let outcome = evaluate(problem, &trial, &mut trial_r, info);
            if damping.is_none() {
                outcome?;
                accept(theta, &trial, &mut r, &mut trial_r, params, info);
                break (step, 0.0);
            }
            let predicted = model.decrease(&d);
            let new_cost = if outcome.is_ok() {
                cost(&trial_r, &trial, params)
            } else {
                f64::INFINITY
            };
            let gained = before - new_cost;
            if gained > 0.0 || (gained == 0.0 && step <= params.step_tolerance) {
                let lambda = damper.lambda;
                damper.accept(gained / predicted);
                accept(theta, &trial, &mut r, &mut trial_r, params, info);
                break (step, lambda);
            }
            // A step this small can gain nothing that rounding would show.
            if outcome.is_ok()
                && (step <= params.step_tolerance || predicted.abs() <= 4.0 * f64::EPSILON * before)
            {
                return Ok(GaussNewtonStop::Step);
            }
            if rejections == MAX_REJECTIONS {
                outcome?;
                return Err(GaussNewtonFailure::NoDecrease {
                    lambda: damper.lambda,
                });
            }
            rejections += 1;
            damper.reject();
        };
        info.iterations += 1;
        observer(&GaussNewtonIteration {
            iteration: info.iterations,
            cost: info.cost,
            residual: info.residual,
            step,
            lambda,
            theta,
        });
        if info.residual <= params.residual_tolerance {
            return Ok(GaussNewtonStop::Residual);
        }
        if step <= params.step_tolerance {
            return Ok(GaussNewtonStop::Step);
        }
        if (before - info.cost).abs() <= params.cost_tolerance * before {
            return Ok(GaussNewtonStop::Cost);
        }
        if (residual_before - info.residual).abs() < params.residual_change {
            return Ok(GaussNewtonStop::ResidualChange);
        }
    }
}

fn accept(
    theta: &mut [f64],
    trial: &[f64],
    r: &mut Vec<f64>,
    trial_r: &mut Vec<f64>,
    params: &GaussNewtonParams,
    info: &mut GaussNewtonInfo,
) {
    theta.copy_from_slice(trial);
    std::mem::swap(r, trial_r);
    info.cost = cost(r, theta, params);
    info.residual = root_mean_square(r, params.group_size);
}

fn check<E>(
    params: &GaussNewtonParams,
    theta: &mut [f64],
    m: usize,
    n: usize,
) -> Result<(), GaussNewtonFailure<E>> {
    let wrong = |what| Err(GaussNewtonFailure::Params(what));
    if theta.len() != n {
        return wrong("theta does not have one entry per parameter");
    }
    if let Some(index) = first_non_finite(theta) {
        return Err(GaussNewtonFailure::NonFinite {
            what: "theta",
            index,
        });
    }
    if params.group_size == 0 || !m.is_multiple_of(params.group_size) {
        return wrong("group_size must divide the number of residuals");
    }
    if !params.loss.is_valid() {
        return wrong("the scale of a robust loss must be positive and finite");
    }
    let initial = match params.damping {
        Damping::None => 1.0,
        Damping::Levenberg { initial } | Damping::Marquardt { initial } => initial,
    };
    if !(initial > 0.0 && initial.is_finite()) {
        return wrong("the first damping must be positive and finite");
    }
    if let Some(p) = &params.prior {
        if p.weights.len() != n || p.values.len() != n {
            return wrong("a prior needs one weight and one value per parameter");
        }
        if !p.weights.iter().all(|&w| w >= 0.0 && w.is_finite())
            || first_non_finite(&p.values).is_some()
        {
            return wrong("prior weights must be finite and not negative, prior values finite");
        }
    }
    if let Some(b) = &params.bounds {
        if b.lower.len() != n || b.upper.len() != n {
            return wrong("bounds need one lower and one upper entry per parameter");
        }
        if !(0..n).all(|k| b.lower[k] <= b.upper[k]) {
            return wrong("every lower bound must be at most its upper bound");
        }
        for k in 0..n {
            theta[k] = theta[k].clamp(b.lower[k], b.upper[k]);
        }
    }
    Ok(())
}

fn evaluate<P: LeastSquares + ?Sized>(
    problem: &mut P,
    theta: &[f64],
    r: &mut [f64],
    info: &mut GaussNewtonInfo,
) -> Result<(), GaussNewtonFailure<P::Error>> {
    info.residual_evaluations += 1;
    problem
        .residual(theta, r)
        .map_err(GaussNewtonFailure::Evaluation)?;
    match first_non_finite(r) {
        None => Ok(()),
        Some(index) => Err(GaussNewtonFailure::NonFinite {
            what: "the residual",
            index,
        }),
    }
}

fn cost(r: &[f64], theta: &[f64], params: &GaussNewtonParams) -> f64 {
    let data: f64 = r
        .chunks(params.group_size)
        .map(|g| params.loss.value(g.iter().map(|v| v * v).sum()))
        .sum();
    let prior: f64 = params.prior.as_ref().map_or(0.0, |p| {
        (0..theta.len())
            .map(|k| p.weights[k] * (theta[k] - p.values[k]).powi(2))
            .sum()
    });
    0.5 * (data + prior)
}

fn root_mean_square(r: &[f64], group: usize) -> f64 {
    if r.is_empty() {
        return 0.0;
    }
    (r.iter().map(|v| v * v).sum::<f64>() / (r.len() / group) as f64).sqrt()
}

/// Multiplies every group of rows by the root of its weight.
fn reweight(weighted: &mut [f64], j: &mut [f64], r: &[f64], m: usize, params: &GaussNewtonParams) {
    for (g, group) in r.chunks(params.group_size).enumerate() {
        let w = params.loss.weight(group.iter().map(|v| v * v).sum()).sqrt();
        if w == 1.0 {
            continue;
        }
        let rows = g * params.group_size..(g + 1) * params.group_size;
        weighted[rows.clone()].iter_mut().for_each(|v| *v *= w);
        for column in j.chunks_mut(m) {
            column[rows.clone()].iter_mut().for_each(|v| *v *= w);
        }
    }
}

/// The damping parameter, updated after Nielsen (1999).
struct Damper {
    kind: Damping,
    lambda: f64,
    growth: f64,
    started: bool,
}

impl Damper {
    fn new(kind: Damping) -> Self {
        Self {
            kind,
            lambda: 0.0,
            growth: 2.0,
            started: false,
        }
    }

    /// What is added to the diagonal of the Gauss-Newton matrix.
    fn vector(&mut self, model: &Model<'_>) -> Option<Vec<f64>> {
        let diagonal = model.diagonal();
        let largest = diagonal.iter().fold(0.0_f64, |a, &b| a.max(b));
        let (initial, marquardt) = match self.kind {
            Damping::None => return None,
            Damping::Levenberg { initial } => {
                (initial * if largest > 0.0 { largest } else { 1.0 }, None)
            }
            Damping::Marquardt { initial } => (
                initial,
                Some(1e-12 * if largest > 0.0 { largest } else { 1.0 }),
            ),
        };
        if !self.started {
            self.lambda = initial;
            self.started = true;
        }
        Some(match marquardt {
            None => vec![self.lambda; model.n],
            Some(floor) => diagonal
                .iter()
                .map(|d| self.lambda * d.max(floor))
                .collect(),
        })
    }

    fn accept(&mut self, ratio: f64) {
        let factor = 1.0 - (2.0 * ratio - 1.0).powi(3);
        self.lambda = (self.lambda * factor.clamp(1.0 / 3.0, 2.0)).max(1e-15);
        self.growth = 2.0;
    }

    fn reject(&mut self) {
        self.lambda *= self.growth;
        self.growth *= 2.0;
    }
}
