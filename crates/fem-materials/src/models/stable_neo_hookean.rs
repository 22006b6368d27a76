//! Stable neo-Hookean elasticity (Smith, de Goes and Kim 2018), both forms.

use crate::lame::Lame;
use crate::material::{Material, Symmetry};
use crate::near_rest::RestMeasures;
use crate::registry::{Entry, Parameter, Register, mu_and_lambda_plus_mu};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

const PARAMETERS: [Parameter; 2] = [
    Parameter::pascals("mu", "1e5", "μ of the model: 4/3 of Lamé's"),
    Parameter::pascals(
        "lambda",
        "5e5",
        "λ of the model: Lamé's plus 5/6 of Lamé's μ",
    ),
];

const NO_LOG: [Parameter; 2] = [
    Parameter::pascals("mu", "1e5", "shear modulus"),
    Parameter::pascals("lambda", "5e5", "λ of the model: Lamé's plus μ"),
];

/// ψ = μ/2 (tr FᵀF − 3) + λ/2 (J − a)² − μ/2 ln(tr FᵀF + 1), a = 1 + μ/λ − μ/(4λ).
///
/// Defined for every F, flat and inverted too. Not 0 at rest. The model's μ and λ are not
/// Lamé's: see [`StableNeoHookean::from_lame`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableNeoHookean {
    /// μ of the model, Pa.
    pub mu: f64,
    /// λ of the model, Pa.
    pub lambda: f64,
}

impl StableNeoHookean {
    /// The model that behaves like linear elasticity at small strains: μ = 4/3 μ_L,
    /// λ = λ_L + 5/6 μ_L.
    pub fn from_lame(lame: Lame) -> Self {
        Self {
            mu: 4.0 / 3.0 * lame.mu,
            lambda: lame.lambda + 5.0 / 6.0 * lame.mu,
        }
    }
}

/// ψ = μ/2 (tr FᵀF − D) − μ (J − 1) + λ/2 (J − 1)².
///
/// The same without the logarithm: cheaper, 0 at rest, and its energy keeps its digits near
/// rest; but shear loses its stiffness when an element collapses to a point. Defined for every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableNeoHookeanNoLog {
    /// μ of the model, Pa; equal to Lamé's.
    pub mu: f64,
    /// λ of the model, Pa; Lamé's plus μ.
    pub lambda: f64,
}

impl StableNeoHookeanNoLog {
    /// The model that behaves like linear elasticity at small strains: μ = μ_L, λ = λ_L + μ_L.
    pub fn from_lame(lame: Lame) -> Self {
        Self {
            mu: lame.mu,
            lambda: lame.lambda + lame.mu,
        }
    }
}

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "stable_neo_hookean",
        aliases: &["snh"],
        elastic: Some(|lame| {
            let model = StableNeoHookean::from_lame(lame);
            vec![("mu", model.mu), ("lambda", model.lambda)]
        }),
        about: "soft tissue, rubber; elements may collapse and invert on the way",
        domain: "all F",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            Ok(StableNeoHookean {
                mu: p.non_negative("mu")?,
                lambda: p.positive("lambda")?,
            })
        },
    });
    let entry = Entry {
        name: "stable_neo_hookean_nolog",
        aliases: &["snh_nolog"],
        elastic: Some(mu_and_lambda_plus_mu),
        about: "soft tissue, rubber; elements may invert on the way; without logarithm, cheapest and smooth everywhere",
        domain: "all F",
        parameters: &NO_LOG,
        from_parameters: |p| {
            Ok(StableNeoHookeanNoLog {
                mu: p.non_negative("mu")?,
                lambda: p.number("lambda")?,
            })
        },
    };
    visitor.plane(&entry);
    visitor.solid(&entry);
}

impl Material<3> for StableNeoHookean {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let (half_mu, half_lambda) = (T::from_f64(0.5 * self.mu), T::from_f64(0.5 * self.lambda));
        let rest = RestMeasures::new(F);
        let g = T::from_f64(2.0) * rest.E.trace();
        let volume = rest.J_minus_1 - T::from_f64(0.75 * self.mu / self.lambda);
        half_mu * (g - (F.norm_squared() + T::one()).ln()) + half_lambda * volume * volume
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let n = F.norm_squared();
        let volume = RestMeasures::new(F).J_minus_1 - T::from_f64(0.75 * self.mu / self.lambda);
        // 1 − 1/(n + 1) = n/(n + 1)
        F.scale(mu * n / (n + T::one())) + F.cofactor().scale(lambda * volume)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let n = F.norm_squared();
        let r = (n + T::one()).recip();
        let cof = F.cofactor();
        let volume = RestMeasures::new(F).J_minus_1 - T::from_f64(0.75 * self.mu / self.lambda);
        dF.scale(mu * n * r)
            + F.scale(T::from_f64(2.0) * mu * r * r * F.dot(dF))
            + cof.scale(lambda * cof.dot(dF))
            + F.cofactor_differential(dF).scale(lambda * volume)
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let n = F.norm_squared();
        let r = (n + T::one()).recip();
        let cof = F.cofactor();
        let volume = RestMeasures::new(F).J_minus_1 - T::from_f64(0.75 * self.mu / self.lambda);
        Terms::new()
            .identity(mu * n * r)
            .outer(T::from_f64(2.0) * mu * r * r, F, F)
            .outer(lambda, &cof, &cof)
            .cofactor(lambda * volume, F)
            .0
    }
}

impl<const D: usize> Material<D> for StableNeoHookeanNoLog {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let (mu, half_lambda) = (T::from_f64(self.mu), T::from_f64(0.5 * self.lambda));
        let rest = RestMeasures::new(F);
        let j = rest.J_minus_1;
        mu * (rest.E.trace() - j) + half_lambda * j * j
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let j = RestMeasures::new(F).J_minus_1;
        F.scale(mu) + F.cofactor().scale(lambda * j - mu)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let cof = F.cofactor();
        let j = RestMeasures::new(F).J_minus_1;
        dF.scale(mu)
            + cof.scale(lambda * cof.dot(dF))
            + F.cofactor_differential(dF).scale(lambda * j - mu)
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let cof = F.cofactor();
        let j = RestMeasures::new(F).J_minus_1;
        Terms::new()
            .identity(mu)
            .outer(lambda, &cof, &cof)
            .cofactor(lambda * j - mu, F)
            .0
    }
}
