//! Anisotropic damage as an augmentation of any MPM (document 001, sections 1.2, 1.3 and 2).
//!
//! Nothing here knows the host: every function takes plain slices of positions, deformation
//! gradients, stresses and damage. [`Augmentation`] strings them together in the order of the
//! pseudocode.

mod augmentation;
mod directors;
mod driving_force;
mod explicit;
mod grid;
mod implicit;
mod parameters;

pub use augmentation::{Augmentation, DamageInput, DamageOutput, DamageUpdate, ModelOf};
pub use directors::{Director, Directors};
pub(crate) use driving_force::cauchy_from_kirchhoff;
pub use driving_force::{cauchy_stress, crack_stress, driving_force, tensile_part};
pub use explicit::{explicit_update, geometric_resistance};
pub use grid::DamageGrid;
pub use implicit::{Gradient, ImplicitOptions, ImplicitSystem, RightHandSide};
pub use parameters::{DamageParameters, stress_at_stretch};

/// Parameters and directors of a material that can tear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageModel<const D: usize> {
    /// Constants.
    pub parameters: DamageParameters,
    /// Directors, in the frame that F maps from.
    pub directors: Directors<D>,
}
