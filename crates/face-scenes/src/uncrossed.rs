//! Of the shapes that one pose can have with contact, the one that a fit should have.
//!
//! Lips that were driven through each other stay there: both shapes are equilibria. A fit walks from
//! pose to pose, so it can come to the wrong one; from rest the same pose is reached on the right side.
//! Or it stands on a shape that is not found again from the poses around it, so that no step leads on.

use super::Scene;
use super::expression::ended;
use super::outcome::Outcome;
use face_rig::fit::{FitError, FitIteration, FitReport, Fitter, Goals};
use face_rig::rig::{Equilibrium, Parameters, Rig};

/// How often a fit is taken up again on another shape.
const ROUNDS: usize = 2;
/// From which change of the distance on a pose has another shape, as a share.
const ANOTHER: f64 = 1e-4;
/// In how many parts a pose is reached from rest: what is thin is easily passed in one.
const PARTS: usize = 4;

/// A fit that ended, with the equilibrium that it found.
struct Ended {
    report: FitReport,
    outcome: Outcome,
    at: Equilibrium,
    crossings: usize,
}

/// A fit that failed on a shape to which its own pose does not lead any more goes on from the shape that
/// it leads to: its numbers were good, the cost that no step could lower was of another shape.
pub(super) fn taken_up_again(
    rig: &mut Rig,
    fitter: &Fitter,
    goals: &Goals,
    first: (FitReport, Outcome),
    observer: &mut dyn FnMut(&FitIteration),
) -> Result<(FitReport, Outcome), FitError> {
    let (mut report, mut outcome) = first;
    for _ in 0..ROUNDS {
        let told = report.iterations.last().map_or(f64::NAN, |i| i.rms_mm);
        let moved = (1e3 * goals.rms(&report.positions) - told).abs();
        let lost = matches!(outcome, Outcome::NotConverged(_)) && moved > ANOTHER * told;
        if !lost {
            break;
        }
        let (next, end) = ended(fitter.fit(rig, &report.q, observer))?;
        (report, outcome) = (after(&report, next), end);
    }
    Ok((report, outcome))
}

/// Where flesh is to touch and the skin of a fit crosses itself more than at rest, the pose is solved
/// from rest, and fitted on from there if its skin crosses itself less. The rig is left at the result.
pub(super) fn prefer_uncrossed(
    scene: &Scene,
    rig: &mut Rig,
    fitter: &Fitter,
    (report, outcome): (FitReport, Outcome),
    observer: &mut dyn FnMut(&FitIteration),
) -> Result<(FitReport, Outcome), FitError> {
    let touching = scene
        .skin
        .as_ref()
        .filter(|_| scene.contact.flesh.is_some());
    let Some(skin) = touching else {
        return Ok((report, outcome));
    };
    let at_rest = skin.crossings(scene.mesh.nodes());
    let mut best = Ended {
        crossings: skin.crossings(&report.positions),
        at: rig.equilibrium().clone(),
        report,
        outcome,
    };
    for round in 0..=ROUNDS {
        if best.crossings <= at_rest {
            break;
        }
        let Some(at) = from_rest(rig, &best.report)? else {
            break;
        };
        let positions = at.positions();
        let count = skin.crossings(&positions);
        if count >= best.crossings {
            break;
        }
        best.crossings = count;
        best.at = at;
        best.report.positions = positions;
        if round == ROUNDS {
            break;
        }
        let (report, outcome) = ended(fitter.fit(rig, &best.report.q, observer))?;
        best = Ended {
            crossings: skin.crossings(&report.positions),
            at: rig.equilibrium().clone(),
            report: after(&best.report, report),
            outcome,
        };
    }
    rig.start_from(best.at).map_err(pose)?;
    Ok((best.report, best.outcome))
}

/// The same pose, reached from rest; `None` where that fails.
fn from_rest(rig: &mut Rig, report: &FitReport) -> Result<Option<Equilibrium>, FitError> {
    let relaxed = Parameters::rest(rig.muscles()).with_controls(vec![0.0; rig.controls()]);
    let rest = Equilibrium {
        parameters: relaxed,
        in_cranium_frame: rig.assembly().rest().to_vec(),
    };
    let relaxed = rest.parameters.clone();
    rig.start_from(rest).map_err(pose)?;
    for part in 1..=PARTS {
        let share = part as f64 / PARTS as f64;
        let there = match part {
            PARTS => report.parameters.clone(),
            _ => relaxed.toward(&report.parameters, share),
        };
        match rig.solve(&there) {
            Ok(_) => {}
            Err(error) if error.is_cancelled() => {
                return Err(FitError::Cancelled {
                    q: report.q.clone(),
                    iterations: report.iterations.clone(),
                });
            }
            Err(_) => return Ok(None),
        }
    }
    Ok(Some(rig.equilibrium().clone()))
}

fn pose(error: face_rig::rig::RigError) -> FitError {
    FitError::Pose(Box::new(error))
}

/// A fit that went on where an earlier one had ended: its start is no step.
fn after(earlier: &FitReport, mut report: FitReport) -> FitReport {
    let mut iterations = earlier.iterations.clone();
    let (steps, seconds) = iterations
        .last()
        .map_or((0, 0.0), |last| (last.iteration, last.seconds));
    let went_on = report.iterations.iter().filter(|i| i.iteration > 0);
    iterations.extend(went_on.map(|i| FitIteration {
        iteration: steps + i.iteration,
        seconds: seconds + i.seconds,
        ..*i
    }));
    report.iterations = iterations;
    report
}
