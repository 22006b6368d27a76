//! The building blocks of dP/dF: each adds one term in place.

use fem_kinematics::{Mat, Real, Tensor4};

/// A dP/dF under construction.
#[derive(Clone, Copy)]
pub(crate) struct Terms<T, const D: usize>(pub Tensor4<T, D>);

impl<T: Real, const D: usize> Terms<T, D> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self(Tensor4::zeros())
    }
    /// dP = s dF.
    #[inline(always)]
    pub(crate) fn identity(mut self, s: T) -> Self {
        for j in 0..D {
            for i in 0..D {
                self.0.0[j][j].0[i][i] += s;
            }
        }
        self
    }
    /// dP = s A (B : dF).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn outer(mut self, s: T, A: &Mat<T, D>, B: &Mat<T, D>) -> Self {
        let A = A.scale(s);
        for j in 0..D {
            for l in 0..D {
                self.0.0[j][l] += Mat::outer(A.column(j), B.column(l));
            }
        }
        self
    }
    /// dP = s A dFᵀ B.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn transposed(mut self, s: T, A: &Mat<T, D>, B: &Mat<T, D>) -> Self {
        let A = A.scale(s);
        for j in 0..D {
            for l in 0..D {
                self.0.0[j][l] += Mat::outer(A.column(l), B.column(j));
            }
        }
        self
    }
    /// dP = M dF.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn left(mut self, M: &Mat<T, D>) -> Self {
        for j in 0..D {
            self.0.0[j][j] += *M;
        }
        self
    }
    /// dP = dF M.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn right(mut self, M: &Mat<T, D>) -> Self {
        for j in 0..D {
            for l in 0..D {
                for i in 0..D {
                    self.0.0[j][l].0[i][i] += M.0[l][j];
                }
            }
        }
        self
    }
    /// dP = s d(cof F): the change of the cofactor matrix.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn cofactor(mut self, s: T, F: &Mat<T, D>) -> Self {
        if D == 2 {
            for (i, k, sign_ik) in [(0, 1, s), (1, 0, -s)] {
                self.0.0[0][1].0[i][k] += sign_ik;
                self.0.0[1][0].0[i][k] += -sign_ik;
            }
        } else {
            let F = F.scale(s);
            for n in 0..D {
                let (j, l) = ((n + 1) % D, (n + 2) % D);
                for m in 0..D {
                    let (i, k) = ((m + 1) % D, (m + 2) % D);
                    let f = F.0[m][n];
                    self.0.0[j][l].0[i][k] += f;
                    self.0.0[j][l].0[k][i] += -f;
                    self.0.0[l][j].0[i][k] += -f;
                    self.0.0[l][j].0[k][i] += f;
                }
            }
        }
        self
    }
}
