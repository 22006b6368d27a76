//! The parameters of a damage model (document 001, alg. 1).

use crate::error::{MpmError, positive};
use fem_kinematics::{Mat, dot};
use fem_materials::Material;

/// Constants of the crack driving force and of its evolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamageParameters {
    /// Length scale l₀ of the smeared crack, m; half a cell by default.
    pub length_scale: f64,
    /// Slope ζ of the driving force past its threshold.
    pub zeta: f64,
    /// Critical stress σ_c, Pa.
    pub sigma_crit: f64,
    /// Crack viscosity η, s: the smaller, the faster a crack runs.
    pub eta: f64,
}

impl DamageParameters {
    /// l₀ = Δx/2 and ζ = 1, as document 001 sets them.
    pub fn new(cell_size: f64, sigma_crit: f64, eta: f64) -> Self {
        Self {
            length_scale: 0.5 * cell_size,
            zeta: 1.0,
            sigma_crit,
            eta,
        }
    }

    /// # Errors
    /// A parameter that is not finite and positive (l₀ may be 0: no diffusion).
    pub fn check(&self) -> Result<(), MpmError> {
        positive("zeta", self.zeta)?;
        positive("sigma_crit", self.sigma_crit)?;
        positive("eta", self.eta)?;
        if self.length_scale == 0.0 {
            return Ok(());
        }
        positive("length_scale", self.length_scale)
    }
}

/// The largest principal Cauchy stress (Pa) of a material stretched by `stretch` along a unit
/// direction: document 001's starting value for σ_c ("a stress corresponding to some uniform stretch").
///
/// The other directions keep their length. `direction` is in the law's fiber frame.
pub fn stress_at_stretch<M: Material<D>, const D: usize>(
    material: &M,
    direction: [f64; D],
    stretch: f64,
) -> f64 {
    let F = Mat::identity() + Mat::outer(direction, direction).scale(stretch - 1.0);
    let sigma = material.stress(&F).mul_tr(&F).scale(1.0 / F.determinant());
    // F is symmetric with `direction` as an eigenvector; along it the stress is the largest.
    dot(direction, sigma.mul_vec(direction))
}
