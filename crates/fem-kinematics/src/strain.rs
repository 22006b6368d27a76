//! Strain measures, each accurate near rest through G = F − I.

use crate::mat::Mat;
use crate::polar::Polar;
use crate::scalar::Real;

/// e = (F + Fᵀ)/2 − I.
#[inline(always)]
pub fn infinitesimal_strain<T: Real, const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
    (*F - Mat::identity()).symmetric_part()
}

/// Green's strain E = (FᵀF − I)/2 = (G + Gᵀ + GᵀG)/2 with G = F − I.
#[inline(always)]
pub fn green_strain<T: Real, const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
    let G = *F - Mat::identity();
    let half = T::from_f64(0.5);
    Mat::from_fn(|i, j| {
        let column = crate::mat::dot(G.column(i), G.column(j));
        half * (G.0[i][j] + G.0[j][i]) + half * column
    })
}

/// dE = (dFᵀF + FᵀdF)/2.
#[inline(always)]
pub fn green_strain_differential<T: Real, const D: usize>(
    F: &Mat<T, D>,
    dF: &Mat<T, D>,
) -> Mat<T, D> {
    F.tr_mul(dF).symmetric_part()
}

/// The corotated strain S − I of F = R S, given the polar decomposition of F.
///
/// With all stretches positive it is (S + I)⁻¹ 2E, E Green's strain, which keeps its digits near
/// rest; for inverted F, where S + I may be singular, it is S − I itself.
#[inline(always)]
pub fn corotated_strain<T: Real, const D: usize>(F: &Mat<T, D>, polar: &Polar<T, D>) -> Mat<T, D> {
    let plain = polar.S - Mat::identity();
    let upright = T::zero().lt(polar.principal().sigma[D - 1]);
    let sum = polar.S + Mat::identity();
    let twice = green_strain(F).scale(T::from_f64(2.0));
    let small = (sum.inverse() * twice).symmetric_part();
    Mat::from_fn(|i, j| T::select(upright, small.0[i][j], plain.0[i][j]))
}
