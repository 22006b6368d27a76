//! The passive curve of tendons and ligaments.

use super::{CurvePoint, TensionCurve};
use fem_kinematics::Real;

/// f_a = 0; f_p = e²/(2 toe) for 0 < e < toe, then e − toe/2; e = l − 1. Multiplied by a modulus it
/// is a toe of crimped collagen and a straight line (Zajac 1989).
///
/// C¹, and never active: an activation changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tendon {
    /// The strain that straightens the fibers, above 0.
    pub toe: f64,
}

impl TensionCurve for Tendon {
    #[inline(always)]
    fn active<T: Real>(&self, _: T) -> CurvePoint<T> {
        CurvePoint::zero()
    }

    #[inline(always)]
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        let e = l - T::one();
        let (zero, half) = (T::zero(), T::from_f64(0.5));
        let toe = T::from_f64(self.toe);
        let inside = T::select(e.le(zero), zero, T::select(toe.le(e), toe, e));
        let beyond = T::select(toe.lt(e), e - toe, zero);
        let slope = inside / toe;
        let value = half * inside * slope;
        CurvePoint {
            integral: T::from_f64(1.0 / 3.0) * value * inside
                + beyond * (value + half * slope * beyond),
            value: value + slope * beyond,
            slope,
        }
    }

    fn has_active(&self) -> bool {
        false
    }
}
