//! The least-squares problem ½ |g* − g(x(θ))|² and its solution.

use super::parametrization::{JawModel, Parametrization};
use crate::rig::{AffineMap, Direction, JacobianRoute, Observation, Parameters, Rig, RigError};
use crate::stopwatch::Stopwatch;
use fem_assembly::AssemblyError;
use fem_solvers::{
    Bounds, Damping, GaussNewtonError, GaussNewtonFailure, GaussNewtonInfo, GaussNewtonParams,
    GaussNewtonStop, LeastSquares, Loss, Prior, StepMethod, gauss_newton_observed,
};
use std::cell::Cell;

/// Weights of ½ w |MᵀM − I|² for the affine maps (document 000, 2.2 and 2.3); meters².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Orthogonality {
    /// Weight for the cranium.
    pub cranium: f64,
    /// Weight for the jaw.
    pub jaw: f64,
}

/// How to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitParams {
    /// Linear algebra of a step: QR, or the normal equations.
    pub method: StepMethod,
    /// Damping; [`Damping::None`] takes full Gauss-Newton steps.
    pub damping: Damping,
    /// Bounds of the activations; `None` lets muscles push.
    pub activation_bounds: Option<[f64; 2]>,
    /// Angles between which a jaw with a mere hinge turns, radians; a joint has limits of its own.
    pub jaw_angle_bounds: Option<[f64; 2]>,
    /// Tikhonov weight w_a of ½ w_a |α|², meters²; also that of each control that varies, from its
    /// neutral value, in shares of its greatest.
    pub activation_weight: f64,
    /// Tikhonov weight w_j of ½ w_j Σ (s / s_max)² over a joint's protrusion, lateral shift and yaw,
    /// each relative to its wider limit; meters². The opening is free.
    pub joint_weight: f64,
    /// Tikhonov weight of the head's and the jaw's numbers, meters² over their unit squared.
    pub pose_weight: f64,
    /// Orthogonality of affine maps.
    pub orthogonality: Orthogonality,
    /// Robust loss of each point; its scale in meters.
    pub loss: Loss,
    /// Most accepted steps.
    pub max_iterations: usize,
    /// Stop when the root-mean-square distance, weighted with weights of mean 1, is at most this, meters.
    pub rms_tolerance: f64,
    /// Stop when a step lowers that root-mean-square distance by less than this, meters.
    pub rms_change: f64,
    /// Stop when no number moves by more than this.
    pub step_tolerance: f64,
}

impl Default for FitParams {
    fn default() -> Self {
        Self {
            method: StepMethod::Qr,
            damping: Damping::Marquardt { initial: 1e-3 },
            activation_bounds: Some([0.0, 1.0]),
            jaw_angle_bounds: Some([-0.1, 0.7]),
            activation_weight: 1e-7,
            joint_weight: 3e-4,
            pose_weight: 0.0,
            orthogonality: Orthogonality {
                cranium: 1e-2,
                jaw: 1e-2,
            },
            loss: Loss::Square,
            max_iterations: 40,
            rms_tolerance: 1e-6,
            rms_change: 2e-6,
            step_tolerance: 1e-6,
        }
    }
}

/// One accepted step, as a report shows it; iteration 0 is the start.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct FitIteration {
    /// Steps so far.
    pub iteration: usize,
    /// Root-mean-square distance of the observed points, millimeters, without weights.
    pub rms_mm: f64,
    /// Largest distance of a point, millimeters.
    pub largest_mm: f64,
    /// Cost with weights, loss and priors, meters².
    pub cost: f64,
    /// Largest entry of the step.
    pub step: f64,
    /// Damping.
    pub damping: f64,
    /// Activations that sit on a bound.
    pub activations_at_bounds: usize,
    /// Seconds since the fit began.
    pub seconds: f64,
}

