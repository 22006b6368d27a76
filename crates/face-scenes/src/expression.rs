//! One expression of a scene, fitted: landmarks (and dense skin where asked) to activations and jaw.

use super::alignment::{FAR, Pairs, Suspicion};
use super::outcome::{LIMIT_SHARE, Outcome, Unfinished, past_limits, possible};
use super::uncrossed::{Ended, Fit};
use super::{PointsSpec, Scene, Target};
use face_rig::Stopwatch;
use face_rig::anatomy::JawJoint;
use face_rig::fit::{
    FitError, FitIteration, FitParams, FitReport, Goal, Goals, Parametrization, Similarity,
};
use face_rig::rig::{AffineMap, Rig, RigError, Work};
use fem_solvers::GaussNewtonFailure;
use std::collections::BTreeMap;

/// Which points of a target are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
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

impl PointsSpec {
    /// As a fit takes them.
    pub fn observed(self, landmark_weight: f64) -> Observed {
        match self {
            Self::Landmarks => Observed::Landmarks,
            Self::Dense => Observed::Dense,
            Self::Both => Observed::Both { landmark_weight },
        }
    }
}

/// How an expression's fit ended.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ExpressionFit {
    /// Name of the target.
    pub name: String,
    /// Points fitted.
    pub points: usize,
    /// What laid the target over the face before the fit, if that was asked for.
    pub alignment: Option<Similarity>,
    /// Root-mean-square distance of the points fitted at rest, millimeters; of landmarks alone where both
    /// they and the dense skin are fitted, whose distance is [`dense`](Self::dense).
    pub rms_before_mm: f64,
    /// The same after the fit.
    pub rms_after_mm: f64,
    /// Largest distance of the same points after the fit, millimeters.
    pub largest_mm: f64,
    /// Steps.
    pub iterations: usize,
    /// What it took.
    pub work: Work,
    /// Seconds.
    pub seconds: f64,
    /// Why it stopped, or why it failed.
    pub outcome: Outcome,
    /// The jaw's motion in the numbers of its joint.
    pub jaw_pose: JawPose,
    /// Distances of the whole skin, where the target knows it.
    pub dense: Option<DenseError>,
    /// x ↦ M_j x + t_j of the jaw, meters.
    pub jaw: AffineMap,
    /// x ↦ M_c x + t_c of the head, meters.
    pub cranium: AffineMap,
    /// The smallest det F of all elements; below 0 where one is turned inside out.
    #[serde(rename = "smallest_det_F")]
    pub smallest_ratio: f64,
    /// Elements turned inside out.
    pub inverted_tets: usize,
    /// How deep flesh lies in flesh or solids beyond rest, millimeters, where the scene has contact.
    pub deepest_contact_mm: Option<f64>,
    /// Triangles of the skin that pass through others, where the scene has a skin.
    pub crossing_triangles: Option<usize>,
    /// Every activation, in the scene's order of muscles.
    pub activations: Vec<f64>,
    /// The value of every control of the scene by its name, in its own unit: pascals for a cavity, a
    /// factor for a load, a relative change for a strength or a stiffness.
    pub controls: BTreeMap<String, f64>,
    /// The way there; its distances are those of all points fitted.
    pub history: Vec<FitIteration>,
    /// The numbers found, for a warm start.
    #[serde(skip)]
    pub q: Vec<f64>,
    /// x(θ), meters.
    #[serde(skip)]
    pub positions: Vec<[f64; 3]>,
}

/// A motion of the jaw in the numbers of its joint, whatever it was fitted as.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct JawPose {
    /// Opening, degrees.
    pub opening_degrees: f64,
    /// Beyond what the opening brings with it, along the path of the condyles, millimeters.
    pub protrusion_mm: f64,
    /// Along the axis, millimeters.
    pub lateral_mm: f64,
    /// Degrees; positive turns the chin to the side that the axis points to.
    pub yaw_degrees: f64,
    /// How far the hinge's point is beside the path, millimeters; 0 for a jaw in its joint.
    pub beside_mm: f64,
    /// The numbers that ended on a limit of the joint, or beyond.
    pub at_limits: Vec<&'static str>,
    /// The largest distance of a condyle from where it truly is, millimeters, where that is known.
    pub condyles_off_mm: Option<f64>,
}

