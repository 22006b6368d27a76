//! Neo-Hookean elasticity with ln J (document 002).

use crate::material::Material;
use fem_kinematics::{Mat, Real};

/// ψ = μ/2 (tr FᵀF − D) − μ ln J + λ/2 (ln J)², finite only for J = det F > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

/// ln det F: by ln(1 + j) with j = det F − 1 near rest, where ln(det F) would lose digits.
#[inline(always)]
fn log_determinant<T: Real, const D: usize>(F: &Mat<T, D>) -> T {
    let j = (*F - Mat::identity()).determinant_of_identity_plus_minus_one();
    let near = j.abs().lt(T::from_f64(0.5));
    T::select(
        near,
        T::select(near, j, T::zero()).ln_1p(),
        F.determinant().ln(),
    )
}

impl<const D: usize> Material<D> for NeoHookean {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let (mu, lambda, half) = (
            T::from_f64(self.mu),
            T::from_f64(self.lambda),
            T::from_f64(0.5),
        );
        let G = *F - Mat::identity();
        let log_j = log_determinant(F);
        // tr FᵀF − D = |G|² + 2 tr G
        let psi =
            mu * (half * G.norm_squared() + (G.trace() - log_j)) + half * lambda * log_j * log_j;
        T::select(
            T::zero().lt(F.determinant()),
            psi,
            T::from_f64(f64::INFINITY),
        )
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let inverse_transpose = F.cofactor().scale(F.determinant().recip());
        F.scale(mu) + inverse_transpose.scale(lambda * log_determinant(F) - mu)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let h = F.cofactor().scale(F.determinant().recip());
        let pressure = lambda * log_determinant(F) - mu;
        // d(F⁻ᵀ) = −F⁻ᵀ dFᵀ F⁻ᵀ
        let dh = h * dF.tr_mul(&h);
        dF.scale(mu) + h.scale(lambda * h.dot(dF)) - dh.scale(pressure)
    }
}
