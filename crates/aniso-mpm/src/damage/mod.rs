//! Anisotropic damage as an augmentation of any MPM (doc 001, sections 1.2, 1.3 and 2).

mod directors;
mod driving_force;
mod parameters;

pub use directors::{Director, Directors};
pub use driving_force::{cauchy_stress, crack_stress, driving_force, tensile_part};
pub use parameters::{DamageParameters, stress_at_stretch};

/// Parameters and directors of a material that can tear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageModel<const D: usize> {
    /// Constants.
    pub parameters: DamageParameters,
    /// Directors, in the fibre frame.
    pub directors: Directors<D>,
}
