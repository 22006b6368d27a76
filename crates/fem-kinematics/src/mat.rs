//! Small square matrices of any [`Real`].

use crate::scalar::Real;
use core::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// A D×D matrix, stored by rows: entry (i, j) is `m[(i, j)]` or `m.0[i][j]`. D is 2 or 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mat<T, const D: usize>(pub [[T; D]; D]);

/// A vector of D numbers.
pub type Vector<T, const D: usize> = [T; D];

impl<T, const D: usize> Index<(usize, usize)> for Mat<T, D> {
    type Output = T;
    #[inline(always)]
    fn index(&self, (i, j): (usize, usize)) -> &T {
        &self.0[i][j]
    }
}
impl<T, const D: usize> IndexMut<(usize, usize)> for Mat<T, D> {
    #[inline(always)]
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut T {
        &mut self.0[i][j]
    }
}

impl<T: Real, const D: usize> Default for Mat<T, D> {
    #[inline(always)]
    fn default() -> Self {
        Self::zeros()
    }
}

impl<T: Real, const D: usize> Mat<T, D> {
    /// The matrix whose entry (i, j) is `f(i, j)`.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize, usize) -> T) -> Self {
        let mut m = Self::zeros();
        for i in 0..D {
            for j in 0..D {
                m.0[i][j] = f(i, j);
            }
        }
        m
    }
    /// All entries 0.
    #[inline(always)]
    pub fn zeros() -> Self {
        Self([[T::zero(); D]; D])
    }
    /// The unit matrix I.
    #[inline(always)]
    pub fn identity() -> Self {
        Self::from_diagonal([T::one(); D])
    }
    /// diag(d).
    #[inline(always)]
    pub fn from_diagonal(d: [T; D]) -> Self {
        let mut m = Self::zeros();
        for i in 0..D {
            m.0[i][i] = d[i];
        }
        m
    }
    /// A constant matrix in every lane.
    #[inline(always)]
    pub fn from_f64(m: &Mat<f64, D>) -> Self {
        Self::from_fn(|i, j| T::from_f64(m.0[i][j]))
    }
    /// The same matrix without derivatives: see [`Real::constant`].
    #[inline(always)]
    pub fn constant(&self) -> Self {
        Self::from_fn(|i, j| self.0[i][j].constant())
    }
    /// u vᵀ.
    #[inline(always)]
    pub fn outer(u: [T; D], v: [T; D]) -> Self {
        Self::from_fn(|i, j| u[i] * v[j])
    }
    /// The matrix with 1 at (i, j) and 0 elsewhere.
    #[inline(always)]
    pub fn unit(i: usize, j: usize) -> Self {
        let mut m = Self::zeros();
        m.0[i][j] = T::one();
        m
    }
    /// Column j.
    #[inline(always)]
    pub fn column(&self, j: usize) -> [T; D] {
        vector(|i| self.0[i][j])
    }
    /// Mᵀ.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        Self::from_fn(|i, j| self.0[j][i])
    }
    /// s M.
    #[inline(always)]
    pub fn scale(&self, s: T) -> Self {
        Self::from_fn(|i, j| self.0[i][j] * s)
    }
    /// M v.
    #[inline(always)]
    pub fn mul_vec(&self, v: [T; D]) -> [T; D] {
        vector(|i| dot(self.0[i], v))
    }
    /// Mᵀ v.
    #[inline(always)]
    pub fn tr_mul_vec(&self, v: [T; D]) -> [T; D] {
        vector(|i| dot(self.column(i), v))
    }
    /// Mᵀ N.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn tr_mul(&self, other: &Self) -> Self {
        Self::from_fn(|i, j| dot(self.column(i), other.column(j)))
    }
    /// M Nᵀ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn mul_tr(&self, other: &Self) -> Self {
        Self::from_fn(|i, j| dot(self.0[i], other.0[j]))
    }
    /// Double contraction M : N = Σ Mᵢⱼ Nᵢⱼ.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> T {
        let mut sum = dot(self.0[0], other.0[0]);
        for i in 1..D {
            sum += dot(self.0[i], other.0[i]);
        }
        sum
    }
    /// |M|² = M : M (Frobenius).
    #[inline(always)]
    pub fn norm_squared(&self) -> T {
        self.dot(self)
    }
    /// Σ Mᵢᵢ.
    #[inline(always)]
    pub fn trace(&self) -> T {
        let mut sum = self.0[0][0];
        for i in 1..D {
            sum += self.0[i][i];
        }
        sum
    }
    /// (M + Mᵀ)/2.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn symmetric_part(&self) -> Self {
        Self::from_fn(|i, j| (self.0[i][j] + self.0[j][i]) * T::from_f64(0.5))
    }
    /// det M.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn determinant(&self) -> T {
        let m = &self.0;
        if D == 2 {
            m[0][0] * m[1][1] - m[0][1] * m[1][0]
        } else {
            let c = self.cofactor();
            dot(m[0], c.0[0])
        }
    }
    /// det(I + M) − 1 with no cancellation for small M: tr M (+ Σ principal minors) + det M.
    #[inline(always)]
    pub fn determinant_of_identity_plus_minus_one(&self) -> T {
        let m = &self.0;
        if D == 2 {
            self.trace() + self.determinant()
        } else {
            let minors = (m[0][0] * m[1][1] - m[0][1] * m[1][0])
                + (m[0][0] * m[2][2] - m[0][2] * m[2][0])
                + (m[1][1] * m[2][2] - m[1][2] * m[2][1]);
            self.trace() + minors + self.determinant()
        }
    }
    /// The cofactor matrix, det(M) M⁻ᵀ = ∂det M/∂M; defined for every M.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn cofactor(&self) -> Self {
        let m = &self.0;
        if D == 2 {
            Self::from_fn(|i, j| {
                let e = m[1 - i][1 - j];
                if i == j { e } else { -e }
            })
        } else {
            Self::from_fn(|i, j| {
                let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                m[a][c] * m[b][d] - m[a][d] * m[b][c]
            })
        }
    }
    /// The differential of [`Mat::cofactor`] in direction dM.
    #[inline(always)]
    pub fn cofactor_differential(&self, dm: &Self) -> Self {
        if D == 2 {
            dm.cofactor()
        } else {
            let (m, n) = (&self.0, &dm.0);
            // Loops, not a closure: docs/kernels.md, finding 2.
            let mut differential = Self::zeros();
            for i in 0..D {
                for j in 0..D {
                    let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                    differential.0[i][j] = n[a][c] * m[b][d] + m[a][c] * n[b][d]
                        - n[a][d] * m[b][c]
                        - m[a][d] * n[b][c];
                }
            }
            differential
        }
    }
    /// M⁻¹ by cofactors; non-finite where M is singular.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        self.cofactor()
            .transpose()
            .scale(self.determinant().recip())
    }
}

