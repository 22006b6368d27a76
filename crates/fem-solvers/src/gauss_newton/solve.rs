//! The Gauss-Newton and Levenberg-Marquardt loop.

use super::damper::Damper;
use super::linear_step::{Model, RankLoss, blocked};
use super::stop::Remaining;
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
/// [`GaussNewtonError`]; `theta` then holds the last accepted parameters. A start outside the bounds is
/// refused.
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
    let mut fit = Fit::start(problem, theta, params, info)?;
    fit.report(observer, 0.0, 0.0);
    let mut j = vec![0.0; m * n];
    let mut damper = Damper::new(params.damping);
    let mut doubted = false;
    loop {
        if fit.info.residual <= params.residual_tolerance {
            return Ok(GaussNewtonStop::Residual);
        }
        if fit.info.iterations == params.max_iterations {
            return Err(GaussNewtonFailure::NotConverged);
        }
        let weighted_r = fit.linearize(&mut j)?;
        let offsets = fit.offsets();
        let model = fit.model(&weighted_r, &j, offsets.as_deref());
        if fit.free_gradient(&model) <= params.gradient_tolerance {
            return Ok(GaussNewtonStop::Gradient);
        }
        let model = model.reduced(params.method, fit.theta, params.bounds.as_ref());
        let before = (fit.info.cost, fit.info.residual);
        // What the undamped model promises here is asked for only where a step seems to be the last.
        let here = fit.theta.to_vec();
        let promise = || Remaining::of(&model, &here, params, before);
        let Some(taken) = fit.step(&model, &mut damper)? else {
            if promise().is_some_and(|left| left.is_nothing(params)) {
                return Ok(GaussNewtonStop::Step);
            }
            let lambda = damper.lambda;
            return Err(GaussNewtonFailure::NoDecrease { lambda });
        };
        fit.info.iterations += 1;
        fit.report(observer, taken.length, taken.lambda);
        let Some(stop) = fit.met(before, &taken) else {
            doubted = false;
            continue;
        };
        if stop == GaussNewtonStop::Residual {
            return Ok(stop);
        }
        // A gain far below what was predicted tells of the model, not of the end: the next step is damped more.
        doubted = !doubted && taken.is_misjudged(before.0 - fit.info.cost);
        if doubted {
            continue;
        }
        let is_last =
            |left: Remaining| left.is_taken_by(taken.predicted) || left.is_nothing(params);
        if taken.lambda == 0.0 || promise().is_some_and(is_last) {
            return Ok(stop);
        }
        damper.ease();
    }
}

/// An accepted step.
struct Taken {
    length: f64,
    /// Its damping.
    lambda: f64,
    /// The decrease of the undamped model along it.
    predicted: f64,
    /// Could longer ones not be evaluated?
    cut_short: bool,
}

/// Part of the predicted gain below which a step is one that the model misjudged.
const MISJUDGED: f64 = 0.25;

impl Taken {
    /// An undamped step has no shorter one after it.
    fn is_misjudged(&self, gained: f64) -> bool {
        self.lambda > 0.0 && gained < MISJUDGED * self.predicted
    }
}

/// A step that was tried.
struct Trial<E> {
    theta: Vec<f64>,
    length: f64,
    predicted: f64,
    /// Could the residual be evaluated there?
    outcome: Result<(), GaussNewtonFailure<E>>,
}

impl<E> Trial<E> {
    fn taken(&self, lambda: f64, cut_short: bool) -> Taken {
        Taken {
            length: self.length,
            lambda,
            predicted: self.predicted,
            cut_short,
        }
    }
}

/// Where a fit stands.
struct Fit<'a, P: ?Sized> {
    problem: &'a mut P,
    theta: &'a mut [f64],
    params: &'a GaussNewtonParams,
    info: &'a mut GaussNewtonInfo,
    r: Vec<f64>,
    trial_r: Vec<f64>,
}

impl<'a, P: LeastSquares + ?Sized> Fit<'a, P> {
    /// Evaluates the starting point.
    fn start(
        problem: &'a mut P,
        theta: &'a mut [f64],
        params: &'a GaussNewtonParams,
        info: &'a mut GaussNewtonInfo,
    ) -> Result<Self, GaussNewtonFailure<P::Error>> {
        let m = problem.residuals();
        let mut r = vec![0.0; m];
        evaluate(problem, theta, &mut r, info)?;
        let mut fit = Self {
            problem,
            theta,
            params,
            info,
            r,
            trial_r: vec![0.0; m],
        };
        fit.measure();
        Ok(fit)
    }

    fn measure(&mut self) {
        self.info.cost = cost(&self.r, self.theta, self.params);
        self.info.residual = root_mean_square(&self.r, self.params.group_size);
    }

