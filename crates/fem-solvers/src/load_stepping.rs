//! Walking a load from 0 to 1 in steps that adapt to success and failure.

use thiserror::Error;

/// How large the steps are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadSteppingParams {
    /// First step, in (0, 1].
    pub first_step: f64,
    /// Smallest step; a failure there ends the walk.
    pub smallest_step: f64,
    /// Factor on the step after a failure, in (0, 1).
    pub shrink: f64,
    /// Factor on the step after a success, at least 1.
    pub growth: f64,
}

impl Default for LoadSteppingParams {
    fn default() -> Self {
        Self {
            first_step: 1.0,
            smallest_step: 1.0 / 1024.0,
            shrink: 0.5,
            growth: 2.0,
        }
    }
}

/// A walk that reached load 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadSteppingInfo {
    /// Loads that were solved.
    pub steps: usize,
    /// Solves that failed and were repeated with a smaller step.
    pub failures: usize,
}

/// A walk that got stuck; the state is that of the last load that was solved.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LoadSteppingError<E> {
    /// Even the smallest step failed.
    #[error("stuck at load {load}: a step of {step:e} still fails: {source}")]
    Stuck {
        /// The last load solved.
        load: f64,
        /// The step that failed.
        step: f64,
        /// Why.
        source: E,
    },
    /// The parameters make no sense.
    #[error(
        "load stepping needs 0 < smallest_step ≤ first_step ≤ 1, 0 < shrink < 1 and growth ≥ 1"
    )]
    Params,
}

/// Calls `solve(load, state)` for loads that grow from above 0 to exactly 1.
///
/// `solve` starts from the state of the last load solved and may leave anything in it when it fails:
/// the driver puts the last good state back, shrinks the step and tries again.
///
/// # Errors
/// [`LoadSteppingError::Stuck`] with the last load reached; `state` is the one solved there.
///
/// ```
/// use fem_solvers::{walk_load, LoadSteppingParams};
/// let mut x = 0.0_f64;
/// // A solver that can only follow small increments.
/// let info = walk_load(&mut x, &LoadSteppingParams::default(), |load, x: &mut f64| {
///     if load - *x > 0.3 { Err("too far") } else { *x = load; Ok(()) }
/// }).unwrap();
/// assert_eq!(x, 1.0);
/// assert_eq!(info.steps, 4);
/// ```
pub fn walk_load<S: Clone, E>(
    state: &mut S,
    params: &LoadSteppingParams,
    mut solve: impl FnMut(f64, &mut S) -> Result<(), E>,
) -> Result<LoadSteppingInfo, LoadSteppingError<E>> {
    let p = params;
    let sane = p.smallest_step > 0.0
        && p.first_step >= p.smallest_step
        && p.first_step <= 1.0
        && p.shrink > 0.0
        && p.shrink < 1.0
        && p.growth >= 1.0;
    if !sane {
        return Err(LoadSteppingError::Params);
    }
    let mut info = LoadSteppingInfo {
        steps: 0,
        failures: 0,
    };
    let (mut load, mut step) = (0.0_f64, p.first_step);
    while load < 1.0 {
        // A remainder shorter than half a step is not worth a step of its own.
        let next = if load + 1.5 * step >= 1.0 && load + step < 1.0 && step > p.smallest_step {
            0.5 * (load + 1.0)
        } else {
            (load + step).min(1.0)
        };
        let last_good = state.clone();
        match solve(next, state) {
            Ok(()) => {
                load = next;
                info.steps += 1;
                step *= p.growth;
            }
            Err(source) => {
                *state = last_good;
                info.failures += 1;
                let tried = next - load;
                step = p.shrink * tried;
                if step < p.smallest_step {
                    return Err(LoadSteppingError::Stuck {
                        load,
                        step: tried,
                        source,
                    });
                }
            }
        }
    }
    Ok(info)
}
