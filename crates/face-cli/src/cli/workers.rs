//! Fits side by side: each worker has a rig and threads of its own.
//!
//! One fit keeps several threads busy badly, and in a pool that fits share a thread that waits inside
//! one of them would take up a whole other one.

use super::args::Format;
use super::at_once::share;
use super::error::Failure;
use super::fit::line;
use super::gallery::{Finished, Gallery};
use super::output::Output;
use super::progress::bar;
use super::shape_files::Fields;
use face_rig::fit::{FitError, FitIteration, FitParams, Parametrization};
use face_rig::rig::{Equilibrium, Rig, RigParams};
use face_scenes::{ExpressionFit, PointsSpec, Scene, Target, fit_expression};
use indicatif::ProgressBar;
use rayon::{Scope, ThreadPoolBuilder};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// Every fit in the order of the targets and, by their names, why the others could not even begin.
pub type Fits = (Vec<ExpressionFit>, BTreeMap<String, String>);

/// What all fits have in common.
pub struct Fitting<'a> {
    pub scene: &'a Scene,
    pub rig_params: RigParams,
    pub points: PointsSpec,
    pub landmark_weight: f64,
    pub map: &'a Parametrization,
    pub params: &'a FitParams,
    /// Each fit starts from the result of the one before: one at a time.
    pub warm_start: bool,
    pub formats: Vec<Format>,
    pub gallery: &'a Gallery<'a>,
}

/// What became of a target.
enum End {
    Fitted(Box<ExpressionFit>),
    /// The name of the target, and why.
    Impossible(String, String),
}

/// How the target at this place ended.
type Placed = (usize, Result<End, Failure>);

/// Targets that workers take in their order, and how far they are.
struct Queue<'a> {
    targets: &'a [&'a Target],
    next: AtomicUsize,
    stopped: AtomicBool,
    at_work: AtomicUsize,
    progress: ProgressBar,
}

impl<'a> Queue<'a> {
    fn new(targets: &'a [&'a Target]) -> Self {
        Self {
            targets,
            next: AtomicUsize::new(0),
            stopped: AtomicBool::new(false),
            at_work: AtomicUsize::new(0),
            progress: bar(targets.len(), "expression"),
        }
    }

    /// The next target, with its place. Whatever fails, all before it have been taken by then.
    fn take(&self) -> Option<(usize, &'a Target)> {
        let stopped = self.stopped.load(Relaxed);
        let place = (!stopped).then(|| self.next.fetch_add(1, Relaxed))?;
        Some((place, *self.targets.get(place)?))
    }

    fn tell(&self, target: &Target, step: &FitIteration) {
        let others = match self.at_work.load(Relaxed) {
            0 | 1 => String::new(),
            count => format!("{count} at work, "),
        };
        self.progress.set_message(format!(
            "{others}{}: step {}, RMS {:.3} mm, {} activations at bounds",
            target.name, step.iteration, step.rms_mm, step.activations_at_bounds
        ));
    }
}

/// A rig, where it stands at rest, and the numbers of the next fit's start.
struct Seat {
    rig: Rig,
    rest: Equilibrium,
    start: Vec<f64>,
    /// Has it had a fit?
    used: bool,
}

