//! The kinds of energy, one to a file; none computes with another's numbers. Loads on surfaces are made
//! into [`NodalLoads`], and [`Scaled`] multiplies any term, of which it knows the trait alone.

mod cavity;
mod contact;
mod elastic;
mod fibers;
mod gravity;
mod mean_volume;
mod nodal_loads;
mod obstacle;
mod scaled;
mod springs;
mod surface_loads;

pub use cavity::Cavity;
pub use contact::{
    ContactPoint, FleshContact, FleshContactParams, Jet, RigidContact, RigidContactParams,
    RigidFrame, RigidSurface, SampledDistance,
};
pub use fibers::Fiber;
pub use gravity::Gravity;
pub use nodal_loads::NodalLoads;
pub use obstacle::Penalty;
pub use scaled::Scaled;
pub use springs::{Spring, Springs};
