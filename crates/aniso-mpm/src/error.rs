//! What can go wrong, where, and what to do about it.

use fem_solvers::{NewtonError, PcgError};
use thiserror::Error;

/// Why a simulation or an augmentation gave no result. The last good state is kept.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MpmError {
    /// A particle that no grid block can hold.
    #[error(
        "particle {particle} at {position:?} is not finite or more than 2^20 blocks from the origin; remove it or add walls"
    )]
    ParticleOffGrid {
        /// Its index.
        particle: usize,
        /// Where it is, m.
        position: Vec<f64>,
    },
    /// A number in the input that makes no sense.
    #[error("{what} is {value}: it must be {need}")]
    Parameter {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What was expected.
        need: &'static str,
    },
    /// A number of a particle that makes no sense.
    #[error("{field} of particle {particle} is {value}: it must be {need}")]
    Particle {
        /// Its index.
        particle: usize,
        /// The field of `Particles`.
        field: &'static str,
        /// The value found.
        value: f64,
        /// What was expected.
        need: &'static str,
    },
    /// Two inputs that must have the same length.
    #[error("{what} has {found} entries where {expected} belong")]
    Length {
        /// Which input.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The number of particles (or of unknowns).
        expected: usize,
    },
    /// A step was halved until nothing was left.
    #[error(
        "at time {time} s particle {particle} {reason} even with a step of {dt:e} s; use a finer grid, a softer material or a smaller velocity"
    )]
    StepRejected {
        /// Simulated time before the step, s.
        time: f64,
        /// The smallest step tried, s.
        dt: f64,
        /// The first particle that was wrong.
        particle: usize,
        /// What was wrong with it.
        reason: Rejection,
    },
    /// A frame would take more substeps than allowed.
    #[error(
        "at time {time} s a stable step is {dt:e} s: the frame needs more than {limit} substeps; raise `max_substeps` or soften the material"
    )]
    TooManySubsteps {
        /// Simulated time, s.
        time: f64,
        /// Stable step, s.
        dt: f64,
        /// The limit.
        limit: usize,
    },
    /// A linear solve failed.
    #[error("{system}: {source}")]
    Solve {
        /// Which system.
        system: &'static str,
        /// What the solver said.
        source: SolveError,
    },
    /// Newton's method ended before its tolerance.
    #[error(
        "{system} {reason} after {iterations} Newton steps: the last one changed an unknown by {change:e}, at most {tolerance:e} was asked for"
    )]
    Newton {
        /// Which system.
        system: &'static str,
        /// Why it ended.
        reason: NewtonEnd,
        /// Steps taken.
        iterations: usize,
        /// Largest change of an unknown in the last step taken, in its unit; ∞ if none was.
        change: f64,
        /// Largest change at which it would have ended well.
        tolerance: f64,
        /// The unknowns after the last step taken.
        last: Vec<f64>,
    },
}

/// Why a particle's next state was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Rejection {
    /// A position, a velocity or a deformation gradient is not finite.
    #[error("gets a state that is not finite")]
    NotFinite,
    /// The deformation changes by more than a step may.
    #[error("deforms too fast")]
    TooFast,
    /// d is outside [0, 1], or what drives it is not finite.
    #[error("gets damage outside [0, 1] or a driving force that is not finite")]
    Damage,
}

/// Why Newton's method ended before its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NewtonEnd {
    /// All its steps are taken.
    #[error("has not converged")]
    NotConverged,
    /// No step along its direction lowers the energy.
    #[error("finds no lower energy along its direction")]
    NoDecrease,
}

/// What a solver said.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SolveError {
    /// Newton's method failed other than by not converging.
    #[error(transparent)]
    Newton(Box<NewtonError>),
    /// Conjugate gradients failed.
    #[error(transparent)]
    Pcg(#[from] PcgError),
    /// No point meets the constraints.
    #[error("no point meets the constraints: {0}")]
    Contradiction(#[source] PcgError),
    /// Some row is not solved, however often the solution is refined.
    #[error("the largest residual over its diagonal is {residual:e}, {tolerance:e} was asked for")]
    Residual {
        /// Largest residual over diagonal.
        residual: f64,
        /// What was asked for.
        tolerance: f64,
    },
    /// Fibers are still stretched.
    #[error(
        "a stretch rate of {violation:e} of the initial one is left after {iterations} iterations"
    )]
    StretchLeft {
        /// What is left of the largest stretch rate.
        violation: f64,
        /// Iterations taken.
        iterations: usize,
    },
}

impl From<NewtonError> for SolveError {
    fn from(error: NewtonError) -> Self {
        Self::Newton(Box::new(error))
    }
}

/// `Err` unless the value is finite and positive; NaN fails.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), MpmError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(MpmError::Parameter {
            what,
            value,
            need: "finite and positive",
        })
    }
}

/// `Err` unless the lengths agree.
pub(crate) fn same_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), MpmError> {
    if found == expected {
        Ok(())
    } else {
        Err(MpmError::Length {
            what,
            found,
            expected,
        })
    }
}
