//! Energies of the principal stretches.

use super::blocks::{DiagonalBlocks, PAIRS, rotated, rotated_in_place};
use crate::material::{Evaluation, Material, Symmetry};
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Polar, Real, Svd, Tensor4, dot, signed_svd, vector};

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
    /// terms of F.
    #[inline(always)]
    fn stress_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> Mat<T, D> {
        if T::DERIVATIVES > 0 {
            return self.interpolated_stress(F, svd);
        }
        svd.compose(self.gradient(&svd.sigma))
    }
    /// P = R g(S), the function g of the matrix S in Newton's form
    /// g₁ I + g[σ₁, σ₂] (S − σ₁) + g[σ₁, σ₂, σ₃] (S − σ₁)(S − σ₂).
    ///
    /// σ, U and V of nearly equal stretches have derivatives that are good to ε over their difference
    /// only. In U diag(g) Vᵀ a dual number carries that along; here it cancels, because R and S are
    /// good to ε and a divided difference comes with as many factors S − σ.
    #[inline(always)]
    fn interpolated_stress<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> Mat<T, D> {
        let Polar { R, S, .. } = Polar::from_svd(F, svd);
        // Rayleigh's quotients, of S less a constant so that V's derivatives meet small numbers only:
        // what they lack in one stretch they have too much in the next.
        let sigma: [T; D] = vector(|i| {
            let (v, c) = (svd.V.column(i), svd.sigma[i].constant());
            let rest = (S - Mat::identity().scale(c)).mul_vec(v);
            c + dot(v, rest) / dot(v, v)
        });
        let sigma = &sigma;
        let above = |i: usize| S - Mat::identity().scale(sigma[i]);
        let first = self.difference_quotient(sigma, 0, 1);
        let mut g = Mat::identity().scale(self.gradient(sigma)[0]) + above(0).scale(first);
        if D == 3 {
            let gap = sigma[2] - sigma[0];
            let apart = T::zero().lt(gap.abs());
            let change = self.difference_quotient(sigma, 1, 2) - first;
            let second = T::select(apart, change, T::zero()) / T::select(apart, gap, T::one());
            g += (above(0) * above(1)).symmetric_part().scale(second);
        }
        R * g
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
    projection: HessianProjection,
) -> Tensor4<T, D> {
    rotated_in_place(&model.blocks(&svd.sigma), svd, projection)
}

impl<const D: usize, M: StretchEnergy<D>> Material<D> for ByStretches<M> {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;
    const DECOMPOSES: bool = true;

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
        derivative(&self.0, &signed_svd(F), HessianProjection::None)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        let svd = signed_svd(F);
        rotated(&self.0.blocks(&svd.sigma), &svd, projection)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        let svd = signed_svd(F);
        (self.0.energy_at(F, &svd), self.0.stress_at(F, &svd))
    }
    #[inline(always)]
    fn evaluate<T: Real>(&self, F: &Mat<T, D>, projection: HessianProjection) -> Evaluation<T, D> {
        let svd = signed_svd(F);
        Evaluation {
            energy: self.0.energy_at(F, &svd),
            stress: self.0.stress_at(F, &svd),
            derivative: derivative(&self.0, &svd, projection),
        }
    }
}