impl Fitting<'_> {
    /// `at_once` fits at a time, the first worker's with the rig `first`; files and pictures of those that
    /// are done are made beside them.
    pub fn run(
        &self,
        first: Rig,
        targets: &[&Target],
        at_once: usize,
        out: &mut Output,
    ) -> Result<Fits, Failure> {
        let queue = Queue::new(targets);
        out.enter("fit");
        let first = self.seated(first);
        let ends = rayon::in_place_scope(|beside| {
            let ends = self.all(first, &queue, at_once, beside);
            out.enter("files and pictures");
            queue.progress.set_message("files and pictures");
            ends
        });
        queue.progress.finish_and_clear();
        in_order(ends)
    }

    fn all<'t>(
        &'t self,
        first: Seat,
        queue: &Queue<'t>,
        at_once: usize,
        beside: &Scope<'t>,
    ) -> Vec<Placed> {
        if at_once <= 1 {
            return self.work(Some(first), queue, beside);
        }
        let threads = rayon::current_num_threads();
        let mut first = Some(first);
        std::thread::scope(|scope| {
            let workers = (0..at_once).map(|worker| {
                let seat = first.take();
                let threads = share(threads, at_once, worker);
                scope.spawn(move || {
                    let work = || self.work(seat, queue, beside);
                    match ThreadPoolBuilder::new().num_threads(threads).build() {
                        Ok(pool) => pool.install(work),
                        Err(_) => work(),
                    }
                })
            });
            let workers: Vec<_> = workers.collect();
            let ends = workers.into_iter().map(|worker| {
                let ends = worker.join();
                ends.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            });
            ends.flatten().collect()
        })
    }

    /// One fit after the other, as long as there are targets.
    fn work<'t>(
        &'t self,
        mut seat: Option<Seat>,
        queue: &Queue<'t>,
        beside: &Scope<'t>,
    ) -> Vec<Placed> {
        queue.at_work.fetch_add(1, Relaxed);
        let mut ends = Vec::new();
        // A full disk, say, makes all further fits useless; the gallery tells why when it is asked to finish.
        while !self.gallery.failed()
            && let Some((place, target)) = queue.take()
        {
            let end = self.end(place, target, &mut seat, queue, beside);
            queue.progress.inc(1);
            if end.is_err() {
                queue.stopped.store(true, Relaxed);
            }
            ends.push((place, end));
        }
        queue.at_work.fetch_sub(1, Relaxed);
        ends
    }

    fn end<'t>(
        &'t self,
        place: usize,
        target: &'t Target,
        seat: &mut Option<Seat>,
        queue: &Queue<'t>,
        beside: &Scope<'t>,
    ) -> Result<End, Failure> {
        let Seat { rig, start, .. } = self.ready(seat)?;
        match self.fit(rig, target, start, queue) {
            Ok(fit) => {
                start.clone_from(&fit.q);
                let finished = self.finished(place, rig, &fit)?;
                beside.spawn(move |_| self.gallery.add(target, &finished));
                Ok(End::Fitted(Box::new(fit)))
            }
            Err(FitError::Start(why) | FitError::Pose(why)) => {
                Ok(End::Impossible(target.name.clone(), why.to_string()))
            }
            Err(source) => Err(Failure::Target {
                name: target.name.clone(),
                source,
            }),
        }
    }

    fn seated(&self, mut rig: Rig) -> Seat {
        let rest = rig.equilibrium().clone();
        // What a rig finds out in its first solve, and never again, counts to no fit. Whether there is
        // an equilibrium at rest is for the fits to tell.
        rig.solve(&rest.parameters).ok();
        Seat {
            rig,
            rest,
            start: self.map.rest(),
            used: false,
        }
    }

    /// A rig that knows of no other fit, unless each goes on from the one before.
    fn ready<'s>(&self, seat: &'s mut Option<Seat>) -> Result<&'s mut Seat, Failure> {
        let seat = match seat {
            Some(kept) => kept,
            None => seat.insert(self.seated(self.scene.rig(self.rig_params)?)),
        };
        if !(seat.used && self.warm_start) {
            seat.rig.start_from(seat.rest.clone())?;
            seat.start = self.map.rest();
        }
        seat.used = true;
        Ok(seat)
    }

    fn fit(
        &self,
        rig: &mut Rig,
        target: &Target,
        start: &[f64],
        queue: &Queue,
    ) -> Result<ExpressionFit, FitError> {
        fit_expression(
            self.scene,
            rig,
            target,
            self.points.observed(self.landmark_weight),
            self.map,
            self.params,
            start,
            &mut |step| queue.tell(target, step),
        )
    }

    fn finished(&self, place: usize, rig: &Rig, fit: &ExpressionFit) -> Result<Finished, Failure> {
        let parameters = self.map.parameters(&fit.q)?;
        Ok(Finished {
            place,
            name: fit.name.clone(),
            heading: line(fit, self.points),
            caption: format!("{}: {:.2} mm RMS", fit.name, fit.rms_after_mm),
            positions: fit.positions.clone(),
            jaw: parameters.jaw,
            fields: Fields::of(&self.formats, self.scene, rig, &parameters, &fit.positions)?,
        })
    }
}

/// Ends in the order of the targets; where some are errors, the first of them.
fn in_order(mut ends: Vec<Placed>) -> Result<Fits, Failure> {
    ends.sort_by_key(|(place, _)| *place);
    let (mut fits, mut impossible) = (Vec::new(), BTreeMap::new());
    for (_, end) in ends {
        match end? {
            End::Fitted(fit) => fits.push(*fit),
            End::Impossible(name, why) => {
                impossible.insert(name, why);
            }
        }
    }
    Ok((fits, impossible))
}

#[cfg(test)]
mod tests {
    use super::*;
    use face_scenes::TargetKind;

    #[test]
    fn targets_are_taken_in_their_order_until_they_are_all_or_something_failed() {
        let target = |name: &str| Target {
            name: name.to_owned(),
            kind: TargetKind::Expression,
            landmarks: Vec::new(),
            dense: None,
            jaw_truth: None,
            alignment: None,
        };
        let targets = ["a", "b", "c"].map(target);
        let targets = targets.each_ref();
        let (whole, ended) = (Queue::new(&targets), Queue::new(&targets));
        let taken = |queue: &Queue| Some(queue.take()?.1.name.clone());
        assert_eq!(
            [(); 4]
                .map(|()| taken(&whole))
                .map(Option::unwrap_or_default),
            ["a", "b", "c", ""]
        );
        assert_eq!(taken(&ended).as_deref(), Some("a"));
        ended.stopped.store(true, Relaxed);
        assert_eq!(taken(&ended), None);
    }

    #[test]
    fn ends_come_in_the_order_of_targets_and_the_first_error_wins() {
        let impossible = |place: usize| {
            let end = End::Impossible(format!("target {place}"), format!("why {place}"));
            (place, Ok(end))
        };
        let failed = |place: usize| {
            let name = format!("target {place}");
            let source = FitError::EmptyTarget;
            (place, Err(Failure::Target { name, source }))
        };
        let fits = in_order(vec![impossible(2), impossible(0)]).expect("no error");
        let expected = [("target 0", "why 0"), ("target 2", "why 2")];
        let told = fits
            .1
            .iter()
            .map(|(name, why)| (name.as_str(), why.as_str()));
        assert!(told.eq(expected) && fits.0.is_empty());
        let ends = vec![failed(3), impossible(0), failed(1), impossible(2)];
        let error = in_order(ends).expect_err("an error").to_string();
        assert!(error.starts_with("target target 1:"), "{error}");
    }
}