/// The vector with components `f(i)`: [`core::array::from_fn`], but inlined wherever it stands. That one,
/// and `map` of arrays, leave what they call outside of functions with wide registers, where every
/// operation is a call (docs/kernels.md, finding 2).
#[inline(always)]
pub fn vector<T: Real, const D: usize>(mut f: impl FnMut(usize) -> T) -> Vector<T, D> {
    let mut v = [T::zero(); D];
    for i in 0..D {
        v[i] = f(i);
    }
    v
}

/// u · v.
#[inline(always)]
pub fn dot<T: Real, const D: usize>(u: [T; D], v: [T; D]) -> T {
    let mut sum = u[0] * v[0];
    for i in 1..D {
        sum += u[i] * v[i];
    }
    sum
}

impl<T: Real, const D: usize> Add for Mat<T, D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::from_fn(|i, j| self.0[i][j] + o.0[i][j])
    }
}
impl<T: Real, const D: usize> Sub for Mat<T, D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::from_fn(|i, j| self.0[i][j] - o.0[i][j])
    }
}
impl<T: Real, const D: usize> Neg for Mat<T, D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_fn(|i, j| -self.0[i][j])
    }
}
impl<T: Real, const D: usize> Mul for Mat<T, D> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, o: Self) -> Self {
        Self::from_fn(|i, j| dot(self.0[i], o.column(j)))
    }
}
impl<T: Real, const D: usize> AddAssign for Mat<T, D> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<T: Real, const D: usize> SubAssign for Mat<T, D> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
