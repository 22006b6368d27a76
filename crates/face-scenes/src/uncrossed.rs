//! Of the shapes that one pose can have with contact, the one that a fit should have.
//!
//! Lips that were driven through each other stay there: both shapes are equilibria. A fit walks from
//! pose to pose, so it can come to the wrong one; from rest the same pose is reached on the right side.
//! Or it stands on a shape that is not found again from the poses around it, so that no step leads on.

use super::Scene;
use super::expression::ended;
use super::outcome::{Outcome, Unfinished};
use face_rig::fit::{FitError, FitIteration, FitParams, FitReport, Fitter, Goals};
use face_rig::rig::{Equilibrium, Parameters, Rig};

/// How often a fit is taken up again on another shape.
const ROUNDS: usize = 2;
/// From which change of the distance on a pose has another shape, as a share.
pub(super) const ANOTHER: f64 = 1e-4;
/// From which change on what was fitted is not what the pose is. Which partners face each other is decided
/// by a threshold when pairs are looked for, so the same numbers have shapes that differ by a little at a
/// corner of lips that press: 1.695 and 1.707 mm from a target, where a lip that stands or not on a pair
/// which is not found again makes 2.50 and 2.67.
pub(super) const UNSETTLED: f64 = 1e-2;
/// In how many parts a pose is reached from rest: what is thin is easily passed in one.
const PARTS: usize = 4;

/// A fit that ended, with the equilibrium that it left.
#[derive(Clone)]
pub(super) struct Ended {
    pub report: FitReport,
    pub outcome: Outcome,
    at: Equilibrium,
    /// The distance of the shape that was fitted last, millimeters: its start's where no step was taken.
    told_mm: f64,
}

/// A fit to some goals, whoever watches it.
pub(super) struct Fit<'a> {
    pub fitter: Fitter<'a>,
    pub goals: &'a Goals,
    pub observer: &'a mut dyn FnMut(&FitIteration),
}

impl Ended {
    pub fn of(rig: &Rig, (report, outcome): (FitReport, Outcome)) -> Self {
        let last = report.iterations.last();
        Self {
            told_mm: last.map_or(f64::NAN, |i| i.rms_mm),
            report,
            outcome,
            at: rig.equilibrium().clone(),
        }
    }

    /// Steps so far.
    fn steps(&self) -> usize {
        self.report.iterations.last().map_or(0, |i| i.iteration)
    }

    /// Another shape of the same pose, to which nothing was fitted. What converged may have the same end
    /// on it: whether its distance is near enough for that [`Fit::settled`] asks of the shape that is left.
    pub fn at_another(&self, at: Equilibrium, goals: &Goals) -> Self {
        let mut other = self.clone();
        other.report.positions = at.positions();
        other.at = at;
        if !matches!(other.outcome, Outcome::Converged(_)) {
            other.outcome = other.another(goals);
        }
        other
    }

    fn another(&self, goals: &Goals) -> Outcome {
        let told_mm = self.told_mm;
        let found_mm = 1e3 * goals.rms(&self.report.positions);
        Outcome::NotConverged(Unfinished::AnotherShape { told_mm, found_mm })
    }
}

