//! Neo-Hookean elasticity by invariants, as in Vega FEM (document 004).

use super::linear::LAME;
use crate::isotropic::{ByInvariants, Domain, InvariantEnergy};
use crate::registry::{Entry, Register, lame_itself};
use fem_kinematics::Real;

/// ψ = μ/2 (I − 3) − μ ln √III + λ/2 (ln √III)², the energy of [`NeoHookean`](super::NeoHookean)
/// in the form of document 004. Finite only for det F > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvNeoHookean {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "inv_neo_hookean",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "neo-Hookean elasticity by the invariants of document 004",
        domain: "J > 0",
        parameters: &LAME,
        from_parameters: |p| {
            Ok(ByInvariants(InvNeoHookean {
                mu: p.non_negative("mu")?,
                lambda: p.number("lambda")?,
            }))
        },
    });
}

impl InvariantEnergy for InvNeoHookean {
    const DOMAIN: Domain = Domain::PositiveDeterminant;

    #[inline(always)]
    fn energy<T: Real>(&self, [I, _, III]: [T; 3]) -> T {
        let half = T::from_f64(0.5);
        let log_J = half * III.ln();
        T::from_f64(self.mu) * (half * (I - T::from_f64(3.0)) - log_J)
            + T::from_f64(0.5 * self.lambda) * log_J * log_J
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, [_, _, III]: [T; 3]) -> [T; 3] {
        let half = T::from_f64(0.5);
        let pressure = T::from_f64(self.lambda) * half * III.ln() - T::from_f64(self.mu);
        [T::from_f64(0.5 * self.mu), T::zero(), half * pressure / III]
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, [_, _, III]: [T; 3]) -> [T; 6] {
        let (zero, half) = (T::zero(), T::from_f64(0.5));
        let pressure = T::from_f64(self.lambda) * half * III.ln() - T::from_f64(self.mu);
        let h33 = (T::from_f64(0.25 * self.lambda) - half * pressure) / (III * III);
        [zero, zero, zero, zero, zero, h33]
    }
}
