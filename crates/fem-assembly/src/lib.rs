//! Meshes, finite-volume nodal forces, sparse Hessians, constraints and penalties: everything
//! between a constitutive model and the equation f(x) = 0.
#![allow(non_snake_case)]

mod assembly;
mod block;
mod builder;
mod dofs;
mod error;
mod fibers;
mod law;
pub mod mesh;
mod part;
mod penalty;
mod quasistatic;

pub use assembly::Assembly;
pub use builder::AssemblyBuilder;
pub use dofs::Dofs;
pub use error::AssemblyError;
pub use fibers::Fiber;
pub use penalty::{Obstacle, Penalty};
pub use quasistatic::Quasistatic;