/// A fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitReport {
    /// The numbers found.
    pub q: Vec<f64>,
    /// θ of them.
    pub parameters: Parameters,
    /// The start and every accepted step.
    pub iterations: Vec<FitIteration>,
    /// Which stop rule was met; none by a fit that failed.
    pub stop: Option<GaussNewtonStop>,
    /// x(θ), meters.
    pub positions: Vec<[f64; 3]>,
}

/// A fit that could not be finished.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// Lists that do not belong together.
    #[error("{what}: {found} given, {expected} needed")]
    WrongLength {
        /// What was counted.
        what: &'static str,
        /// How many were given.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// NaN or ∞ in targets or weights, or a negative weight.
    #[error("target or weight {index} is not usable: {value}")]
    BadNumber {
        /// Its place.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The target names no points.
    #[error("the target is empty: no points to fit, or all of weight 0")]
    EmptyTarget,
    /// The parametrization leaves nothing to vary.
    #[error("nothing to fit: no muscle, jaw or head number may vary")]
    NothingToFit,
    /// The solver gave up; the best pose so far is kept.
    #[error("{source}")]
    NotConverged {
        /// Why.
        source: GaussNewtonError<RigError>,
        /// The best pose so far and the way there.
        best: Box<FitReport>,
    },
    /// A [`Watch`](fem_solvers::Watch) of the rig ended it.
    #[error("cancelled after {} steps", iterations.len().saturating_sub(1))]
    Cancelled {
        /// The best numbers so far.
        q: Vec<f64>,
        /// The start, if it was solved, and every accepted step.
        iterations: Vec<FitIteration>,
    },
    /// The pose that was found could not be solved for again.
    #[error("the fitted pose has no equilibrium any more: {0}")]
    Pose(#[source] Box<RigError>),
    /// A starting number outside the bounds of the fit.
    #[error("starting number {index} is {value}, the fit allows {lower} to {upper}")]
    StartOutOfBounds {
        /// Its place.
        index: usize,
        /// Its value.
        value: f64,
        /// The lower bound.
        lower: f64,
        /// The upper bound.
        upper: f64,
    },
    /// Not even the starting pose has an equilibrium.
    #[error("the starting pose has no equilibrium: {0}")]
    Start(#[source] Box<RigError>),
}

/// What to fit: observed points, where they should be, and how much each counts.
#[derive(Clone, Copy)]
pub struct Fitter<'a> {
    /// g.
    pub observation: &'a dyn Observation,
    /// g*, meters.
    pub target: &'a [f64],
    /// One weight for each observed point (three numbers); empty for 1 everywhere. Weights say how
    /// points count among each other: a factor common to all changes nothing.
    pub weights: &'a [f64],
    /// Which numbers may vary.
    pub parametrization: &'a Parametrization,
    /// How to fit.
    pub params: &'a FitParams,
}

/// The report of a fit, or why there is none.
fn ended(
    outcome: Result<GaussNewtonInfo, GaussNewtonError<RigError>>,
    report: impl FnOnce(Option<GaussNewtonStop>) -> Result<FitReport, RigError>,
) -> Result<FitReport, FitError> {
    let no_pose = |error| FitError::Pose(Box::new(error));
    match outcome {
        Ok(info) => report(Some(info.stop)).map_err(no_pose),
        Err(source) => match source.reason {
            GaussNewtonFailure::Evaluation(error)
                if source.iteration == 0 && report_is_missing(source.cost) =>
            {
                Err(FitError::Start(Box::new(error)))
            }
            _ => {
                let best = Box::new(report(None).map_err(no_pose)?);
                Err(FitError::NotConverged { source, best })
            }
        },
    }
}

impl Fitter<'_> {
    /// Fits, starting from the numbers `start`. `observer` is called with every accepted step.
    ///
    /// # Errors
    /// Bad input is named; [`FitError::NotConverged`] still carries the best pose.
    pub fn fit(
        &self,
        rig: &mut Rig,
        start: &[f64],
        observer: &mut dyn FnMut(&FitIteration),
    ) -> Result<FitReport, FitError> {
        let roots = self.check(rig, start)?;
        let settings = self.settings();
        within(start, settings.bounds.as_ref())?;
        let map = self.parametrization;
        let begin = Stopwatch::start();
        let seen = Cell::new((0.0, 0.0));
        let mut q = start.to_vec();
        let mut problem = Problem {
            fitter: self,
            rig,
            roots,
            seen: &seen,
            has_nearer: false,
        };
        let mut iterations = Vec::new();
        let outcome = gauss_newton_observed(&mut problem, &mut q, &settings, &mut |i| {
            let (rms, largest) = seen.get();
            let report = FitIteration {
                iteration: i.iteration,
                rms_mm: 1e3 * rms,
                largest_mm: 1e3 * largest,
                cost: i.cost,
                step: i.step,
                damping: i.lambda,
                activations_at_bounds: self.at_bounds(i.theta),
                seconds: begin.elapsed().as_secs_f64(),
            };
            observer(&report);
            iterations.push(report);
        });
        if let Err(error) = &outcome
            && matches!(&error.reason, GaussNewtonFailure::Evaluation(e) if e.is_cancelled())
        {
            return Err(FitError::Cancelled { q, iterations });
        }
        let parameters = map.trusted_parameters(&q);
        let report = |stop| -> Result<FitReport, RigError> {
            problem.has_nearer = false;
            let positions = problem.pose(&parameters)?;
            Ok(FitReport {
                q,
                parameters,
                iterations,
                stop,
                positions,
            })
        };
        ended(outcome, report)
    }

    fn at_bounds(&self, q: &[f64]) -> usize {
        let activations = &q[..self.parametrization.active.len()];
        self.params.activation_bounds.map_or(0, |[low, high]| {
            activations
                .iter()
                .filter(|&&a| a <= low || a >= high)
                .count()
        })
    }

    fn settings(&self) -> GaussNewtonParams {
        let (map, params) = (self.parametrization, self.params);
        let muscles = map.active.len();
        let mut lower = vec![f64::NEG_INFINITY; map.len()];
        let mut upper = vec![f64::INFINITY; map.len()];
        if let Some([low, high]) = params.activation_bounds {
            lower[..muscles].fill(low);
            upper[..muscles].fill(high);
        }
        let mut weights = vec![params.pose_weight; map.len()];
        weights[..muscles].fill(params.activation_weight);
        let jaw = map.jaw_start();
        match (&map.jaw, params.jaw_angle_bounds) {
            (JawModel::Joint(joint), _) => {
                for (k, [low, high]) in joint.limits().to_array().into_iter().enumerate() {
                    (lower[jaw + k], upper[jaw + k]) = (low, high);
                    let slides = if k == 0 { 0.0 } else { params.joint_weight };
                    weights[jaw + k] += slides / low.abs().max(high).powi(2);
                }
            }
            (JawModel::Hinge(_), Some([low, high])) => (lower[jaw], upper[jaw]) = (low, high),
            _ => {}
        }
        let first = map.len() - map.control_numbers();
        for (place, (_, [low, high], unit)) in (first..).zip(map.varying()) {
            (lower[place], upper[place]) = (low / unit, high / unit);
        }
        weights[first..].fill(params.activation_weight);
        GaussNewtonParams {
            method: params.method,
            damping: params.damping,
            bounds: Some(Bounds { lower, upper }),
            prior: Some(Prior {
                weights,
                values: map.rest(),
            }),
            loss: params.loss,
            group_size: 3,
            max_iterations: params.max_iterations,
            step_tolerance: params.step_tolerance,
            cost_tolerance: 0.0,
            gradient_tolerance: 0.0,
            residual_tolerance: params.rms_tolerance,
            residual_change: params.rms_change,
        }
    }

    /// Square roots of the weights, one per number, the weights divided by the mean of those above 0:
    /// a common factor must change neither what a prior is worth nor what a tolerance in meters means.
    fn check(&self, rig: &Rig, start: &[f64]) -> Result<Vec<f64>, FitError> {
        let nodes = rig.assembly().rest().len();
        let other_nodes = |error: AssemblyError| FitError::Pose(Box::new(error.into()));
        self.observation.check(nodes).map_err(other_nodes)?;
        let dim = self.observation.dim();
        let same = |what, found, expected| {
            if found == expected {
                Ok(())
            } else {
                Err(FitError::WrongLength {
                    what,
                    found,
                    expected,
                })
            }
        };
        if dim == 0 {
            return Err(FitError::EmptyTarget);
        }
        if self.parametrization.is_empty() {
            return Err(FitError::NothingToFit);
        }
        same("numbers in the target", self.target.len(), dim)?;
        same(
            "muscles of the parametrization",
            self.parametrization.muscles,
            rig.muscles(),
        )?;
        same(
            "controls of the parametrization",
            self.parametrization.controls.len(),
            rig.controls(),
        )?;
        same("starting numbers", start.len(), self.parametrization.len())?;
        if !self.weights.is_empty() {
            same("weights", self.weights.len(), dim / 3)?;
        }
        let finite = self.target.iter().map(|v| (*v, v.is_finite()));
        let positive = self
            .weights
            .iter()
            .map(|v| (*v, v.is_finite() && *v >= 0.0));
        for (index, (value, usable)) in finite.chain(positive).enumerate() {
            if !usable {
                return Err(FitError::BadNumber { index, value });
            }
        }
        if !self.weights.is_empty() && self.weights.iter().all(|w| *w == 0.0) {
            return Err(FitError::EmptyTarget);
        }
        let mean = mean_of_positive(self.weights);
        let root = |k: usize| self.weights.get(k / 3).map_or(1.0, |w| (w / mean).sqrt());
        Ok((0..dim).map(root).collect())
    }
}

/// Divided by the largest first: sums of large weights must not overflow.
fn mean_of_positive(weights: &[f64]) -> f64 {
    let largest = weights.iter().fold(0.0_f64, |m, &w| m.max(w));
    let shares = weights.iter().filter(|w| **w > 0.0).map(|w| w / largest);
    let (sum, count) = shares.fold((0.0, 0_usize), |(sum, count), w| (sum + w, count + 1));
    largest * (sum / count as f64)
}

/// Every starting number lies within its bounds.
fn within(start: &[f64], bounds: Option<&Bounds>) -> Result<(), FitError> {
    let Some(Bounds { lower, upper }) = bounds else {
        return Ok(());
    };
    let bounds = lower.iter().zip(upper);
    for (index, (&value, (&lower, &upper))) in start.iter().zip(bounds).enumerate() {
        if !(lower <= value && value <= upper) {
            return Err(FitError::StartOutOfBounds {
                index,
                value,
                lower,
                upper,
            });
        }
    }
    Ok(())
}

fn report_is_missing(cost: f64) -> bool {
    cost.is_nan()
}

struct Problem<'a> {
    fitter: &'a Fitter<'a>,
    rig: &'a mut Rig,
    roots: Vec<f64>,
    /// (root mean square, largest) distance at the last evaluation, meters.
    seen: &'a Cell<(f64, f64)>,
    /// Does a pose that cannot be reached leave a nearer one to try?
    has_nearer: bool,
}

