//! Newton-Raphson on an energy (document 000, section 5.1).

mod direction;
mod factorizer;
mod forcing;
mod line_minimum;
mod line_search;
mod padded;
mod params;
mod problem;
mod repair;
mod shift;
mod solve;
mod tangent;
mod target;
mod watch;

pub use direction::{
    Descent, DescentDirection, DescentOutcome, MultigridDirection, NewtonSystem, PcgDirection,
};
pub(crate) use direction::{FLOPS_PER_BYTE, bytes_of_an_iteration};
pub use fem_kinematics::HessianProjection;
pub use params::{
    LineSearchParams, LinearSolver, NewtonError, NewtonFailure, NewtonInfo, NewtonIteration,
    NewtonParams, PreconditionerChoice, ProjectionPolicy, StopReason,
};
pub use problem::{Merit, NonlinearProblem};
pub use solve::Newton;
pub use tangent::Tangent;
pub use watch::Watch;
