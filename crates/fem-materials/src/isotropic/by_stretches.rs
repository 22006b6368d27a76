//! Energies of the principal stretches.

use super::blocks::{DiagonalBlocks, PAIRS};
use crate::filter::DefinitenessFilter;
use crate::material::{Evaluation, Material, Symmetry};
use fem_kinematics::{Mat, Real, Svd, Tensor4, signed_svd};

/// ψ(σ), a symmetric function of the signed singular values σ₁ ≥ … ≥ |σ_D|.
///
/// With g = ∂ψ/∂σ, the two quotients are the eigenvalues of the blocks B: they are asked for
/// because gᵢ − gⱼ over σᵢ − σⱼ is 0/0 at repeated stretches, while a model knows the limit and
/// usually a form without any difference.
pub trait StretchEnergy<const D: usize>: Copy + Send + Sync {
    /// ψ, Pa.
    fn energy<T: Real>(&self, sigma: &[T; D]) -> T;
    /// g = ∂ψ/∂σ, Pa.
    fn gradient<T: Real>(&self, sigma: &[T; D]) -> [T; D];
    /// ∂²ψ/∂σ², Pa.
    fn hessian<T: Real>(&self, sigma: &[T; D]) -> Mat<T, D>;
    /// (gᵢ − gⱼ)/(σᵢ − σⱼ), with its limit at σᵢ = σⱼ: the stiffness against stretching the
    /// diagonal between the axes i and j.
    fn difference_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T;
    /// (gᵢ + gⱼ)/(σᵢ + σⱼ): the stiffness against turning i towards j. Grows without bound where
    /// σᵢ + σⱼ → 0 for an energy of the polar rotation; [`positive_sum`] keeps it finite.
    fn sum_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T;

    /// ψ at F = U diag(σ) Vᵀ. To be overridden by a model that loses fewer digits in terms of F.
    #[inline(always)]
    fn energy_at<T: Real>(&self, _F: &Mat<T, D>, svd: &Svd<T, D>) -> T {
        self.energy(&svd.sigma)
    }
    /// P = U diag(g) Vᵀ at F = U diag(σ) Vᵀ. To be overridden by a model that loses fewer digits in
    /// terms of F: of nearly equal stretches U and V are good to ε over their difference only, which
    /// cancels in P but not in what a dual number carries.
    #[inline(always)]
    fn stress_at<T: Real>(&self, _F: &Mat<T, D>, svd: &Svd<T, D>) -> Mat<T, D> {
        svd.compose(self.gradient(&svd.sigma))
    }

    /// ∂P/∂F at diag(σ), from the Hessian and the quotients.
    #[inline(always)]
    fn blocks<T: Real>(&self, sigma: &[T; D]) -> DiagonalBlocks<T, D> {
        let half = T::from_f64(0.5);
        let mut out = DiagonalBlocks {
            A: self.hessian(sigma),
            alpha: [T::zero(); 3],
            beta: [T::zero(); 3],
        };
        for (n, &(i, j)) in PAIRS.iter().enumerate().take(D * (D - 1) / 2) {
            let symmetric = self.difference_quotient(sigma, i, j);
            let turning = self.sum_quotient(sigma, i, j);
            out.alpha[n] = half * (symmetric + turning);
            out.beta[n] = half * (symmetric - turning);
        }
        out
    }
}

/// σᵢ + σⱼ, kept above 0. The order of the singular values makes it ≥ 0.
#[inline(always)]
pub fn positive_sum<T: Real, const D: usize>(sigma: &[T; D], i: usize, j: usize) -> T {
    let (sum, tiny) = (sigma[i] + sigma[j], T::from_f64(1e-18));
    T::select(sum.lt(tiny), tiny, sum)
}

/// The material of an energy given by principal stretches: one signed SVD for everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByStretches<M>(pub M);

#[inline(always)]
fn derivative<T: Real, const D: usize, M: StretchEnergy<D>>(
    model: &M,
    svd: &Svd<T, D>,
    filter: DefinitenessFilter,
) -> Tensor4<T, D> {
    let blocks = model.blocks(&svd.sigma);
    match filter {
        DefinitenessFilter::None => blocks.rotated(svd),
        _ => blocks.filtered(filter).rotated(svd),
    }
}

impl<const D: usize, M: StretchEnergy<D>> Material<D> for ByStretches<M> {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.0.energy_at(F, &signed_svd(F))
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.0.stress_at(F, &signed_svd(F))
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let svd = signed_svd(F);
        let dP_hat = self.0.blocks(&svd.sigma).apply(&svd.to_principal(dF));
        svd.to_world(&dP_hat)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        derivative(&self.0, &signed_svd(F), DefinitenessFilter::None)
    }
    #[inline(always)]
    fn filtered_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        filter: DefinitenessFilter,
    ) -> Tensor4<T, D> {
        derivative(&self.0, &signed_svd(F), filter)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        let svd = signed_svd(F);
        (self.0.energy_at(F, &svd), self.0.stress_at(F, &svd))
    }
    #[inline(always)]
    fn evaluate<T: Real>(&self, F: &Mat<T, D>, filter: DefinitenessFilter) -> Evaluation<T, D> {
        let svd = signed_svd(F);
        Evaluation {
            energy: self.0.energy_at(F, &svd),
            stress: self.0.stress_at(F, &svd),
            derivative: derivative(&self.0, &svd, filter),
        }
    }
}
