//! What to do with the negative eigenvalues of dP/dF: nothing, clamp, or flip.

use fem_kinematics::{Real, Tensor4};

/// The treatment of negative eigenvalues of an element's dP/dF.
///
/// A strained body can be stable as a whole while most of its elements are indefinite, so a
/// solver starts with [`DefinitenessFilter::None`] and filters only when it meets negative
/// curvature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DefinitenessFilter {
    /// The exact derivative.
    #[default]
    None,
    /// Negative eigenvalues become 0: the nearest positive semidefinite tensor (doc 000, 5.6).
    Clamp,
    /// Negative eigenvalues change sign, which keeps the length of steps along them
    /// (Chen, Sharp and Jacobson 2024, "Stabler Neo-Hookean Simulation: Absolute Eigenvalue
    /// Filtering for Projected Newton").
    Absolute,
}

impl DefinitenessFilter {
    /// The filter on one eigenvalue.
    #[inline(always)]
    pub fn eigenvalue<T: Real>(self, value: T) -> T {
        match self {
            Self::None => value,
            Self::Clamp => T::select(value.lt(T::zero()), T::zero(), value),
            Self::Absolute => value.abs(),
        }
    }

    /// The filter on a symmetric 2×2 matrix [[α, β], [β, α]]: returns the new (α, β).
    #[inline(always)]
    pub fn twin<T: Real>(self, alpha: T, beta: T) -> (T, T) {
        let half = T::from_f64(0.5);
        let symmetric = self.eigenvalue(alpha + beta);
        let antisymmetric = self.eigenvalue(alpha - beta);
        (
            half * (symmetric + antisymmetric),
            half * (symmetric - antisymmetric),
        )
    }

    /// The filter on a symmetric N×N matrix, by its eigenvalues.
    #[inline(always)]
    pub fn matrix<T: Real, const N: usize>(self, a: &[[T; N]; N]) -> [[T; N]; N] {
        if self == Self::None {
            return *a;
        }
        let (values, vectors) = symmetric_eigen(a, N);
        let values = values.map(|value| self.eigenvalue(value));
        let mut out = [[T::zero(); N]; N];
        for i in 0..N {
            for j in 0..N {
                for k in 0..N {
                    out[i][j] += vectors[i][k] * values[k] * vectors[j][k];
                }
            }
        }
        out
    }

    /// The filter on the whole tensor, by the eigenvalues of its D²×D² matrix; the slow way that
    /// works for every model.
    #[inline(always)]
    pub fn apply<T: Real, const D: usize>(self, derivative: &Tensor4<T, D>) -> Tensor4<T, D> {
        if self == Self::None {
            return *derivative;
        }
        let mut a = [[T::zero(); 9]; 9];
        let half = T::from_f64(0.5);
        for i in 0..D {
            for j in 0..D {
                for k in 0..D {
                    for l in 0..D {
                        a[D * i + j][D * k + l] =
                            half * (derivative.get(i, j, k, l) + derivative.get(k, l, i, j));
                    }
                }
            }
        }
        let (values, vectors) = symmetric_eigen(&a, D * D);
        let values = values.map(|value| self.eigenvalue(value));
        Tensor4::from_fn(|i, j, k, l| {
            let mut sum = T::zero();
            for m in 0..D * D {
                sum += vectors[D * i + j][m] * values[m] * vectors[D * k + l][m];
            }
            sum
        })
    }
}

/// Eigenvalues and eigenvectors (columns) of the leading `n`×`n` part of a symmetric matrix by
/// cyclic Jacobi rotations; a sweep is skipped once no lane has anything left to rotate.
#[inline(always)]
pub(crate) fn symmetric_eigen<T: Real, const N: usize>(
    a: &[[T; N]; N],
    n: usize,
) -> ([T; N], [[T; N]; N]) {
    let mut a = *a;
    let mut v = [[T::zero(); N]; N];
    for i in 0..N {
        v[i][i] = T::one();
    }
    let mut scale = T::zero();
    for i in 0..n {
        for j in 0..n {
            scale += a[i][j] * a[i][j];
        }
    }
    let negligible = scale * T::from_f64(T::EPSILON * T::EPSILON * 0.01);
    let smallest = T::from_f64(f64::from(f32::MIN_POSITIVE));
    for _ in 0..16 {
        let mut off = T::zero();
        for p in 0..n {
            for q in p + 1..n {
                off += a[p][q] * a[p][q];
            }
        }
        if !T::any(negligible.lt(off)) {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                let (apq, gap) = (a[p][q], a[q][q] - a[p][p]);
                let two = apq + apq;
                let length = gap.abs() + (gap * gap + two * two).sqrt();
                let t = T::select(smallest.lt(length), two / length.max(smallest), T::zero());
                let t = T::select(gap.lt(T::zero()), -t, t);
                let c = (T::one() + t * t).sqrt().recip();
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k][p], a[k][q]);
                    a[k][p] = c * x - s * y;
                    a[k][q] = s * x + c * y;
                }
                for k in 0..n {
                    let (x, y) = (a[p][k], a[q][k]);
                    a[p][k] = c * x - s * y;
                    a[q][k] = s * x + c * y;
                }
                for k in 0..n {
                    let (x, y) = (v[k][p], v[k][q]);
                    v[k][p] = c * x - s * y;
                    v[k][q] = s * x + c * y;
                }
            }
        }
    }
    (core::array::from_fn(|i| a[i][i]), v)
}
