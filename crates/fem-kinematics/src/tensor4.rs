//! Fourth-order tensors such as dP/dF.

use crate::mat::Mat;
use crate::scalar::Real;

/// ∂Pᵢⱼ/∂Fₖₗ, kept as D×D blocks: block (j, l) is the matrix with entry (i, k).
///
/// With the area normals b_a of a simplex the stiffness block between nodes a and b is then a
/// plain sum of blocks, K_ab = V Σⱼₗ (b_a)ⱼ (b_b)ₗ T(j, l), and 2D and 3D are one code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensor4<T, const D: usize>(pub [[Mat<T, D>; D]; D]);

impl<T: Real, const D: usize> Tensor4<T, D> {
    /// All entries 0.
    #[inline(always)]
    pub fn zeros() -> Self {
        Self([[Mat::zeros(); D]; D])
    }
    /// From its entries `f(i, j, k, l)` = ∂Pᵢⱼ/∂Fₖₗ.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize, usize, usize, usize) -> T) -> Self {
        let mut t = Self::zeros();
        for j in 0..D {
            for l in 0..D {
                t.0[j][l] = Mat::from_fn(|i, k| f(i, j, k, l));
            }
        }
        t
    }
    /// From a linear map dF ↦ dP, column by column.
    #[inline(always)]
    pub fn from_linear_map(mut differential: impl FnMut(&Mat<T, D>) -> Mat<T, D>) -> Self {
        let mut t = Self::zeros();
        for k in 0..D {
            for l in 0..D {
                let dP = differential(&Mat::unit(k, l));
                for i in 0..D {
                    for j in 0..D {
                        t.0[j][l].0[i][k] = dP.0[i][j];
                    }
                }
            }
        }
        t
    }
    /// ∂Pᵢⱼ/∂Fₖₗ.
    #[inline(always)]
    pub fn get(&self, i: usize, j: usize, k: usize, l: usize) -> T {
        self.0[j][l].0[i][k]
    }
    /// Write ∂Pᵢⱼ/∂Fₖₗ.
    #[inline(always)]
    pub fn entry_mut(&mut self, i: usize, j: usize, k: usize, l: usize) -> &mut T {
        &mut self.0[j][l].0[i][k]
    }
    /// s T.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn scale(&self, s: T) -> Self {
        let mut scaled = Self::zeros();
        for j in 0..D {
            for l in 0..D {
                scaled.0[j][l] = self.0[j][l].scale(s);
            }
        }
        scaled
    }
    /// The contraction T : dF = dP.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(&self, dF: &Mat<T, D>) -> Mat<T, D> {
        let mut dP = Mat::zeros();
        for j in 0..D {
            for l in 0..D {
                let column = self.0[j][l].mul_vec(dF.column(l));
                for i in 0..D {
                    dP.0[i][j] += column[i];
                }
            }
        }
        dP
    }
    /// Σⱼₗ uⱼ vₗ T(j, l): the stiffness block between two area normals.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn contract(&self, u: [T; D], v: [T; D]) -> Mat<T, D> {
        let mut sum = Mat::zeros();
        for j in 0..D {
            for l in 0..D {
                sum += self.0[j][l].scale(u[j] * v[l]);
            }
        }
        sum
    }
}

impl<T: Real, const D: usize> core::ops::Add for Tensor4<T, D> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(self, o: Self) -> Self {
        let mut sum = self;
        for j in 0..D {
            for l in 0..D {
                sum.0[j][l] += o.0[j][l];
            }
        }
        sum
    }
}
impl<T: Real, const D: usize> core::ops::AddAssign for Tensor4<T, D> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
