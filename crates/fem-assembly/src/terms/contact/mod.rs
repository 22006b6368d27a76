//! Surfaces of flesh that touch each other, or bones.

mod carrier;
mod cones;
mod distance;
mod flesh;
mod frame;
mod geometry;
mod lids;
mod measures;
mod pair;
mod params;
mod points;
mod rigid;
mod search;
mod solid;
mod surface;
mod tree;
mod way;

pub use distance::{Jet, SampledDistance};
pub use flesh::FleshContact;
pub use frame::RigidFrame;
pub use params::FleshContactParams;
pub use points::ContactPoint;
pub use rigid::{RigidContact, RigidContactParams, RigidSurface};
