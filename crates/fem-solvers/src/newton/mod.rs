//! Newton-Raphson on an energy (doc 000, section 5.1).

mod direction;
mod line_search;
mod params;
mod problem;
mod shift;
mod solve;

pub use params::{
    DefinitenessPolicy, LineSearchParams, LinearSolver, NewtonError, NewtonFailure, NewtonInfo,
    NewtonIteration, NewtonParams, PreconditionerChoice, StopReason,
};
pub use problem::{Definiteness, Merit, NonlinearProblem};
pub use solve::Newton;