/// Distances of the whole skin from a dense target.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct DenseError {
    /// Root mean square at rest, millimeters.
    pub rms_before_mm: f64,
    /// Root mean square after the fit, millimeters.
    pub rms_after_mm: f64,
    /// The largest after the fit, millimeters.
    pub largest_mm: f64,
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
    /// Was a stop rule met at a possible pose?
    pub fn converged(&self) -> bool {
        matches!(self.outcome, Outcome::Converged(_))
    }
}

/// Fits one target from the numbers `start`; the rig is left at the result.
///
/// With contact of the flesh a pose can have two shapes, one of them with lips that have passed through
/// each other. Where the skin of the result crosses itself more than at rest, its pose is solved from
/// rest as well, and the fit goes on from that shape if it crosses itself less.
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
    let (begin, before) = (Stopwatch::start(), rig.work());
    let goals = goals(scene, target, seen);
    let mut fit = Fit {
        fitter: goals.fitter(map, params),
        goals: &goals,
        observer,
    };
    let Ended {
        report, outcome, ..
    } = fit.run(scene, rig, start)?;
    let FitReport {
        q,
        parameters,
        iterations,
        positions,
        ..
    } = report;
    let last = iterations.last();
    let (ratios, deepest) = measured(rig).map_err(|error| FitError::Pose(Box::new(error)))?;
    let jaw_pose = jaw_pose(&scene.joint, &parameters.jaw, target.jaw_truth.as_ref());
    let outcome = possible(outcome, &ratios, &scene.joint, &map.jaw, &parameters.jaw);
    let told = told(scene, target, seen);
    let rms = told.rms(&positions);
    let outcome = met(outcome, scene, target, rms);
    Ok(ExpressionFit {
        name: target.name.clone(),
        points: goals.counted(),
        alignment: target.alignment,
        rms_before_mm: 1e3 * told.rms(scene.mesh.nodes()),
        rms_after_mm: 1e3 * rms,
        largest_mm: 1e3 * told.largest(&positions),
        iterations: last.map_or(0, |i| i.iteration),
        work: rig.work() - before,
        seconds: begin.elapsed().as_secs_f64(),
        outcome,
        jaw_pose,
        dense: dense_error(scene, target, &positions),
        jaw: parameters.jaw,
        cranium: parameters.cranium,
        smallest_ratio: ratios.iter().copied().fold(f64::INFINITY, f64::min),
        inverted_tets: ratios.iter().filter(|ratio| !(**ratio > 0.0)).count(),
        deepest_contact_mm: deepest.map(|depth| 1e3 * depth),
        crossing_triangles: (scene.skin.as_ref()).map(|skin| skin.crossings(&positions)),
        activations: parameters.activations,
        controls: (scene.influences.iter().map(|i| i.name.clone()))
            .zip(parameters.controls)
            .collect(),
        history: iterations,
        q,
        positions,
    })
}

/// det F of every element where the rig is, and the deepest contact.
fn measured(rig: &mut Rig) -> Result<(Vec<f64>, Option<f64>), RigError> {
    let deepest = rig.deepest_contact()?;
    let assembly = rig.assembly();
    let shape = assembly.positions(&rig.equilibrium().in_cranium_frame)?;
    Ok((assembly.volume_ratios(shape)?, deepest))
}

/// The pose that a fit ended with, and how it did.
pub(super) fn ended(fit: Result<FitReport, FitError>) -> Result<(FitReport, Outcome), FitError> {
    match fit {
        Ok(report) => {
            let stop = report.stop;
            Ok((report, Outcome::Converged(stop)))
        }
        Err(FitError::NotConverged { source, best }) => {
            let why = match source.reason {
                GaussNewtonFailure::NotConverged => Unfinished::Steps(source.iteration),
                reason => Unfinished::Failed(Box::new(reason)),
            };
            Ok((*best, Outcome::NotConverged(why)))
        }
        Err(error) => Err(error),
    }
}

