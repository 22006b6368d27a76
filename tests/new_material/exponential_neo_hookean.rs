//! Neo-Hookean elasticity that stiffens exponentially, after Demiray (1972).

use crate::isotropic::{ByInvariants, Domain, InvariantEnergy};
use crate::registry::{Entry, Parameter, Register};
use fem_kinematics::Real;

/// ψ = μ/(2b) (exp(b (I − 3)) − 1) − μ/2 ln III + λ/8 (ln III)². Finite only for det F > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialNeoHookean {
    /// Shear modulus at rest μ, Pa.
    pub mu: f64,
    /// First Lamé parameter at rest λ, Pa.
    pub lambda: f64,
    /// Rate of stiffening b.
    pub b: f64,
}

const PARAMETERS: [Parameter; 3] = [
    Parameter::pascals("mu", "1e4", "shear modulus at rest"),
    Parameter::pascals("lambda", "1e5", "first Lamé parameter at rest"),
    Parameter::plain("b", "1", "rate of stiffening"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "exponential_neo_hookean",
        aliases: &[],
        elastic: None,
        about: "neo-Hookean elasticity that stiffens exponentially",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            let (mu, lambda) = (p.non_negative("mu")?, p.number("lambda")?);
            let b = p.positive("b")?;
            Ok(ByInvariants(ExponentialNeoHookean { mu, lambda, b }))
        },
    });
}

impl InvariantEnergy for ExponentialNeoHookean {
    const DOMAIN: Domain = Domain::PositiveDeterminant;

    fn energy<T: Real>(&self, [I, _, III]: [T; 3]) -> T {
        let (half_mu, b) = (T::from_f64(0.5 * self.mu), T::from_f64(self.b));
        let growth = (b * (I - T::from_f64(3.0))).exp() - T::one();
        let log = III.ln();
        half_mu * (growth / b - log) + T::from_f64(self.lambda / 8.0) * log * log
    }
    fn gradient<T: Real>(&self, [I, _, III]: [T; 3]) -> [T; 3] {
        let (half_mu, b) = (T::from_f64(0.5 * self.mu), T::from_f64(self.b));
        let growth = (b * (I - T::from_f64(3.0))).exp();
        let by_log = T::from_f64(0.25 * self.lambda) * III.ln() - half_mu;
        [half_mu * growth, T::zero(), by_log / III]
    }
    fn hessian<T: Real>(&self, [I, _, III]: [T; 3]) -> [T; 6] {
        let (half_mu, b) = (T::from_f64(0.5 * self.mu), T::from_f64(self.b));
        let growth = (b * (I - T::from_f64(3.0))).exp();
        let quarter = T::from_f64(0.25 * self.lambda);
        let (zero, by_log) = (T::zero(), quarter * III.ln() - half_mu);
        [half_mu * b * growth, zero, zero, zero, zero, (quarter - by_log) / (III * III)]
    }
}
