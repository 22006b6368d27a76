//! Conversions between stress measures (document 000, section 4.4, equations 16-17).
//!
//! P is the first Piola-Kirchhoff stress (force over rest area), S₂ the second, σ Cauchy's (force
//! over deformed area) and τ = Jσ Kirchhoff's; all in pascals.

use crate::mat::Mat;
use crate::scalar::Real;

/// σ = P Fᵀ/J; not finite where J = 0.
#[inline(always)]
pub fn cauchy_from_piola<T: Real, const D: usize>(F: &Mat<T, D>, P: &Mat<T, D>) -> Mat<T, D> {
    P.mul_tr(F).scale(F.determinant().recip())
}

/// P = J σ F⁻ᵀ = σ cof F, for every F.
#[inline(always)]
pub fn piola_from_cauchy<T: Real, const D: usize>(F: &Mat<T, D>, sigma: &Mat<T, D>) -> Mat<T, D> {
    *sigma * F.cofactor()
}

/// S₂ = F⁻¹ P; not finite where J = 0.
#[inline(always)]
pub fn second_piola_from_piola<T: Real, const D: usize>(F: &Mat<T, D>, P: &Mat<T, D>) -> Mat<T, D> {
    F.inverse() * *P
}

/// P = F S₂.
#[inline(always)]
pub fn piola_from_second_piola<T: Real, const D: usize>(
    F: &Mat<T, D>,
    second: &Mat<T, D>,
) -> Mat<T, D> {
    *F * *second
}

/// τ = P Fᵀ.
#[inline(always)]
pub fn kirchhoff_from_piola<T: Real, const D: usize>(F: &Mat<T, D>, P: &Mat<T, D>) -> Mat<T, D> {
    P.mul_tr(F)
}

/// P = τ F⁻ᵀ; not finite where J = 0.
#[inline(always)]
pub fn piola_from_kirchhoff<T: Real, const D: usize>(F: &Mat<T, D>, tau: &Mat<T, D>) -> Mat<T, D> {
    tau.mul_tr(&F.inverse())
}