impl Fit<'_> {
    /// Is the shape that the pose leads to by now farther from the one that was fitted than that share of
    /// its distance?
    pub fn has_moved(&self, of: &Ended, share: f64) -> bool {
        let found = 1e3 * self.goals.rms(&of.report.positions);
        let nothing = 1e3 * self.fitter.params.rms_tolerance;
        !((found - of.told_mm).abs() <= nothing.max(share * of.told_mm))
    }

    /// From the numbers `start` to the end, on whichever shape a fit should have. The rig is left there.
    pub fn run(&mut self, scene: &Scene, rig: &mut Rig, start: &[f64]) -> Result<Ended, FitError> {
        let first = ended(self.fitter.fit(rig, start, &mut *self.observer))?;
        let first = self.taken_up_again(rig, Ended::of(rig, first))?;
        let best = self.uncrossed(scene, rig, first)?;
        let best = self.settled(best);
        if *rig.equilibrium() != best.at {
            rig.start_from(best.at.clone()).map_err(pose)?;
        }
        Ok(best)
    }

    /// What converged on one shape and is left on another did not converge, unless their distances from
    /// the target differ by less than [`UNSETTLED`].
    pub fn settled(&self, mut left: Ended) -> Ended {
        let converged = matches!(left.outcome, Outcome::Converged(_));
        if converged && self.has_moved(&left, UNSETTLED) {
            left.outcome = left.another(self.goals);
        }
        left
    }

    /// A fit on a shape to which its own pose does not lead any more goes on from the shape that it leads
    /// to: the cost that no step could lower was of another shape.
    pub fn taken_up_again(&mut self, rig: &mut Rig, first: Ended) -> Result<Ended, FitError> {
        let mut last = first;
        for _ in 0..ROUNDS {
            let out_of_steps = matches!(last.outcome, Outcome::NotConverged(Unfinished::Steps(_)));
            if out_of_steps || !self.has_moved(&last, ANOTHER) {
                break;
            }
            match self.gone_on(rig, &last)? {
                Some(next) => last = next,
                None => break,
            }
        }
        Ok(last)
    }

    /// Where flesh is to touch and the skin of a fit crosses itself more than at rest, the pose is solved
    /// from rest, and fitted on from there if its skin crosses itself less.
    fn uncrossed(&mut self, scene: &Scene, rig: &mut Rig, first: Ended) -> Result<Ended, FitError> {
        let skin = scene.skin.as_ref();
        let Some(skin) = skin.filter(|_| scene.contact.flesh.is_some()) else {
            return Ok(first);
        };
        let crossings = |of: &Ended| skin.crossings(&of.report.positions);
        let at_rest = skin.crossings(scene.mesh.nodes());
        let mut best = first;
        for _ in 0..ROUNDS {
            if crossings(&best) <= at_rest || best.steps() >= self.fitter.params.max_iterations {
                break;
            }
            let Some(at) = from_rest(rig, &best.report)? else {
                break;
            };
            let other = best.at_another(at, self.goals);
            if crossings(&other) >= crossings(&best) {
                break;
            }
            match self.gone_on(rig, &other)? {
                Some(next) if crossings(&next) <= crossings(&other) => best = next,
                _ => {
                    best = other;
                    break;
                }
            }
        }
        Ok(best)
    }

    /// The fit from where an earlier one ended, with the steps that are left; `None` where it fails or
    /// none is left.
    fn gone_on(&mut self, rig: &mut Rig, earlier: &Ended) -> Result<Option<Ended>, FitError> {
        let steps = earlier.steps();
        let left = self.fitter.params.max_iterations.saturating_sub(steps);
        if left == 0 {
            return Ok(None);
        }
        let params = FitParams {
            max_iterations: left,
            ..self.fitter.params.clone()
        };
        let fitter = Fitter {
            params: &params,
            ..self.fitter
        };
        let mut observer = |i: &FitIteration| {
            let iteration = steps + i.iteration;
            (self.observer)(&FitIteration { iteration, ..*i });
        };
        match ended(fitter.fit(rig, &earlier.report.q, &mut observer)) {
            Ok((report, outcome)) => {
                let outcome = match outcome {
                    Outcome::NotConverged(Unfinished::Steps(n)) => {
                        Outcome::NotConverged(Unfinished::Steps(steps + n))
                    }
                    other => other,
                };
                let mut ended = Ended::of(rig, (report, outcome));
                let all = joined(&earlier.report.iterations, &ended.report.iterations);
                ended.report.iterations = all;
                Ok(Some(ended))
            }
            Err(FitError::Cancelled { q, iterations }) => Err(FitError::Cancelled {
                q,
                iterations: joined(&earlier.report.iterations, &iterations),
            }),
            Err(_) => Ok(None),
        }
    }
}

/// The same pose, reached from rest; `None` where that fails.
fn from_rest(rig: &mut Rig, report: &FitReport) -> Result<Option<Equilibrium>, FitError> {
    let relaxed = Parameters::rest(rig.muscles()).with_controls(vec![0.0; rig.controls()]);
    let rest = Equilibrium {
        parameters: relaxed.clone(),
        in_cranium_frame: rig.assembly().rest().to_vec(),
    };
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

/// The steps of both; the start of the second is no step.
fn joined(earlier: &[FitIteration], later: &[FitIteration]) -> Vec<FitIteration> {
    let (steps, seconds) = earlier
        .last()
        .map_or((0, 0.0), |i| (i.iteration, i.seconds));
    let went_on = later.iter().filter(|i| i.iteration > 0);
    let went_on = went_on.map(|i| FitIteration {
        iteration: steps + i.iteration,
        seconds: seconds + i.seconds,
        ..*i
    });
    earlier.iter().copied().chain(went_on).collect()
}
