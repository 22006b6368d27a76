//! The polar decomposition with a rotation, and its derivatives.

use crate::checked::Checked;
use crate::frame::polish;
use crate::mat::{Mat, vector};
use crate::qr::multiply_by_skew;
use crate::scalar::Real;
use crate::svd::{Svd, signed_svd};
use crate::tensor4::Tensor4;

/// F = R S with R a rotation (never a reflection) and S symmetric; for det F < 0 the smallest
/// eigenvalue of S is negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar<T, const D: usize> {
    /// R, a rotation.
    pub R: Mat<T, D>,
    /// S = Rᵀ F, symmetric.
    pub S: Mat<T, D>,
    /// F = U diag(σ) Vᵀ; of dual numbers the value only.
    principal: Svd<T, D>,
}

/// R = U Vᵀ and S = V diag(σ) Vᵀ from the signed singular value decomposition.
///
/// R has derivatives (by dual numbers too) wherever σᵢ + σⱼ ≠ 0 for all i ≠ j, repeated values
/// included.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn polar<T: Real, const D: usize>(F: &Mat<T, D>) -> Polar<T, D> {
    Polar::from_svd(F, &signed_svd(&F.constant()))
}

/// R (I − [h])⁻¹ (I + [h]), a rotation for every h.
#[cfg_attr(not(debug_assertions), inline(always))]
fn cayley<T: Real, const D: usize>(R: &Mat<T, D>, h: [T; 3]) -> Mat<T, D> {
    let two = T::from_f64(2.0);
    let factor = two / (T::one() + (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]));
    let first = multiply_by_skew(R, h);
    *R + (first + multiply_by_skew(&first, h)).scale(factor)
}

/// The w with (tr(S) I − S) w = axis of (A − Aᵀ), S = V diag(σ) Vᵀ; zero about the axes where
/// σᵢ + σⱼ vanishes.
#[cfg_attr(not(debug_assertions), inline(always))]
fn solve_rate<T: Real, const D: usize>(principal: &Svd<T, D>, A: &Mat<T, D>) -> [T; 3] {
    let zero = T::zero();
    if D == 2 {
        return [zero, zero, divide(principal, axis(A, 0, 1), 0, 1)];
    }
    // The pairs (1, 2), (2, 0), (0, 1) turn about the axes 0, 1, 2.
    let a: [T; D] = vector(|k| axis(A, (k + 1) % 3, (k + 2) % 3));
    let p = principal.V.tr_mul_vec(a);
    let w = principal.V.mul_vec(vector(|k| {
        divide(principal, p[k], (k + 1) % 3, (k + 2) % 3)
    }));
    vector(|k| w[k])
}

#[inline(always)]
fn axis<T: Real, const D: usize>(A: &Mat<T, D>, i: usize, j: usize) -> T {
    A.0[j][i] - A.0[i][j]
}

/// x/(σᵢ + σⱼ), 0 where the sum vanishes.
#[inline(always)]
fn divide<T: Real, const D: usize>(principal: &Svd<T, D>, x: T, i: usize, j: usize) -> T {
    let sum = principal.sigma[i] + principal.sigma[j];
    let regular = rounding(principal).lt(sum);
    T::select(regular, x, T::zero()) / T::select(regular, sum, T::one())
}

/// A sum σᵢ + σⱼ up to this is rounding error.
#[inline(always)]
fn rounding<T: Real, const D: usize>(principal: &Svd<T, D>) -> T {
    principal.sigma[0] * T::from_f64(8.0 * T::EPSILON)
}

impl<T: Real, const D: usize> Polar<T, D> {
    /// [`polar`] of an F whose decomposition is at hand.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_svd(F: &Mat<T, D>, svd: &Svd<T, D>) -> Self {
        let principal = Svd {
            U: svd.U.constant(),
            sigma: svd.sigma.map(Real::constant),
            V: svd.V.constant(),
        };
        let mut R = polish(&principal.U.mul_tr(&principal.V));
        // U and V have no derivatives at repeated values, where R has. Each step of this Newton
        // iteration with a fixed matrix makes one more order of R's derivatives right.
        for _ in 0..T::DERIVATIVES {
            let half = solve_rate(&principal, &R.tr_mul(F)).map(|w| w * T::from_f64(0.5));
            R = cayley(&R, half);
        }
        Self {
            R,
            S: R.tr_mul(F).symmetric_part(),
            principal,
        }
    }
    /// Is R determined, and differentiable? The smallest sum σᵢ + σⱼ must not vanish.
    #[inline(always)]
    pub fn unique(&self) -> T::Mask {
        let s = &self.principal.sigma;
        rounding(&self.principal).lt(s[D - 2] + s[D - 1])
    }
    /// The axis w of the skew matrix Rᵀ dR = W: (tr(S) I − S) w = axis of Rᵀ dF − dFᵀ R.
    ///
    /// About an axis where σᵢ + σⱼ = 0 the rate does not exist and is set to zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation_rate(&self, dF: &Mat<T, D>) -> [T; 3] {
        let A = self.R.tr_mul(dF);
        let mut w = solve_rate(&self.principal, &A);
        for _ in 0..T::DERIVATIVES {
            // [w] S + S [w] is what is reached; its axis is that of the skew matrix B − Bᵀ.
            let B = multiply_by_skew(&Mat::identity(), w) * self.S;
            let correction = solve_rate(&self.principal, &(A - B));
            w = vector(|k| w[k] + correction[k]);
        }
        w
    }
    /// dR = R W in direction dF, W the skew matrix of the axis w.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation_differential(&self, dF: &Mat<T, D>) -> Checked<Mat<T, D>, T::Mask> {
        Checked {
            value: multiply_by_skew(&self.R, self.rotation_rate(dF)),
            exists: self.unique(),
        }
    }
    /// dS = sym(Rᵀ dF − W S) in direction dF.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn stretch_differential(&self, dF: &Mat<T, D>) -> Checked<Mat<T, D>, T::Mask> {
        let turned = multiply_by_skew(&Mat::identity(), self.rotation_rate(dF)) * self.S;
        Checked {
            value: (self.R.tr_mul(dF) - turned).symmetric_part(),
            exists: self.unique(),
        }
    }
    /// ∂R/∂F, the Hessian of tr S.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation_derivative(&self) -> Checked<Tensor4<T, D>, T::Mask> {
        Checked {
            value: Tensor4::from_linear_map(|dF| self.rotation_differential(dF).value),
            exists: self.unique(),
        }
    }
    /// ∂S/∂F.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn stretch_derivative(&self) -> Checked<Tensor4<T, D>, T::Mask> {
        Checked {
            value: Tensor4::from_linear_map(|dF| self.stretch_differential(dF).value),
            exists: self.unique(),
        }
    }
    /// The signed singular value decomposition that R and S were made of (of dual numbers the
    /// value only).
    #[inline(always)]
    pub fn principal(&self) -> &Svd<T, D> {
        &self.principal
    }
}