    fn report(&self, observer: &mut dyn FnMut(&GaussNewtonIteration<'_>), step: f64, lambda: f64) {
        observer(&GaussNewtonIteration {
            iteration: self.info.iterations,
            cost: self.info.cost,
            residual: self.info.residual,
            step,
            lambda,
            theta: self.theta,
        });
    }

    /// Writes the Jacobian; returns the residual. Rows of both are multiplied by their weights.
    fn linearize(&mut self, j: &mut [f64]) -> Result<Vec<f64>, GaussNewtonFailure<P::Error>> {
        self.problem
            .jacobian(self.theta, j)
            .map_err(GaussNewtonFailure::Evaluation)?;
        self.info.jacobian_evaluations += 1;
        if let Some(index) = first_non_finite(j) {
            return Err(GaussNewtonFailure::NonFinite {
                what: "the Jacobian",
                index,
            });
        }
        let mut weighted = self.r.clone();
        reweight(&mut weighted, j, &self.r, self.r.len(), self.params);
        Ok(weighted)
    }

    /// How far each parameter is from what the prior expects.
    fn offsets(&self) -> Option<Vec<f64>> {
        let prior = self.params.prior.as_ref()?;
        let pairs = self.theta.iter().zip(&prior.values);
        Some(pairs.map(|(t, v)| t - v).collect())
    }

    fn model<'m>(&self, r: &'m [f64], j: &'m [f64], offsets: Option<&'m [f64]>) -> Model<'m>
    where
        'a: 'm,
    {
        let prior = self.params.prior.as_ref().zip(offsets);
        Model::new(
            self.theta.len(),
            r,
            j,
            prior.map(|(p, e)| (p.weights.as_slice(), e)),
        )
    }

    /// The largest entry of the gradient, of parameters free to move.
    fn free_gradient(&self, model: &Model<'_>) -> f64 {
        let (gradient, bounds) = (&model.gradient, self.params.bounds.as_ref());
        (0..model.n)
            .filter(|&k| !blocked(self.theta[k], gradient[k], k, bounds))
            .fold(0.0_f64, |largest, k| largest.max(gradient[k].abs()))
    }

    /// Until a step is accepted: undamped the first one, damped the first that lowers the cost;
    /// `None` when steps have become too small to gain anything.
    ///
    /// A step that is small only because the longer ones could not be evaluated is no end but their
    /// failure.
    fn step(
        &mut self,
        model: &Model<'_>,
        damper: &mut Damper,
    ) -> Result<Option<Taken>, GaussNewtonFailure<P::Error>> {
        let (params, before) = (self.params, self.info.cost);
        let mut failed = None;
        for rejections in 0.. {
            let damping = damper.vector(model);
            let bounds = params.bounds.as_ref();
            let d = match model.step(params.method, self.theta, bounds, damping.as_deref()) {
                Ok(d) => d,
                Err(loss) if damping.is_none() || rejections == MAX_REJECTIONS => {
                    return Err(loss.into());
                }
                Err(_) => {
                    damper.reject();
                    continue;
                }
            };
            let trial = self.attempt(model, &d)?;
            if damping.is_none() {
                let taken = trial.taken(0.0, false);
                trial.outcome?;
                self.accept(&trial.theta);
                return Ok(Some(taken));
            }
            let gained = before - self.trial_cost(&trial.theta, trial.outcome.is_ok());
            let short = trial.length <= params.step_tolerance;
            // A step this small can gain nothing that rounding would show.
            let small = short || trial.predicted.abs() <= 4.0 * f64::EPSILON * before;
            if small && let Some(failure) = failed.take() {
                return Err(failure);
            }
            if gained > 0.0 || (gained == 0.0 && short) {
                let taken = trial.taken(damper.lambda, damper.cuts_short(damper.lambda));
                damper.accept(gained / trial.predicted);
                self.accept(&trial.theta);
                return Ok(Some(taken));
            }
            let outcome = trial.outcome;
            if outcome.is_ok() && small {
                if damper.cuts_short(damper.lambda) {
                    break;
                }
                return Ok(None);
            }
            if rejections == MAX_REJECTIONS {
                outcome?;
                break;
            }
            if let Err(failure) = outcome {
                damper.failed_at = Some(damper.lambda);
                failed = Some(failure);
            }
            damper.reject();
        }
        let lambda = damper.lambda;
        Err(GaussNewtonFailure::NoDecrease { lambda })
    }

    /// Evaluates `θ + d`.
    ///
    /// # Errors
    /// Where the problem gives up.
    fn attempt(
        &mut self,
        model: &Model<'_>,
        d: &[f64],
    ) -> Result<Trial<P::Error>, GaussNewtonFailure<P::Error>> {
        let theta = self.moved(d);
        match evaluate(self.problem, &theta, &mut self.trial_r, self.info) {
            Err(GaussNewtonFailure::Evaluation(error)) if self.problem.gives_up(&error) => {
                Err(GaussNewtonFailure::Evaluation(error))
            }
            outcome => Ok(Trial {
                theta,
                length: norm_inf(d),
                predicted: model.decrease(d),
                outcome,
            }),
        }
    }

