//! Gent's rubber elasticity (1996): chains that cannot be stretched for ever.

use crate::isotropic::{FirstInvariant, FirstInvariantEnergy, Volume};
use crate::lame::Space;
use crate::registry::{Entry, Parameter, Register};
use fem_kinematics::Real;

/// W = −μ J_m/2 ln(1 − i/J_m) with i = J^(−2/3) tr C − 3; +∞ for i ≥ J_m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gent {
    /// Shear modulus at rest μ, Pa.
    pub mu: f64,
    /// J_m > 0, the limit of i; without unit.
    pub limit: f64,
}

const PARAMETERS: [Parameter; 3] = [
    Parameter::pascals("mu", "4e5", "shear modulus at rest"),
    Parameter::plain("Jm", "30", "limit of J^(-2/3) tr C - 3"),
    Parameter::pascals("K", "2e6", "bulk modulus"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "gent",
        aliases: &[],
        elastic: Some(|lame| vec![("mu", lame.mu), ("K", lame.bulk(Space::Solid))]),
        about: "rubber and vessels with a stretch that they cannot exceed",
        domain: "J > 0, i = J^(−2/3) tr C − 3 < Jm",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            let shape = Gent {
                mu: p.non_negative("mu")?,
                limit: p.positive("Jm")?,
            };
            Ok(FirstInvariant {
                shape,
                volume: Volume {
                    K: p.non_negative("K")?,
                },
            })
        },
    });
}

impl FirstInvariantEnergy for Gent {
    #[inline(always)]
    fn energy_and_slopes<T: Real>(&self, i: T) -> [T; 3] {
        let (half_mu, limit) = (T::from_f64(0.5 * self.mu), T::from_f64(self.limit));
        let left = (limit - i).recip();
        let energy = -half_mu * limit * (-i / limit).ln_1p();
        let slope = half_mu * limit * left;
        [
            T::select(i.lt(limit), energy, T::from_f64(f64::INFINITY)),
            slope,
            slope * left,
        ]
    }
}
