//! Newton-Raphson on an energy (document 000, section 5.1).

mod descent;
mod direction;
mod line_search;
mod params;
mod problem;
mod shift;
mod solve;

pub use descent::{Descent, DescentDirection, DescentOutcome, PcgDirection};
pub use fem_kinematics::HessianProjection;
pub use params::{
    LineSearchParams, LinearSolver, NewtonError, NewtonFailure, NewtonInfo, NewtonIteration,
    NewtonParams, PreconditionerChoice, ProjectionPolicy, StopReason,
};
pub use problem::{Merit, NonlinearProblem};
pub use solve::Newton;
