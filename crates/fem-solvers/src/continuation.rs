//! Following solutions along a path from 0 to 1 in steps that adapt to success and failure.

use std::marker::PhantomData;
use thiserror::Error;

/// How large the steps are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuationParams {
    /// First step, in (0, 1].
    pub first_step: f64,
    /// Smallest step; a failure there ends the walk.
    pub smallest_step: f64,
    /// Factor on the step after a failure, in (0, 1).
    pub shrink: f64,
    /// Factor on the step after a success, at least 1.
    pub growth: f64,
}

impl Default for ContinuationParams {
    fn default() -> Self {
        Self {
            first_step: 1.0,
            smallest_step: 1.0 / 1024.0,
            shrink: 0.5,
            growth: 2.0,
        }
    }
}

/// A walk that reached the end of its path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ContinuationInfo {
    /// Places that were solved.
    pub steps: usize,
    /// Solves that failed and were repeated with a smaller step.
    pub failures: usize,
}

/// A walk that got stuck; the state is that of the last place that was solved.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ContinuationError<E> {
    /// Even the smallest step failed, or the path gave up.
    #[error("stuck at {reached} of the way: a step of {step:e} still fails: {source}")]
    Stuck {
        /// The last place solved; 0 for the start.
        reached: f64,
        /// The step that failed.
        step: f64,
        /// The work so far.
        info: ContinuationInfo,
        /// Why.
        source: E,
    },
    /// A setting that is not a number or outside its range.
    #[error("{what} is {value}, allowed is {allowed}")]
    Params {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        allowed: &'static str,
    },
}

/// Problems along a path, one for each `s` in [0, 1]; the one at 0 is solved.
pub trait Path {
    /// What a solution is.
    type State: Clone;
    /// Why a place could not be solved.
    type Error;

    /// Moves the solution at `from` to a guess at `to`; it stays where it is by default.
    fn predict(&mut self, _state: &mut Self::State, _from: f64, _to: f64) {}

    /// Makes the guess the solution at `s`.
    ///
    /// # Errors
    /// Whatever the solve runs into; the state may then hold anything.
    fn correct(&mut self, s: f64, state: &mut Self::State) -> Result<(), Self::Error>;

    /// Is this an error that no smaller step would mend? By default every step is tried.
    fn gives_up(&self, _error: &Self::Error) -> bool {
        false
    }
}

/// Follows the solution of `path` from `s = 0`, where it is `state`, to exactly 1.
///
/// Where a place cannot be solved the last solution is put back and a smaller step tried.
///
/// # Errors
/// [`ContinuationError::Stuck`] with the last place reached; `state` is the one solved there.
pub fn follow_path<P: Path + ?Sized>(
    path: &mut P,
    state: &mut P::State,
    params: &ContinuationParams,
) -> Result<ContinuationInfo, ContinuationError<P::Error>> {
    params.check()?;
    let mut info = ContinuationInfo::default();
    let (mut reached, mut step) = (0.0_f64, params.first_step);
    while reached < 1.0 {
        let next = params.next(reached, step);
        let last_good = state.clone();
        path.predict(state, reached, next);
        match path.correct(next, state) {
            Ok(()) => {
                reached = next;
                info.steps += 1;
                step *= params.growth;
            }
            Err(source) => {
                *state = last_good;
                info.failures += 1;
                let tried = next - reached;
                step = params.shrink * tried;
                if step < params.smallest_step || path.gives_up(&source) {
                    return Err(ContinuationError::Stuck {
                        reached,
                        step: tried,
                        info,
                        source,
                    });
                }
            }
        }
    }
    Ok(info)
}

impl ContinuationParams {
    /// The place to try from `reached`.
    fn next(&self, reached: f64, step: f64) -> f64 {
        // A remainder shorter than half a step is not worth a step of its own.
        if reached + 1.5 * step >= 1.0 && reached + step < 1.0 && step > self.smallest_step {
            0.5 * (reached + 1.0)
        } else {
            (reached + step).min(1.0)
        }
    }

    fn check<E>(&self) -> Result<(), ContinuationError<E>> {
        // A step that rounding swallows would never arrive.
        let shortest = f64::EPSILON;
        let (first, smallest) = (self.first_step, self.smallest_step);
        let tests = [
            ("first_step", first, first > 0.0 && first <= 1.0, "(0, 1]"),
            (
                "smallest_step",
                smallest,
                smallest >= shortest && smallest <= first,
                "[2.2e-16, first_step]",
            ),
            (
                "shrink",
                self.shrink,
                self.shrink > 0.0 && self.shrink < 1.0,
                "(0, 1)",
            ),
            (
                "growth",
                self.growth,
                self.growth >= 1.0 && self.growth < f64::INFINITY,
                "[1, ∞)",
            ),
        ];
        match tests.into_iter().find(|(_, _, good, _)| !good) {
            None => Ok(()),
            Some((what, value, _, allowed)) => Err(ContinuationError::Params {
                what,
                value,
                allowed,
            }),
        }
    }
}

/// [`follow_path`] for a load that grows from above 0 to exactly 1, without a guess:
/// `solve(load, state)` starts from the state of the last load solved and may leave anything in it
/// when it fails.
///
/// # Errors
/// [`ContinuationError::Stuck`] with the last load reached; `state` is the one solved there.
///
/// ```
/// use fem_solvers::{walk_load, ContinuationParams};
/// let mut x = 0.0_f64;
/// // A solver that can only follow small increments.
/// let info = walk_load(&mut x, &ContinuationParams::default(), |load, x: &mut f64| {
///     if load - *x > 0.3 { Err("too far") } else { *x = load; Ok(()) }
/// }).unwrap();
/// assert_eq!(x, 1.0);
/// assert_eq!(info.steps, 4);
/// ```
pub fn walk_load<S: Clone, E>(
    state: &mut S,
    params: &ContinuationParams,
    solve: impl FnMut(f64, &mut S) -> Result<(), E>,
) -> Result<ContinuationInfo, ContinuationError<E>> {
    let mut load = Load {
        solve,
        state: PhantomData,
    };
    follow_path(&mut load, state, params)
}

struct Load<F, S> {
    solve: F,
    state: PhantomData<fn(&mut S)>,
}

impl<S: Clone, E, F: FnMut(f64, &mut S) -> Result<(), E>> Path for Load<F, S> {
    type State = S;
    type Error = E;
    fn correct(&mut self, s: f64, state: &mut S) -> Result<(), E> {
        (self.solve)(s, state)
    }
}
