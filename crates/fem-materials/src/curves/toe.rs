//! What both passive curves do at their ends: nothing where the fiber is slack, a straight line
//! where it is stretched beyond λ*.

use super::CurvePoint;
use fem_kinematics::Real;

/// A strain e = l − 1 cut in two at λ* − 1.
pub(super) struct Toe<T: Real> {
    /// l ≤ 1.
    pub slack: T::Mask,
    /// The part of e that lies on the curve, 0 where the fiber is slack.
    pub inside: T,
    /// The part of e beyond λ* − 1.
    beyond: T,
}

impl<T: Real> Toe<T> {
    #[inline(always)]
    pub(super) fn new(l: T, lambda_star: f64) -> Self {
        let e = l - T::one();
        let zero = T::zero();
        let slack = e.le(zero);
        let cutoff = T::from_f64(lambda_star - 1.0);
        Self {
            slack,
            inside: T::select(slack, zero, T::select(cutoff.le(e), cutoff, e)),
            beyond: T::select(cutoff.lt(e), e - cutoff, zero),
        }
    }

    /// The curve whose point at `inside` is given, with its tangent beyond it.
    #[inline(always)]
    pub(super) fn straight_beyond(&self, at: CurvePoint<T>) -> CurvePoint<T> {
        let half = T::from_f64(0.5);
        CurvePoint {
            integral: at.integral + self.beyond * (at.value + half * at.slope * self.beyond),
            value: at.value + at.slope * self.beyond,
            slope: T::select(self.slack, T::zero(), at.slope),
        }
    }
}