    /// `θ + d` within the bounds.
    fn moved(&self, d: &[f64]) -> Vec<f64> {
        let mut trial: Vec<f64> = self.theta.iter().zip(d).map(|(t, d)| t + d).collect();
        if let Some(b) = &self.params.bounds {
            for (k, t) in trial.iter_mut().enumerate() {
                *t = t.clamp(b.lower[k], b.upper[k]);
            }
        }
        trial
    }

    fn trial_cost(&self, trial: &[f64], evaluated: bool) -> f64 {
        if evaluated {
            cost(&self.trial_r, trial, self.params)
        } else {
            f64::INFINITY
        }
    }

    fn accept(&mut self, trial: &[f64]) {
        self.theta.copy_from_slice(trial);
        std::mem::swap(&mut self.r, &mut self.trial_r);
        self.measure();
    }

    /// The test that the last step met, given cost and residual before it. A step that was cut short
    /// may gain little anywhere.
    fn met(&self, (cost, residual): (f64, f64), taken: &Taken) -> Option<GaussNewtonStop> {
        let (info, params) = (&*self.info, self.params);
        if info.residual <= params.residual_tolerance {
            Some(GaussNewtonStop::Residual)
        } else if taken.cut_short {
            None
        } else if taken.length <= params.step_tolerance {
            Some(GaussNewtonStop::Step)
        } else if (cost - info.cost).abs() <= params.cost_tolerance * cost {
            Some(GaussNewtonStop::Cost)
        } else if (residual - info.residual).abs() < params.residual_change {
            Some(GaussNewtonStop::ResidualChange)
        } else {
            None
        }
    }
}

impl<E> From<RankLoss> for GaussNewtonFailure<E> {
    fn from(loss: RankLoss) -> Self {
        Self::RankDeficient {
            rank: loss.rank,
            free: loss.free,
            parameter: loss.parameter,
        }
    }
}

fn check<E>(
    params: &GaussNewtonParams,
    theta: &[f64],
    m: usize,
    n: usize,
) -> Result<(), GaussNewtonFailure<E>> {
    length("theta", theta, n)?;
    if let Some(index) = first_non_finite(theta) {
        return Err(GaussNewtonFailure::NonFinite {
            what: "theta",
            index,
        });
    }
    let group = params.group_size;
    let divides = group > 0 && m.is_multiple_of(group);
    let divisor = "a divisor of the number of residuals";
    range("group_size", group as f64, divides, divisor)?;
    if let Some(scale) = params.loss.scale() {
        let good = scale > 0.0 && scale < f64::INFINITY;
        range("the scale of the loss", scale, good, "(0, ∞)")?;
    }
    if let Damping::Levenberg { initial } | Damping::Marquardt { initial } = params.damping {
        let good = initial > 0.0 && initial < f64::INFINITY;
        range("the first damping", initial, good, "(0, ∞)")?;
    }
    if let Some(p) = &params.prior {
        length("prior.weights", &p.weights, n)?;
        length("prior.values", &p.values, n)?;
        for &w in &p.weights {
            let good = (0.0..f64::INFINITY).contains(&w);
            range("a prior weight", w, good, "[0, ∞)")?;
        }
        for &v in &p.values {
            range("a prior value", v, v.is_finite(), "(-∞, ∞)")?;
        }
    }
    if let Some(b) = &params.bounds {
        length("bounds.lower", &b.lower, n)?;
        length("bounds.upper", &b.upper, n)?;
        for (&lower, &upper) in b.lower.iter().zip(&b.upper) {
            range("a lower bound", lower, lower <= upper, "[-∞, upper bound]")?;
        }
        for ((&t, &lower), &upper) in theta.iter().zip(&b.lower).zip(&b.upper) {
            let inside = lower <= t && t <= upper;
            range(
                "a starting parameter",
                t,
                inside,
                "[lower bound, upper bound]",
            )?;
        }
    }
    Ok(())
}

fn length<E>(
    what: &'static str,
    list: &[f64],
    expected: usize,
) -> Result<(), GaussNewtonFailure<E>> {
    let found = list.len();
    if found == expected {
        return Ok(());
    }
    Err(GaussNewtonFailure::Length {
        what,
        found,
        expected,
    })
}

fn range<E>(
    what: &'static str,
    value: f64,
    good: bool,
    allowed: &'static str,
) -> Result<(), GaussNewtonFailure<E>> {
    if good {
        return Ok(());
    }
    Err(GaussNewtonFailure::Params {
        what,
        value,
        allowed,
    })
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