impl Problem<'_> {
    fn pose(&mut self, parameters: &Parameters) -> Result<Vec<[f64; 3]>, RigError> {
        if self.rig.equilibrium().parameters != *parameters {
            if self.has_nearer {
                self.rig.solve_whole(parameters)?;
            } else {
                self.rig.solve(parameters)?;
            }
        }
        // A damped search shortens its step.
        self.has_nearer = self.fitter.params.damping != Damping::None;
        Ok(self.rig.equilibrium().positions())
    }

    /// (weight root, map, number of the first row) of each map kept near orthogonal.
    fn orthogonality(&self) -> [f64; 2] {
        let Orthogonality { cranium, jaw } = self.fitter.params.orthogonality;
        let map = self.fitter.parametrization;
        let kept = |numbers: usize, weight: f64| if numbers == 12 { weight.sqrt() } else { 0.0 };
        [
            kept(map.cranium_numbers(), cranium),
            kept(map.jaw_numbers(), jaw),
        ]
    }
}

impl LeastSquares for Problem<'_> {
    type Error = RigError;

    fn gives_up(&self, error: &RigError) -> bool {
        error.is_cancelled()
    }

    fn residuals(&self) -> usize {
        let maps = self.orthogonality().iter().filter(|w| **w > 0.0).count();
        self.fitter.observation.dim() + 9 * maps
    }

    fn parameters(&self) -> usize {
        self.fitter.parametrization.len()
    }

    fn residual(&mut self, q: &[f64], r: &mut [f64]) -> Result<(), RigError> {
        let parameters = self.fitter.parametrization.trusted_parameters(q);
        let x = self.pose(&parameters)?;
        let dim = self.fitter.observation.dim();
        let (data, mut rest) = r.split_at_mut(dim);
        self.fitter.observation.value(&x, data);
        let (mut sum, mut largest, mut counted) = (0.0, 0.0_f64, 0);
        let points = data.chunks_mut(3).zip(self.fitter.target.chunks(3));
        for ((point, target), roots) in points.zip(self.roots.chunks(3)) {
            point.iter_mut().zip(target).for_each(|(g, t)| *g -= t);
            // A point without weight is not fitted, so its distance says nothing of the fit.
            if roots[0] > 0.0 {
                let square: f64 = point.iter().map(|d| d * d).sum();
                sum += square;
                largest = largest.max(square.sqrt());
                counted += 1;
            }
        }
        self.seen.set(((sum / f64::from(counted)).sqrt(), largest));
        data.iter_mut()
            .zip(&self.roots)
            .for_each(|(d, root)| *d *= root);
        let maps = [parameters.cranium, parameters.jaw];
        for (map, root) in maps
            .iter()
            .zip(self.orthogonality())
            .filter(|(_, w)| *w > 0.0)
        {
            let (own, tail) = rest.split_at_mut(9);
            own.iter_mut()
                .zip(map.orthogonality())
                .for_each(|(o, e)| *o = root * e);
            rest = tail;
        }
        Ok(())
    }

    fn jacobian(&mut self, q: &[f64], j: &mut [f64]) -> Result<(), RigError> {
        let map = self.fitter.parametrization;
        let parameters = map.trusted_parameters(q);
        self.pose(&parameters)?;
        let (dim, rows) = (self.fitter.observation.dim(), self.residuals());
        let directions = map.trusted_directions(q);
        let (weights, scales) = (self.orthogonality(), map.scales());
        let observation = self.fitter.observation;
        let route = JacobianRoute::cheaper(observation, &directions);
        let solves = route.right_hand_sides(observation, &directions);
        let sensitivity = self.rig.sensitivity_for(solves)?;
        let data = sensitivity.jacobian(observation, &directions, route)?;
        for (((column, seen), direction), scale) in j
            .chunks_exact_mut(rows)
            .zip(data.chunks_exact(dim))
            .zip(&directions)
            .zip(&scales)
        {
            for ((c, d), root) in column.iter_mut().zip(seen).zip(&self.roots) {
                *c = scale * d * root;
            }
            let zero = AffineMap::ZERO;
            let (cranium, jaw) = match direction {
                Direction::Activation(_) | Direction::Control(_) => (&zero, &zero),
                Direction::Cranium(d) => (d, &zero),
                Direction::Jaw(d) => (&zero, d),
            };
            let moved = [(parameters.cranium, cranium), (parameters.jaw, jaw)];
            let mut rest = &mut column[dim..];
            for ((map, d), root) in moved.iter().zip(weights).filter(|(_, w)| *w > 0.0) {
                let (own, tail) = rest.split_at_mut(9);
                let change = map.orthogonality_differential(d);
                own.iter_mut().zip(change).for_each(|(o, e)| *o = root * e);
                rest = tail;
            }
        }
        Ok(())
    }
}
