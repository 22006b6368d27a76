//! Numeric eigenvalues and definite parts of symmetric ∂P/∂F.

use crate::flattening::{ROW_MAJOR_2D, ROW_MAJOR_3D, from_flat, to_flat};
use crate::jacobi::jacobi_eigen;
use crate::scalar::Real;
use crate::tensor4::Tensor4;

/// V diag(f(λ)) Vᵀ, and the λ.
#[cfg_attr(not(debug_assertions), inline(always))]
fn projected<T: Real, const N: usize>(
    flat: [[T; N]; N],
    mut projection: impl FnMut(T) -> T,
) -> ([[T; N]; N], [T; N]) {
    // A power of two brings the entries near 1, where the eigen-solver's squares are safe.
    let (scale, inverse) = crate::frame::safe_scale_of(flat.iter().flatten().copied());
    let (values, V) = jacobi_eigen(&flat.map(|row| row.map(|x| x * scale)));
    let values = values.map(|x| x * inverse);
    let kept = values.map(&mut projection);
    let mut result = [[T::zero(); N]; N];
    for i in 0..N {
        for j in i..N {
            let mut sum = T::zero();
            for k in 0..N {
                sum += V[i][k] * kept[k] * V[j][k];
            }
            result[i][j] = sum;
            result[j][i] = sum;
        }
    }
    (result, values)
}

impl<T: Real, const D: usize> Tensor4<T, D> {
    /// The symmetric part of the tensor with each eigenvalue λ replaced by `projection(λ)`:
    /// `|x| x.max(T::zero())` gives the nearest positive semidefinite tensor, `T::abs` flips.
    ///
    /// A D²×D² eigen-solve to rounding, repeated eigenvalues included, for any model; slow beside a
    /// model's own blocks.
    #[inline(always)]
    pub fn project(&self, projection: impl FnMut(T) -> T) -> Self {
        let sym = self.symmetric_part();
        if D == 2 {
            from_flat(
                &projected(to_flat(&sym, &ROW_MAJOR_2D), projection).0,
                &ROW_MAJOR_2D,
            )
        } else {
            from_flat(
                &projected(to_flat(&sym, &ROW_MAJOR_3D), projection).0,
                &ROW_MAJOR_3D,
            )
        }
    }
    /// The tensor Tᵢⱼₖₗ with (ij) and (kl) exchanged.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn transpose(&self) -> Self {
        Self::from_fn(|i, j, k, l| self.get(k, l, i, j))
    }
    /// Half the sum with the transpose.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn symmetric_part(&self) -> Self {
        (*self + self.transpose()).scale(T::from_f64(0.5))
    }
}

impl<const D: usize> Tensor4<f64, D> {
    /// The D² eigenvalues of the symmetric part, smallest first.
    pub fn eigenvalues(&self) -> Vec<f64> {
        let sym = self.symmetric_part();
        let mut values = if D == 2 {
            projected(to_flat(&sym, &ROW_MAJOR_2D), |x| x).1.to_vec()
        } else {
            projected(to_flat(&sym, &ROW_MAJOR_3D), |x| x).1.to_vec()
        };
        values.sort_by(f64::total_cmp);
        values
    }
}
