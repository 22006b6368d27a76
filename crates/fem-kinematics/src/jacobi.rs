//! Symmetric eigenvalues by cyclic Jacobi rotations: in a fixed number of sweeps up to 3×3, above
//! until all lanes have converged.

use crate::frame::orthogonalize;
use crate::mat::{Mat, vector};
use crate::scalar::Real;

/// Squares below this are rounding error beside entries of order 1, and may underflow.
pub(crate) fn negligible_square<T: Real>() -> T {
    T::from_f64(if T::EPSILON < 1e-10 { 1e-250 } else { 1e-34 })
}

/// Makes A_pq zero: A ← JᵀAJ, V ← VJ. Of A only the upper triangle is read and written. An entry
/// of at most half the threshold stays, and nothing turns; the mask says where something did.
#[cfg_attr(not(debug_assertions), inline(always))]
fn rotate<T: Real, const N: usize>(
    A: &mut [[T; N]; N],
    V: &mut [[T; N]; N],
    (p, q): (usize, usize),
    threshold: T,
) -> T::Mask {
    let (zero, one) = (T::zero(), T::one());
    let h = A[p][q] + A[p][q];
    let d = A[p][p] - A[q][q];
    let square = d * d + h * h;
    let needed = negligible_square::<T>().lt(square) & !h.abs().le(threshold);
    // tan of the smaller rotation angle; the square root is kept away from 0, where it has no
    // derivative.
    let r = T::select(needed, square, one).sqrt();
    let ratio = T::select(needed, h, zero) / (d.abs() + r);
    let t = T::select(d.lt(zero), -ratio, ratio);
    let c = (one + t * t).sqrt().recip();
    let s = t * c;
    let shift = t * A[p][q];
    A[p][p] += shift;
    A[q][q] -= shift;
    A[p][q] = T::select(needed, zero, A[p][q]);
    for k in 0..N {
        if k != p && k != q {
            let (kp, kq) = ((k.min(p), k.max(p)), (k.min(q), k.max(q)));
            let (x, y) = (A[kp.0][kp.1], A[kq.0][kq.1]);
            A[kp.0][kp.1] = c * x + s * y;
            A[kq.0][kq.1] = c * y - s * x;
        }
        let (x, y) = (V[k][p], V[k][q]);
        V[k][p] = c * x + s * y;
        V[k][q] = c * y - s * x;
    }
    needed
}

#[inline(always)]
fn identity<T: Real, const N: usize>() -> [[T; N]; N] {
    let mut V = [[T::zero(); N]; N];
    for i in 0..N {
        V[i][i] = T::one();
    }
    V
}

#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn cyclic_jacobi<T: Real, const N: usize>(
    mut A: [[T; N]; N],
    sweeps: usize,
) -> ([T; N], [[T; N]; N]) {
    let mut V = identity();
    // Below 0: every entry turns, also one that is rounding error, because its derivative is not.
    let threshold = T::from_f64(-1.0);
    for _ in 0..sweeps {
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut A, &mut V, (p, q), threshold);
            }
        }
    }
    (vector(|i| A[i][i]), V)
}

/// Sweeps until nothing is left to turn. Turning by rounding errors is not harmless in a large
/// matrix: a rotation between two equal eigenvalues has any angle, and stirs the entries that other
/// rotations have just made zero; and a lane that has finished must stay as it is, so that its bits
/// do not depend on its neighbors.
#[cfg_attr(not(debug_assertions), inline(always))]
fn converged_jacobi<T: Real, const N: usize>(mut A: [[T; N]; N]) -> ([T; N], [[T; N]; N]) {
    const MOST_SWEEPS: usize = 16;
    let mut largest = T::zero();
    for i in 0..N {
        for j in i..N {
            largest = A[i][j].abs().max(largest);
        }
    }
    let threshold = largest * T::from_f64(T::EPSILON / 16.0);
    let mut V = identity();
    for _ in 0..MOST_SWEEPS {
        let mut turned = false;
        for p in 0..N {
            for q in p + 1..N {
                turned |= T::any(rotate(&mut A, &mut V, (p, q), threshold));
            }
        }
        if !turned {
            break;
        }
    }
    (vector(|i| A[i][i]), V)
}

/// A = V diag(values) Vᵀ of a symmetric N×N matrix, N up to about 12; values in no special order,
/// eigenvectors in the columns of V.
///
/// The upper triangle is read. The entries should be near 1 in size (a matrix whose squares
/// underflow is taken for diagonal): see [`symmetric_eigen`] for one that scales.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn jacobi_eigen<T: Real, const N: usize>(A: &[[T; N]; N]) -> ([T; N], [[T; N]; N]) {
    if N > 3 && T::DERIVATIVES == 0 {
        return converged_jacobi(*A);
    }
    let sweeps = if N <= 3 {
        4
    } else if N == 4 {
        5
    } else {
        8
    };
    cyclic_jacobi(*A, sweeps + T::DERIVATIVES)
}

/// Eigenvalues and eigenvectors of a symmetric D×D matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetricEigen<T, const D: usize> {
    /// The eigenvalues, largest first.
    pub values: [T; D],
    /// A rotation whose columns are the eigenvectors.
    pub vectors: Mat<T, D>,
}

/// A = V diag(values) Vᵀ of a symmetric matrix (upper triangle read), V a rotation, largest
/// eigenvalue first; no branches, any scale, repeated values allowed.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn symmetric_eigen<T: Real, const D: usize>(A: &Mat<T, D>) -> SymmetricEigen<T, D> {
    let (s, inverse) = crate::frame::safe_scale(A);
    let (values, V) = jacobi_eigen(&A.scale(s).0);
    let (values, V) = descending(values, V);
    SymmetricEigen {
        values: vector(|i| values[i] * inverse),
        vectors: orthogonalize(&Mat(V)).Q,
    }
}

/// Sorts the values, largest first, and the columns of V with them.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn descending<T: Real, const D: usize>(
    mut values: [T; D],
    mut V: [[T; D]; D],
) -> ([T; D], [[T; D]; D]) {
    exchange(&mut values, &mut V, 0, 1);
    if D == 3 {
        exchange(&mut values, &mut V, 0, 2);
        exchange(&mut values, &mut V, 1, 2);
    }
    (values, V)
}

#[inline(always)]
fn exchange<T: Real, const D: usize>(values: &mut [T; D], V: &mut [[T; D]; D], i: usize, j: usize) {
    let (a, b) = (values[i], values[j]);
    let swap = a.lt(b);
    values[i] = T::select(swap, b, a);
    values[j] = T::select(swap, a, b);
    for row in V {
        let (a, b) = (row[i], row[j]);
        row[i] = T::select(swap, b, a);
        row[j] = T::select(swap, a, b);
    }
}
