//! The active curve that both publications share: a parabola with two parabolic tails.

use super::CurvePoint;
use fem_kinematics::Real;

/// With e = l − 1: f = 1 − c e² for |e| < 0.4, k (|e| − 0.6)² for 0.4 ≤ |e| < 0.6, else 0.
#[inline(always)]
pub(super) fn parabola_with_tails<T: Real>(l: T, c: f64, k: f64) -> CurvePoint<T> {
    let e = l - T::one();
    let a = e.abs();
    let negative = e.lt(T::zero());
    let odd = |x: T| T::select(negative, -x, x);
    let f64 = T::from_f64;
    let middle = a.lt(f64(0.4));
    // 0 beyond the tails, so that one formula serves both. (Comparisons send NaN to the branch
    // that keeps it.)
    let r = T::select(f64(0.6).le(a), T::zero(), f64(0.6) - a);
    let at_joint = 0.4 - c / 3.0 * 0.064 + k / 3.0 * 0.008;
    let square = a * a;
    CurvePoint {
        integral: odd(T::select(
            middle,
            a - f64(c / 3.0) * a * square,
            f64(at_joint) - f64(k / 3.0) * r * r * r,
        )),
        value: T::select(middle, T::one() - f64(c) * square, f64(k) * r * r),
        slope: odd(T::select(middle, f64(-2.0 * c) * a, f64(-2.0 * k) * r)),
    }
}
