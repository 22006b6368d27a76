//! What a face consists of: muscles with fibers, bones, the jaw's joint, and points that ride on
//! the flesh.

mod affine_map;
mod bones;
mod bundles;
mod course;
mod fibers;
mod hinge;
mod joint;
mod locate;

pub use affine_map::AffineMap;
pub use bones::{Bone, Bones};
pub use bundles::{Piece, bundles};
pub use course::{Course, CourseError, Filling, Section, Share, resampled, smoothed, wrapped};
pub use fem_assembly::mesh::EmbeddedPoint;
pub use fibers::{FiberEntry, FiberError, FiberField, Muscle, Side};
pub use hinge::{HingeError, JawHinge};
pub use joint::{CondylarPath, JOINT_NAMES, JOINT_NUMBERS, JawJoint, JointError, JointLimits};
pub use locate::{Located, TetLocator};
