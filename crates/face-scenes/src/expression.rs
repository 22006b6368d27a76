//! One expression of a scene, fitted: landmarks (and dense skin where asked) to activations and jaw.

use super::{Scene, Target};
use face_rig::Stopwatch;
use face_rig::fit::{FitError, FitIteration, FitParams, FitReport, Fitter, Parametrization};
use face_rig::rig::{AffineMap, CarriedPoints, Rig};
use fem_solvers::GaussNewtonFailure;

/// Which points of a target are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Observed {
    /// Its landmarks.
    #[default]
    Landmarks,
    /// Its dense skin.
    Dense,
    /// Both; a landmark counts `landmark_weight` times as much as a point of the skin.
    Both {
        /// Above 0.
        landmark_weight: f64,
    },
}

/// How an expression's fit ended.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ExpressionFit {
    /// Name of the target.
    pub name: String,
    /// Points fitted.
    pub points: usize,
    /// Root-mean-square distance at rest, millimeters.
    pub rms_before_mm: f64,
    /// The same after the fit.
    pub rms_after_mm: f64,
    /// Largest distance after the fit, millimeters.
    pub largest_mm: f64,
    /// Steps.
    pub iterations: usize,
    /// Seconds.
    pub seconds: f64,
    /// Why it stopped, or why it failed.
    pub outcome: Outcome,
    /// Angle of a hinged jaw, degrees.
    pub jaw_degrees: Option<f64>,
    /// Shift of a hinged jaw, millimeters.
    pub jaw_slide_mm: Option<[f64; 3]>,
    /// x ↦ M_j x + t_j of the jaw, meters.
    pub jaw: AffineMap,
    /// x ↦ M_c x + t_c of the head, meters.
    pub cranium: AffineMap,
    /// The smallest det F of all elements; below 0 where one is turned inside out.
    #[serde(rename = "smallest_det_F")]
    pub smallest_ratio: f64,
    /// Elements turned inside out.
    pub inverted_tets: usize,
    /// Every activation, in the scene's order of muscles.
    pub activations: Vec<f64>,
    /// The way there.
    pub history: Vec<FitIteration>,
    /// The numbers found, for a warm start.
    #[serde(skip)]
    pub q: Vec<f64>,
    /// x(θ), meters.
    #[serde(skip)]
    pub positions: Vec<[f64; 3]>,
}

/// The end of a fit.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A stop rule was met.
    Converged(String),
    /// It was not; the best pose was kept.
    NotConverged(String),
}

impl ExpressionFit {
    /// RMS after, as a share of that before.
    pub fn remaining(&self) -> f64 {
        if self.rms_before_mm > 0.0 {
            self.rms_after_mm / self.rms_before_mm
        } else {
            0.0
        }
    }
    /// Was a stop rule met?
    pub fn converged(&self) -> bool {
        matches!(self.outcome, Outcome::Converged(_))
    }
}

/// Fits one target from the numbers `start`; the rig is left at the result.
///
/// # Errors
/// [`FitError`] for input that cannot be fitted. A fit that stops early is no error here: its
/// [`Outcome`] says so and the best pose is returned.
pub fn fit_expression(
    scene: &Scene,
    rig: &mut Rig,
    target: &Target,
    seen: Observed,
    map: &Parametrization,
    params: &FitParams,
    start: &[f64],
    observer: &mut dyn FnMut(&FitIteration),
) -> Result<ExpressionFit, FitError> {
    let begin = Stopwatch::start();
    let (points, places, weights) = observed(scene, target, seen);
    let fitter = Fitter {
        observation: &points,
        target: places.as_flattened(),
        weights: &weights,
        parametrization: map,
        params,
    };
    let rest: Vec<[f64; 3]> = points
        .0
        .iter()
        .map(|p| p.position(scene.mesh.nodes()))
        .collect();
    let (report, outcome) = match fitter.fit(rig, start, observer) {
        Ok(report) => {
            let why = report.stop.map(|stop| format!("{stop:?}").to_lowercase());
            (report, Outcome::Converged(why.unwrap_or_default()))
        }
        Err(FitError::NotConverged { source, best }) => {
            let why = match source.reason {
                GaussNewtonFailure::NotConverged => {
                    format!("{} steps were not enough", source.iteration)
                }
                reason => reason.to_string(),
            };
            (*best, Outcome::NotConverged(why))
        }
        Err(error) => return Err(error),
    };
    let FitReport {
        q,
        parameters,
        iterations,
        positions,
        ..
    } = report;
    let last = iterations.last();
    let ratios = rig.assembly().volume_ratios(&rig.solved().in_cranium_frame);
    Ok(ExpressionFit {
        name: target.name.clone(),
        points: weights.iter().filter(|w| **w > 0.0).count(),
        rms_before_mm: 1e3 * rms(&rest, &places, &weights),
        rms_after_mm: last.map_or(f64::NAN, |i| i.rms_mm),
        largest_mm: last.map_or(f64::NAN, |i| i.largest_mm),
        iterations: last.map_or(0, |i| i.iteration),
        seconds: begin.elapsed().as_secs_f64(),
        outcome,
        jaw_degrees: map.jaw_angle(&q).map(f64::to_degrees),
        jaw_slide_mm: map.jaw_slide(&q).map(|slide| slide.map(|v| 1e3 * v)),
        jaw: parameters.jaw,
        cranium: parameters.cranium,
        smallest_ratio: ratios.iter().copied().fold(f64::INFINITY, f64::min),
        inverted_tets: ratios.iter().filter(|ratio| !(**ratio > 0.0)).count(),
        activations: parameters.activations,
        history: iterations,
        q,
        positions,
    })
}

/// Points, where they should be, and how much each counts.
fn observed(
    scene: &Scene,
    target: &Target,
    seen: Observed,
) -> (CarriedPoints, Vec<[f64; 3]>, Vec<f64>) {
    let (mut points, mut places, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    if seen != Observed::Dense {
        points.extend(
            scene
                .carried_landmarks(target.landmarks.iter().map(|l| l.0))
                .0,
        );
        places.extend(target.landmarks.iter().map(|l| l.1));
        let share = match seen {
            Observed::Both { landmark_weight } => landmark_weight,
            _ => 1.0,
        };
        let own = |k: usize| target.weights.get(k).copied().unwrap_or(1.0);
        weights.extend((0..target.landmarks.len()).map(|k| share * own(k)));
    }
    if seen != Observed::Landmarks
        && let (Some(dense), Some(skin)) = (&target.dense, &scene.skin)
    {
        points.extend(skin.points.iter().map(|p| scene.carried(p)));
        places.extend(dense);
    }
    weights.resize(places.len(), 1.0);
    (CarriedPoints(points), places, weights)
}

/// Root-mean-square distance of paired points, those of weight 0 left out.
fn rms(a: &[[f64; 3]], b: &[[f64; 3]], weights: &[f64]) -> f64 {
    let (mut sum, mut counted) = (0.0, 0);
    for ((a, b), _) in a.iter().zip(b).zip(weights).filter(|(_, w)| **w > 0.0) {
        sum += (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
        counted += 1;
    }
    (sum / f64::from(counted.max(1))).sqrt()
}
