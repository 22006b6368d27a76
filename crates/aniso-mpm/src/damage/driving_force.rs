//! The crack driving force (document 001, alg. 5 lines 5-11, alg. 8).

use super::directors::Directors;
use super::parameters::DamageParameters;
use fem_kinematics::{Mat, Real, symmetric_eigen};

/// Cauchy stress σ = P Fᵀ/J from a first Piola-Kirchhoff stress; 0 where J = 0.
#[inline(always)]
pub fn cauchy_stress<T: Real, const D: usize>(P: &Mat<T, D>, F: &Mat<T, D>) -> Mat<T, D> {
    cauchy_from_kirchhoff(&P.mul_tr(F), F.determinant())
}

/// Cauchy stress σ = τ/J from a Kirchhoff stress τ = P Fᵀ; 0 where J = 0.
#[inline(always)]
pub(crate) fn cauchy_from_kirchhoff<T: Real, const D: usize>(tau: &Mat<T, D>, J: T) -> Mat<T, D> {
    let flat = J.abs().le(T::zero());
    let per_volume = T::select(flat, T::zero(), T::select(flat, T::one(), J).recip());
    tau.symmetric_part().scale(per_volume)
}

/// max(a, b), and a where a is NaN: a stress that is not a number must not pass for none.
#[inline(always)]
fn larger<T: Real>(a: T, b: T) -> T {
    T::select(a.le(b), b, a)
}

/// σ⁺ = Σ ⟨σ_a⟩ n_a n_aᵀ with ⟨x⟩ = (x + |x|)/2: the tensile part of a stress.
#[inline(always)]
pub fn tensile_part<T: Real, const D: usize>(sigma: &Mat<T, D>) -> Mat<T, D> {
    // ERRATUM: the printed line 7 has lost its equals sign.
    let eigen = symmetric_eigen(sigma);
    let mut plus = Mat::zeros();
    for a in 0..D {
        let n = eigen.vectors.column(a);
        plus += Mat::outer(n, n).scale(larger(eigen.values[a], T::zero()));
    }
    plus
}

/// Φ = (A σ⁺) : (σ⁺ A) / σ_c².
#[inline(always)]
pub fn crack_stress<T: Real, const D: usize>(
    A: &Mat<T, D>,
    sigma_plus: &Mat<T, D>,
    sigma_crit: f64,
) -> T {
    (*A * *sigma_plus).dot(&(*sigma_plus * *A)) / T::from_f64(sigma_crit * sigma_crit)
}

/// D̃ = max(ζ ⟨Φ − 1⟩, D̃^H): the driving force, which never falls below its history.
#[inline(always)]
pub fn driving_force<T: Real, const D: usize>(
    parameters: &DamageParameters,
    directors: &Directors<D>,
    F: &Mat<T, D>,
    sigma: &Mat<T, D>,
    history: T,
) -> T {
    let sigma_plus = tensile_part(sigma);
    let sigma_crit = parameters.sigma_crit;
    // |A| ≤ 1 + Σ max(α, 0) bounds Φ: where even that stays below 1, the rotation is not needed.
    let bound = T::from_f64(directors.largest_eigenvalue().powi(2)) * sigma_plus.norm_squared();
    let below = bound.le(T::from_f64(sigma_crit * sigma_crit));
    if !T::any(!below) {
        return history;
    }
    let A = directors.structural_tensor(F);
    // ERRATUM: the minus sign of ⟨Φ − 1⟩ is missing in print.
    let excess = larger(
        crack_stress(&A, &sigma_plus, sigma_crit) - T::one(),
        T::zero(),
    );
    larger(T::from_f64(parameters.zeta) * excess, history)
}
