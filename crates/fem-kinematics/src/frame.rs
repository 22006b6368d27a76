//! Orthonormal frames from columns: the step that the singular value and QR decompositions share.

use crate::mat::{Mat, dot, vector};
use crate::scalar::Real;

/// u × v.
#[inline(always)]
pub(crate) fn cross<T: Real, const D: usize>(u: [T; D], v: [T; D]) -> [T; D] {
    vector(|i| {
        let (a, b) = ((i + 1) % 3, (i + 2) % 3);
        u[a] * v[b] - u[b] * v[a]
    })
}

#[inline(always)]
pub(crate) fn select<T: Real, const D: usize>(mask: T::Mask, a: [T; D], b: [T; D]) -> [T; D] {
    vector(|i| T::select(mask, a[i], b[i]))
}

#[inline(always)]
fn scaled<T: Real, const D: usize>(u: [T; D], s: T) -> [T; D] {
    vector(|i| u[i] * s)
}

/// u − s v.
#[inline(always)]
fn minus<T: Real, const D: usize>(u: [T; D], s: T, v: [T; D]) -> [T; D] {
    vector(|i| u[i] - s * v[i])
}

/// A power of two s such that the entries of s F can be squared twice with no overflow, and 1/s.
///
/// Reaches the whole range of the number type.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn safe_scale<T: Real, const D: usize>(F: &Mat<T, D>) -> (T, T) {
    safe_scale_of(F.0.iter().flatten().copied())
}

/// [`safe_scale`] of any numbers.
#[inline(always)]
pub(crate) fn safe_scale_of<T: Real>(entries: impl Iterator<Item = T>) -> (T, T) {
    // Fourth powers of 2^±(limit) are representable, with room for ε² below.
    let (limit, step) = if T::EPSILON < 1e-10 {
        (1.427_247_692_705_96e45, 2.037_035_976_334_486e90) // 2^150, 2^300
    } else {
        (1_048_576.0, 1_099_511_627_776.0) // 2^20, 2^40
    };
    let mut largest = T::zero();
    for x in entries {
        largest = x.abs().max(largest);
    }
    let (mut s, mut inverse) = (T::one(), T::one());
    for _ in 0..3 {
        let (large, small) = (
            T::from_f64(limit).lt(largest),
            largest.lt(T::from_f64(1.0 / limit)) & T::zero().lt(largest),
        );
        let factor = pick(large, small, 1.0 / step, step);
        s *= factor;
        largest *= factor;
        inverse *= pick(large, small, step, 1.0 / step);
    }
    (s, inverse)
}

#[inline(always)]
fn pick<T: Real>(large: T::Mask, small: T::Mask, if_large: f64, if_small: f64) -> T {
    T::select(
        large,
        T::from_f64(if_large),
        T::select(small, T::from_f64(if_small), T::one()),
    )
}

/// A unit vector at right angles to the unit vector u.
#[cfg_attr(not(debug_assertions), inline(always))]
fn perpendicular<T: Real, const D: usize>(u: [T; D]) -> [T; D] {
    // Of e₁ and e₂ take the one that is farther from u.
    let first = u[0].abs().lt(u[1].abs());
    let mut e = [T::zero(); D];
    e[0] = T::select(first, T::one(), T::zero());
    e[1] = T::select(first, T::zero(), T::one());
    let w = minus(e, dot(u, e), u);
    scaled(w, dot(w, w).sqrt().recip())
}

/// Q R = B with Q a rotation, R upper triangular, all of R's diagonal but the last entry ≥ 0.
pub(crate) struct QrFactors<T: Real, const D: usize> {
    pub Q: Mat<T, D>,
    pub R: Mat<T, D>,
    /// The leading D − 1 columns are independent to rounding.
    pub independent: T::Mask,
}

/// Orthogonalizes the columns of B, whose entries must not over- or underflow when squared.
///
/// Where a column is zero, or depends on those before it, any direction that completes the frame
/// is taken, so Q is a rotation for every finite B.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn orthogonalize<T: Real, const D: usize>(B: &Mat<T, D>) -> QrFactors<T, D> {
    let tiny = T::from_f64(if T::EPSILON < 1e-10 { 1e-280 } else { 1e-35 });
    let zero = T::zero();
    let mut first: [T; D] = [zero; D];
    first[0] = T::one();

    let b1 = B.column(0);
    let s1 = dot(b1, b1);
    let nonzero1 = tiny.lt(s1);
    let r11 = T::select(nonzero1, T::select(nonzero1, s1, T::one()).sqrt(), zero);
    let q1 = select(
        nonzero1,
        scaled(b1, T::select(nonzero1, r11, T::one()).recip()),
        first,
    );
    let mut R = Mat::zeros();
    R.0[0][0] = r11;
    if D == 2 {
        let mut Q = Mat::zeros();
        Q.0[0][0] = q1[0];
        Q.0[1][0] = q1[1];
        Q.0[0][1] = -q1[1];
        Q.0[1][1] = q1[0];
        R.0[0][1] = dot(q1, B.column(1));
        R.0[1][1] = dot(Q.column(1), B.column(1));
        return QrFactors {
            Q,
            R,
            independent: nonzero1,
        };
    }
    let b2 = B.column(1);
    // Twice: one pass leaves an error of ε|b₂|/r₂₂ along q₁.
    let once = minus(b2, dot(q1, b2), q1);
    let w = minus(once, dot(q1, once), q1);
    let s2 = dot(w, w);
    let rounding = T::from_f64(4.0 * T::EPSILON * T::EPSILON) * dot(b2, b2);
    let nonzero2 = rounding.lt(s2) & tiny.lt(s2);
    let length = T::select(nonzero2, s2, T::one()).sqrt();
    let q2 = select(nonzero2, scaled(w, length.recip()), perpendicular(q1));
    let q3 = cross(q1, q2);
    let b3 = B.column(2);
    R.0[0][1] = dot(q1, b2);
    R.0[1][1] = T::select(nonzero2, length, zero);
    for (i, q) in [q1, q2, q3].into_iter().enumerate() {
        R.0[i][2] = dot(q, b3);
    }
    QrFactors {
        Q: Mat::from_fn(|i, j| [q1, q2, q3][j][i]),
        R,
        independent: nonzero1 & nonzero2,
    }
}

/// Q (3 I − QᵀQ)/2, one step of Newton and Schulz: a matrix that is orthogonal but for a few ε
/// becomes so to the last digit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn polish<T: Real, const D: usize>(Q: &Mat<T, D>) -> Mat<T, D> {
    let defect = (Mat::identity() - Q.tr_mul(Q)).scale(T::from_f64(0.5));
    *Q + *Q * defect
}
