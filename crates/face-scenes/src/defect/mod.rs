//! What can be wrong with an entry of a scene, as data; the messages say the cure.

mod contact;
mod courses;
mod flesh;
mod influences;
mod location;
mod material;
mod muscles;
mod table;
mod targets;

pub use contact::ContactDefect;
pub use courses::CourseDefect;
pub use flesh::FleshDefect;
pub use influences::{InfluenceDefect, PlaceDefect};
pub use location::Location;
pub use material::{FibersDefect, MaterialDefect};
pub use muscles::MuscleDefect;
pub use table::TableDefect;
pub use targets::{EmbeddingDefect, LandmarkDefect, TargetDefect};

use crate::builtin::BuiltinError;
use face_rig::anatomy::{FiberError, HingeError, JointError};
use fem_assembly::AssemblyError;
use fem_assembly::mesh::MeshError;

/// What is wrong with an entry of a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Defect {
    /// The form of a table.
    #[error(transparent)]
    Table(#[from] TableDefect),
    /// The flesh and its bones.
    #[error(transparent)]
    Flesh(#[from] FleshDefect),
    /// The muscles.
    #[error(transparent)]
    Muscle(#[from] MuscleDefect),
    /// What is drawn as lines.
    #[error(transparent)]
    Course(#[from] CourseDefect),
    /// A fiber of the field.
    #[error(transparent)]
    Fiber(#[from] FiberError),
    /// What all fibers share.
    #[error(transparent)]
    Fibers(#[from] FibersDefect),
    /// A material.
    #[error(transparent)]
    Material(#[from] MaterialDefect),
    /// A choice of nodes or faces.
    #[error(transparent)]
    Place(#[from] PlaceDefect),
    /// A load, a cavity, a motion, a strength or a stiffness.
    #[error(transparent)]
    Influence(#[from] InfluenceDefect),
    /// What flesh touches.
    #[error(transparent)]
    Contact(#[from] ContactDefect),
    /// A point of the embedding table.
    #[error(transparent)]
    Embedding(#[from] EmbeddingDefect),
    /// A target or its landmarks.
    #[error(transparent)]
    Target(#[from] TargetDefect),
    /// The jaw's hinge.
    #[error(transparent)]
    Hinge(#[from] HingeError),
    /// The jaw's joint.
    #[error(transparent)]
    Joint(#[from] JointError),
    /// The face that the program makes.
    #[error(transparent)]
    Builtin(#[from] BuiltinError),
    /// A mesh made in memory.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The flesh as an energy.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}
