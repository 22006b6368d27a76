//! Mooney-Rivlin elasticity by invariants, as in Vega FEM (document 004).

use crate::isotropic::{ByInvariants, Domain, InvariantEnergy};
use crate::near_rest::inverse_cube_root;
use crate::registry::{Entry, Parameter, Register};
use fem_kinematics::Real;

/// ψ = μ₀₁/2 ((I² − II) III^(−2/3) − 6) + μ₁₀ (I III^(−1/3) − 3) + v₁ (√III − 1)².
///
/// With μ₁₀ = A and μ₀₁ = B the isochoric part of document 000 less its energy at rest. Finite
/// only for det F > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvMooneyRivlin {
    /// μ₀₁, Pa.
    pub mu01: f64,
    /// μ₁₀, Pa.
    pub mu10: f64,
    /// v₁, Pa: half the bulk modulus.
    pub v1: f64,
}

const PARAMETERS: [Parameter; 3] = [
    Parameter::pascals("mu01", "2e4", "coefficient of the second invariant"),
    Parameter::pascals("mu10", "6e4", "coefficient of the first invariant"),
    Parameter::pascals("v1", "3e4", "half the bulk modulus"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "inv_mooney_rivlin",
        aliases: &[],
        elastic: None,
        about: "Mooney-Rivlin with a polynomial volume term, by the invariants of document 004",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            let (mu01, mu10) = (p.number("mu01")?, p.number("mu10")?);
            Ok(ByInvariants(InvMooneyRivlin {
                mu01,
                mu10,
                v1: p.non_negative("v1")?,
            }))
        },
    });
}

impl InvariantEnergy for InvMooneyRivlin {
    const DOMAIN: Domain = Domain::PositiveDeterminant;

    #[inline(always)]
    fn energy<T: Real>(&self, [I, II, III]: [T; 3]) -> T {
        let f = T::from_f64;
        let s = inverse_cube_root(III);
        let j = III.sqrt() - T::one();
        f(0.5 * self.mu01) * ((I * I - II) * s * s - f(6.0))
            + f(self.mu10) * (I * s - f(3.0))
            + f(self.v1) * j * j
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, [I, II, III]: [T; 3]) -> [T; 3] {
        let f = T::from_f64;
        let s = inverse_cube_root(III);
        let (a, b) = (f(self.mu10) * s, f(self.mu01) * s * s);
        let third = f(-1.0 / 3.0) * (b * (I * I - II) + a * I) / III;
        let volume = f(self.v1) * (T::one() - III.sqrt().recip());
        [b * I + a, f(-0.5) * b, third + volume]
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, [I, II, III]: [T; 3]) -> [T; 6] {
        let f = T::from_f64;
        let s = inverse_cube_root(III);
        let (a, b) = (f(self.mu10) * s, f(self.mu01) * s * s);
        let r = III.recip();
        let h33 = (f(5.0 / 9.0) * b * (I * I - II) + f(4.0 / 9.0) * a * I) * r * r
            + f(0.5 * self.v1) * r * III.sqrt().recip();
        [
            b,
            T::zero(),
            -(f(2.0 / 3.0) * b * I + f(1.0 / 3.0) * a) * r,
            T::zero(),
            f(1.0 / 3.0) * b * r,
            h33,
        ]
    }
}
