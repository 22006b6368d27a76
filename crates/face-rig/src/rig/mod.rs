//! The rig: θ ↦ x(θ), its exact derivative, and fitting θ to what is seen.

mod control;
mod equilibrium;
mod error;
mod jacobian;
mod loads;
mod observation;
mod parameters;
mod work;

pub use crate::anatomy::AffineMap;
pub use control::{Control, Effect};
pub use equilibrium::{Equilibrium, MultigridUse, Rig, RigParams};
pub use error::{PartError, RigError};
pub use jacobian::{JacobianRoute, Sensitivity};
pub use observation::{AllNodes, EmbeddedPoints, Observation};
pub use parameters::{Direction, Parameters};
pub use work::Work;