/// A fit that ends far from its target was given one of another face, place or unit.
fn met(outcome: Outcome, scene: &Scene, target: &Target, rms: f64) -> Outcome {
    if !matches!(outcome, Outcome::Converged(_)) {
        return outcome;
    }
    let counted = target.landmarks.iter().filter(|goal| goal.weight > 0.0);
    let (rest, target) = counted
        .map(|goal| (goal.point.position(scene.mesh.nodes()), goal.position))
        .unzip();
    let pairs = Pairs { target, rest };
    let spread = pairs.spread();
    if !(rms > FAR * spread) {
        return outcome;
    }
    let suspicion = Suspicion::of(&pairs, rms);
    Outcome::Missed {
        rms,
        spread,
        suspicion,
    }
}

fn jaw_pose(joint: &JawJoint, jaw: &AffineMap, truth: Option<&AffineMap>) -> JawPose {
    let ([opening, protrusion, lateral, yaw], beside) = joint.closest(jaw);
    JawPose {
        opening_degrees: opening.to_degrees(),
        protrusion_mm: 1e3 * protrusion,
        lateral_mm: 1e3 * lateral,
        yaw_degrees: yaw.to_degrees(),
        beside_mm: 1e3 * beside,
        at_limits: past_limits(joint, jaw, -LIMIT_SHARE),
        condyles_off_mm: truth.map(|truth| 1e3 * joint.condyles_apart(jaw, truth)),
    }
}

fn dense_error(scene: &Scene, target: &Target, x: &[[f64; 3]]) -> Option<DenseError> {
    target.dense.as_ref()?;
    let goals = goals(scene, target, Observed::Dense);
    Some(DenseError {
        rms_before_mm: 1e3 * goals.rms(scene.mesh.nodes()),
        rms_after_mm: 1e3 * goals.rms(x),
        largest_mm: 1e3 * goals.largest(x),
    })
}

/// Whose distances are told: of landmarks, where they are fitted.
fn told(scene: &Scene, target: &Target, seen: Observed) -> Goals {
    match seen {
        Observed::Both { .. } if target.landmarks.iter().any(|goal| goal.weight > 0.0) => {
            goals(scene, target, Observed::Landmarks)
        }
        _ => goals(scene, target, seen),
    }
}

/// What a fit of a target is to reach.
fn goals(scene: &Scene, target: &Target, seen: Observed) -> Goals {
    let share = match seen {
        Observed::Both { landmark_weight } => landmark_weight,
        _ => 1.0,
    };
    let landmarks = target.landmarks.iter().map(|goal| Goal {
        weight: share * goal.weight,
        ..*goal
    });
    let landmarks = landmarks.filter(|_| seen != Observed::Dense);
    let dense = scene.skin.as_ref().zip(target.dense.as_ref());
    let dense = dense.filter(|_| seen != Observed::Landmarks);
    let dense = dense.into_iter().flat_map(|(skin, places)| {
        skin.points.iter().zip(places).map(|(point, place)| Goal {
            point: *point,
            position: *place,
            weight: 1.0,
        })
    });
    landmarks.chain(dense).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn the_jaw_is_told_in_its_own_numbers_and_compared_with_the_truth() {
        let joint = Scene::builtin(5_000).expect("a face").joint;
        let jaw = joint.motion([0.2, 0.003, 0.005, 0.05]).0;
        let mut truth = jaw;
        truth.translation[2] += 0.002;
        let told = jaw_pose(&joint, &jaw, Some(&truth));
        assert!((told.opening_degrees - 0.2_f64.to_degrees()).abs() < 1e-12);
        assert!((told.protrusion_mm - 3.0).abs() < 1e-12 && (told.lateral_mm - 5.0).abs() < 1e-12);
        assert!((told.yaw_degrees - 0.05_f64.to_degrees()).abs() < 1e-12);
        assert!(told.beside_mm < 1e-12);
        assert_eq!(told.at_limits, ["lateral shift"]);
        let off = told.condyles_off_mm.expect("a truth");
        assert!((off - 2.0).abs() < 1e-12, "{off}");
        assert_eq!(jaw_pose(&joint, &jaw, None).condyles_off_mm, None);
    }
}
