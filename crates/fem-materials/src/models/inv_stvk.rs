//! St. Venant-Kirchhoff elasticity by invariants, as in Vega FEM (document 004).

use super::linear::LAME;
use crate::isotropic::{ByInvariants, Domain, InvariantEnergy};
use crate::registry::{Entry, Register, lame_itself};
use fem_kinematics::Real;

/// ψ = λ/8 (I − 3)² + μ/4 (II − 2I + 3), the energy of
/// [`StVenantKirchhoff`](super::StVenantKirchhoff) in the form of document 004.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvStVenantKirchhoff {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "inv_stvk",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "St. Venant-Kirchhoff elasticity by the invariants of document 004",
        domain: "all F",
        parameters: &LAME,
        from_parameters: |p| {
            let (mu, lambda) = (p.non_negative("mu")?, p.number("lambda")?);
            Ok(ByInvariants(InvStVenantKirchhoff { mu, lambda }))
        },
    });
}

impl InvariantEnergy for InvStVenantKirchhoff {
    const DOMAIN: Domain = Domain::Everywhere;

    #[inline(always)]
    fn energy<T: Real>(&self, [I, II, _]: [T; 3]) -> T {
        let three = T::from_f64(3.0);
        let i = I - three;
        T::from_f64(self.lambda / 8.0) * i * i + T::from_f64(self.mu / 4.0) * (II - (I + I) + three)
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, [I, _, _]: [T; 3]) -> [T; 3] {
        let i = I - T::from_f64(3.0);
        [
            T::from_f64(self.lambda / 4.0) * i - T::from_f64(0.5 * self.mu),
            T::from_f64(self.mu / 4.0),
            T::zero(),
        ]
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, _: [T; 3]) -> [T; 6] {
        let zero = T::zero();
        [T::from_f64(self.lambda / 4.0), zero, zero, zero, zero, zero]
    }
}
