//! What a face consists of: muscles with fibres, bones, the jaw's hinge, and points that ride on
//! the flesh.

mod bones;
mod embed;
mod fibres;
mod frame;
mod hinge;
mod locate;

pub use bones::{Bone, Bones};
pub use embed::EmbeddedPoint;
pub use fibres::{FibreEntry, FibreError, FibreField, Muscle, Side};
pub use frame::Frame;
pub use hinge::{HingeError, JawHinge};
pub use locate::{Located, TetLocator};
