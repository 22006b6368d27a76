//! Neo-Hookean elasticity with ln J (document 002).

use crate::material::{Material, Symmetry};
use crate::near_rest::{RestMeasures, infinite_unless_positive};
use crate::registry::{Entry, Parameter, Register, lame_itself};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = μ/2 (tr FᵀF − D) − μ ln J + λ/2 (ln J)², finite only for J = det F > 0.
///
/// D is the dimension. The barrier ln J keeps elements from inverting.
// ERRATUM: document 002 subtracts 3 in 2D too; D makes the rest state have energy 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

const PARAMETERS: [Parameter; 2] = [
    Parameter::pascals("mu", "1e5", "shear modulus"),
    Parameter::pascals("lambda", "4e5", "first Lamé parameter"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    let entry = Entry {
        name: "neo_hookean",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "soft tissue, rubber; the logarithm keeps elements from inverting",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            Ok(NeoHookean {
                mu: p.non_negative("mu")?,
                lambda: p.number("lambda")?,
            })
        },
    };
    visitor.plane(&entry);
    visitor.solid(&entry);
}

impl<const D: usize> Material<D> for NeoHookean {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let (mu, half_lambda) = (T::from_f64(self.mu), T::from_f64(0.5 * self.lambda));
        let rest = RestMeasures::new(F);
        let log_J = rest.log_J();
        let psi = mu * (rest.E.trace() - log_J) + half_lambda * log_J * log_J;
        infinite_unless_positive(rest.J, psi)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let H = F.cofactor().scale(F.determinant().recip());
        let log_J = RestMeasures::new(F).log_J();
        F.scale(mu) + H.scale(lambda * log_J - mu)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let H = F.cofactor().scale(F.determinant().recip());
        let pressure = lambda * RestMeasures::new(F).log_J() - mu;
        // d(F⁻ᵀ) = −F⁻ᵀ dFᵀ F⁻ᵀ
        let dH = H * dF.tr_mul(&H);
        dF.scale(mu) + H.scale(lambda * H.dot(dF)) - dH.scale(pressure)
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let H = F.cofactor().scale(F.determinant().recip());
        let pressure = lambda * RestMeasures::new(F).log_J() - mu;
        Terms::new()
            .identity(mu)
            .outer(lambda, &H, &H)
            .transposed(-pressure, &H, &H)
            .0
    }
}
