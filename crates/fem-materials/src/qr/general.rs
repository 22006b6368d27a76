//! The framework of document 001, 3.2-3.5: stress and stress derivative of any energy Ψ̂(R).

use crate::material::Material;
use fem_kinematics::{Mat, Qr, Real, Tensor4, signed_qr};

/// Ψ̂(R), an energy of the upper triangular factor of F = Q R (its signs as in
/// [`signed_qr`]).
pub trait QrEnergy<const D: usize>: Copy + Send + Sync {
    /// Ψ̂, Pa.
    fn energy<T: Real>(&self, R: &Mat<T, D>) -> T;
    /// ∂Ψ̂/∂R, upper triangular, Pa.
    fn gradient<T: Real>(&self, R: &Mat<T, D>) -> Mat<T, D>;
    /// The change of ∂Ψ̂/∂R for an upper triangular dR, Pa.
    fn gradient_differential<T: Real>(&self, R: &Mat<T, D>, dR: &Mat<T, D>) -> Mat<T, D>;

    /// The entries (2,1), (3,1), (3,2) of QᵀP; in 2D only the first counts.
    ///
    /// The default divides by r₁₁ and r₂₂ (document 001, 3.5.2). An energy whose numerators
    /// contain these factors overrides it and has a bounded stress for every F.
    #[inline(always)]
    fn lower_entries<T: Real>(&self, R: &Mat<T, D>, gradient: &Mat<T, D>) -> [T; 3] {
        let (r, g, zero) = (&R.0, &gradient.0, T::zero());
        if D == 2 {
            return [
                (g[0][1] * r[1][1] - g[1][1] * r[0][1]) / r[0][0],
                zero,
                zero,
            ];
        }
        let first = (g[0][1] * r[1][1] + g[0][2] * r[1][2] - g[1][1] * r[0][1] - g[1][2] * r[0][2])
            / r[0][0];
        let third = (g[1][2] * r[2][2] - g[2][2] * r[1][2]) / r[1][1];
        let second = (g[0][2] * r[2][2] - g[2][2] * r[0][2] - r[0][1] * third) / r[0][0];
        [first, second, third]
    }
}

/// The material of an energy Ψ̂(R): one signed QR decomposition.
///
/// dP/dF exists where the leading columns of F are independent; elsewhere Q, and with it the
/// derivative, is not determined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeneralQr<E>(pub E);

/// The symmetric A = Qᵀ P Rᵀ from the upper part of (∂Ψ̂/∂R) Rᵀ (document 001, 3.2).
#[inline(always)]
fn mirrored<T: Real, const D: usize>(upper: &Mat<T, D>) -> Mat<T, D> {
    Mat::from_fn(|i, j| if i <= j { upper.0[i][j] } else { upper.0[j][i] })
}

impl<E> GeneralQr<E> {
    /// Qᵀ P: the upper triangle is ∂Ψ̂/∂R itself, the lower one comes without division where the
    /// energy allows (document 001, 3.5).
    #[inline(always)]
    fn q_transposed_stress<T: Real, const D: usize>(&self, R: &Mat<T, D>) -> Mat<T, D>
    where
        E: QrEnergy<D>,
    {
        let mut M = self.0.gradient(R);
        let lower = self.0.lower_entries(R, &M);
        M.0[1][0] = lower[0];
        if D == 3 {
            M.0[2][0] = lower[1];
            M.0[2][1] = lower[2];
        }
        M
    }

    /// P = Q A R⁻ᵀ as document 001, 3.2 has it, with the division; [`Material::stress`] keeps
    /// more digits.
    #[inline(always)]
    pub fn stress_by_division<T: Real, const D: usize>(&self, F: &Mat<T, D>) -> Mat<T, D>
    where
        E: QrEnergy<D>,
    {
        let Qr { Q, R, .. } = signed_qr(F);
        let A = mirrored(&self.0.gradient(&R).mul_tr(&R));
        Q * A.mul_tr(&R.inverse())
    }

    /// dA for dR: the upper part of d(∂Ψ̂/∂R) Rᵀ + (∂Ψ̂/∂R) dRᵀ, mirrored.
    #[inline(always)]
    fn a_differential<T: Real, const D: usize>(&self, R: &Mat<T, D>, dR: &Mat<T, D>) -> Mat<T, D>
    where
        E: QrEnergy<D>,
    {
        let change = self.0.gradient_differential(R, dR).mul_tr(R);
        mirrored(&(change + self.0.gradient(R).mul_tr(dR)))
    }
}

impl<const D: usize, E: QrEnergy<D>> Material<D> for GeneralQr<E> {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.0.energy(&signed_qr(F).R)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let Qr { Q, R, .. } = signed_qr(F);
        Q * self.q_transposed_stress(&R)
    }

    /// The three terms of document 001, 3.3:
    /// dP = −Q dQᵀ P + Q dA R⁻ᵀ − P dRᵀ R⁻ᵀ.
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let qr = signed_qr(F);
        let P = qr.Q * self.q_transposed_stress(&qr.R);
        let dQ = qr.q_differential(dF).value;
        let dR = qr.r_differential(dF).value;
        let R_inverse = qr.R.inverse();
        let turn = (qr.Q * dQ.tr_mul(&P)).scale(-T::one());
        let stretch = qr.Q * self.a_differential(&qr.R, &dR) - P.mul_tr(&dR);
        turn + stretch.mul_tr(&R_inverse)
    }

    /// The three terms of document 001, 3.4, with ∂Q/∂F, ∂R/∂F and R⁻ᵀ = Qᵀ cof F/J.
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let qr = signed_qr(F);
        let (dQ_dF, dR_dF) = (qr.q_derivative().value, qr.r_derivative().value);
        let A = mirrored(&self.0.gradient(&qr.R).mul_tr(&qr.R));
        let (cof, inverse_J) = (F.cofactor(), F.determinant().recip());
        let R_inverse_transposed = qr.Q.tr_mul(&cof).scale(inverse_J);
        Tensor4::from_linear_map(|dF| {
            let (dQ, dR) = (dQ_dF.apply(dF), dR_dF.apply(dF));
            let dA = self.a_differential(&qr.R, &dR);
            let dJ = cof.dot(dF);
            let d_inverse = (dQ.tr_mul(&cof) + qr.Q.tr_mul(&F.cofactor_differential(dF)))
                .scale(inverse_J)
                - R_inverse_transposed.scale(dJ * inverse_J);
            (dQ * A + qr.Q * dA) * R_inverse_transposed + qr.Q * A * d_inverse
        })
    }
}
