//! The signed QR decomposition (document 001, section 3) and its derivatives.

use crate::checked::Checked;
use crate::frame::{orthogonalize, safe_scale};
use crate::mat::Mat;
use crate::scalar::Real;
use crate::tensor4::Tensor4;

/// F = Q R with Q a rotation and R upper triangular; r₁₁ ≥ 0, in 3D r₂₂ ≥ 0, and the last
/// diagonal entry has the sign of det F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Qr<T: Real, const D: usize> {
    /// Q, a rotation.
    pub Q: Mat<T, D>,
    /// R, upper triangular.
    pub R: Mat<T, D>,
    /// Are the leading D − 1 columns of F independent, to rounding? Only there are Q, R and
    /// their derivatives determined; elsewhere they are one of many choices.
    pub unique: T::Mask,
}

/// Decomposes any finite F, in every scale. Q takes any direction that completes it to a
/// rotation where F e₁ vanishes, or (in 3D) F e₂ depends on it.
// ERRATUM: document 001, section 3.1 flips signs in pairs, which cannot repair det Q = −1; here
// Q is a rotation by construction and the last diagonal entry takes the sign.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn signed_qr<T: Real, const D: usize>(F: &Mat<T, D>) -> Qr<T, D> {
    let (scale, inverse) = safe_scale(F);
    let frame = orthogonalize(&F.scale(scale));
    Qr {
        Q: frame.Q,
        R: frame.R.scale(inverse),
        unique: frame.independent,
    }
}

/// Q Ω for the skew matrix Ω of the axis ω: Ω v = ω × v (3D). In 2D only ω₃ counts, and
/// Ω = [[0, −ω₃], [ω₃, 0]].
///
/// The function `Q_mult_Omega` of document 001, section 3.4.3.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn multiply_by_skew<T: Real, const D: usize>(Q: &Mat<T, D>, omega: [T; 3]) -> Mat<T, D> {
    let [w1, w2, w3] = omega;
    Mat::from_fn(|i, j| {
        let q = &Q.0[i];
        match (D, j) {
            (2, 0) => q[1] * w3,
            (2, _) => -(q[0] * w3),
            (_, 0) => q[1] * w3 - q[2] * w2,
            (_, 1) => q[2] * w1 - q[0] * w3,
            (_, _) => q[0] * w2 - q[1] * w1,
        }
    })
}

impl<T: Real, const D: usize> Qr<T, D> {
    /// ω of the skew matrix Qᵀ dQ, from A = Qᵀ dF; zero where Q is not unique.
    ///
    /// ω₃ = A₂₁/r₁₁, ω₂ = −A₃₁/r₁₁, ω₁ = (A₃₂ + ω₂ r₁₂)/r₂₂ (document 001, section 3.4.2).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotation_rate(&self, dF: &Mat<T, D>) -> [T; 3] {
        let A = self.Q.tr_mul(dF).0;
        let (zero, one) = (T::zero(), T::one());
        let r11 = T::select(self.unique, self.R.0[0][0], one);
        let w3 = T::select(self.unique, A[1][0] / r11, zero);
        if D == 2 {
            return [zero, zero, w3];
        }
        let r22 = T::select(self.unique, self.R.0[1][1], one);
        let w2 = T::select(self.unique, -(A[2][0] / r11), zero);
        let w1 = T::select(self.unique, (A[2][1] + w2 * self.R.0[0][1]) / r22, zero);
        [w1, w2, w3]
    }
    /// dQ = Q Ω in direction dF; zero where it does not exist.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn q_differential(&self, dF: &Mat<T, D>) -> Checked<Mat<T, D>, T::Mask> {
        Checked {
            value: multiply_by_skew(&self.Q, self.rotation_rate(dF)),
            exists: self.unique,
        }
    }
    /// dR = Qᵀ dF − Ω R in direction dF, upper triangular; where Q is not unique, the upper
    /// triangle of Qᵀ dF.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn r_differential(&self, dF: &Mat<T, D>) -> Checked<Mat<T, D>, T::Mask> {
        let A = self.Q.tr_mul(dF);
        let turned = multiply_by_skew(&Mat::identity(), self.rotation_rate(dF)) * self.R;
        Checked {
            value: Mat::from_fn(|i, j| {
                if i <= j {
                    A.0[i][j] - turned.0[i][j]
                } else {
                    T::zero()
                }
            }),
            exists: self.unique,
        }
    }
    /// ∂Q/∂F.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn q_derivative(&self) -> Checked<Tensor4<T, D>, T::Mask> {
        Checked {
            value: Tensor4::from_linear_map(|dF| self.q_differential(dF).value),
            exists: self.unique,
        }
    }
    /// ∂R/∂F.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn r_derivative(&self) -> Checked<Tensor4<T, D>, T::Mask> {
        Checked {
            value: Tensor4::from_linear_map(|dF| self.r_differential(dF).value),
            exists: self.unique,
        }
    }
}
