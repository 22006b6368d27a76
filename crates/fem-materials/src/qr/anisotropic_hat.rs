//! The energy of document 001 as a function of R, for the general framework.

use super::QrEnergy;
use crate::models::QrAnisotropic;
use fem_kinematics::{Mat, Real};

/// √(r₁₂² + r₂₂²), kept above 0.
#[inline(always)]
fn second_length<T: Real, const D: usize>(R: &Mat<T, D>) -> T {
    let (square, tiny) = (
        R.0[0][1].squared() + R.0[1][1].squared(),
        T::from_f64(1e-36),
    );
    T::select(square.lt(tiny), tiny, square).sqrt()
}

/// Π rᵢᵢ, and its derivatives by the diagonal entries.
#[inline(always)]
fn volume<T: Real, const D: usize>(R: &Mat<T, D>) -> (T, [T; D]) {
    let r = &R.0;
    let mut slopes = [T::one(); D];
    for i in 0..D {
        for k in 0..D {
            if k != i {
                slopes[i] *= r[k][k];
            }
        }
    }
    (r[0][0] * slopes[0], slopes)
}

impl<const D: usize> QrEnergy<D> for QrAnisotropic {
    #[inline(always)]
    fn energy<T: Real>(&self, R: &Mat<T, D>) -> T {
        let t = self.coefficients::<T>();
        let (half, one) = (T::from_f64(0.5), T::one());
        let (J, _) = volume(R);
        let x = R.0[0][0] - one;
        let mut psi = half * t.mu * (R.norm_squared() - T::from_f64(D as f64)) - t.mu * (J - one)
            + half * t.lambda * (J - one).squared()
            + half * t.kx * x * x;
        if D == 3 {
            psi += half * t.ky * (second_length(R) - one).squared();
        }
        psi
    }

    /// K₁, K₂, K₃ and the entries above the diagonal (document 001, 3.2).
    #[inline(always)]
    fn gradient<T: Real>(&self, R: &Mat<T, D>) -> Mat<T, D> {
        let t = self.coefficients::<T>();
        let (J, slopes) = volume(R);
        let pressure = t.lambda * (J - T::one()) - t.mu;
        let mut g = Mat::zeros();
        for i in 0..D {
            for j in i..D {
                g.0[i][j] = t.mu * R.0[i][j];
            }
            g.0[i][i] += pressure * slopes[i];
        }
        g.0[0][0] += t.kx * (R.0[0][0] - T::one());
        if D == 3 {
            let pull = t.ky * (T::one() - second_length(R).recip());
            g.0[0][1] += pull * R.0[0][1];
            g.0[1][1] += pull * R.0[1][1];
        }
        g
    }

    #[inline(always)]
    fn gradient_differential<T: Real>(&self, R: &Mat<T, D>, dR: &Mat<T, D>) -> Mat<T, D> {
        let t = self.coefficients::<T>();
        let (J, slopes) = volume(R);
        let pressure = t.lambda * (J - T::one()) - t.mu;
        let mut dJ = T::zero();
        for i in 0..D {
            dJ += slopes[i] * dR.0[i][i];
        }
        let mut dg = Mat::zeros();
        for i in 0..D {
            for j in i..D {
                dg.0[i][j] = t.mu * dR.0[i][j];
            }
            // change of the product of the other diagonal entries
            let mut change = T::zero();
            for k in 0..D {
                if k != i {
                    let third = if D == 3 {
                        R.0[3 - i - k][3 - i - k]
                    } else {
                        T::one()
                    };
                    change += third * dR.0[k][k];
                }
            }
            dg.0[i][i] += t.lambda * dJ * slopes[i] + pressure * change;
        }
        dg.0[0][0] += t.kx * dR.0[0][0];
        if D == 3 {
            let s = second_length(R).recip();
            let along = (R.0[0][1] * dR.0[0][1] + R.0[1][1] * dR.0[1][1]) * s * s * s;
            let pull = T::one() - s;
            for i in 0..2 {
                dg.0[i][1] += t.ky * (pull * dR.0[i][1] + along * R.0[i][1]);
            }
        }
        dg
    }

    /// u r₁₂ r₃₃, u (r₁₃ r₂₂ − r₁₂ r₂₃), u r₁₁ r₂₃ with u = μ − λ (J − 1) (document 001, 3.5): no
    /// division is left, the fibers cancel.
    #[inline(always)]
    fn lower_entries<T: Real>(&self, R: &Mat<T, D>, _gradient: &Mat<T, D>) -> [T; 3] {
        let t = self.coefficients::<T>();
        let (J, _) = volume(R);
        let (r, zero) = (&R.0, T::zero());
        let u = t.mu - t.lambda * (J - T::one());
        if D == 2 {
            return [u * r[0][1], zero, zero];
        }
        [
            u * r[0][1] * r[2][2],
            u * (r[0][2] * r[1][1] - r[0][1] * r[1][2]),
            u * r[0][0] * r[1][2],
        ]
    }
}
