//! The curves of PhysBAM's `FACE_3D.h`, with continuous stiffness.

use super::exponential::exponential_remainders;
use super::parabola::parabola_with_tails;
use super::toe::Toe;
use super::{CurvePoint, TensionCurve};
use fem_kinematics::Real;

/// f_a = 1 − 25/6 e², tails 25/3 (|e| − 0.6)²; f_p = P₁ (e^{P₂ e} − P₂ e − 1) for
/// 0 < e < λ* − 1, then its tangent; e = l − 1.
///
/// Both are C¹. The factor 25/6 stands in PhysBAM (named `scale`) but is not used in the copy of
/// `FACE_3D.h` that this follows, whose curve therefore jumps at |e| = 0.4.
// ERRATUM: with the factor the two parabolas meet with equal slopes, so it is used here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysBam {
    /// P₁, no unit (PhysBAM `fiber_p1`).
    pub P1: f64,
    /// P₂, no unit (PhysBAM `fiber_p2`).
    pub P2: f64,
    /// λ*, the stretch from which the passive curve is straight (PhysBAM `fiber_cutoff`).
    pub lambda_star: f64,
}

impl Default for PhysBam {
    /// P₁ = 0.05, P₂ = 6.6, λ* = 1.4 (PhysBAM `FACE_3D.h`).
    fn default() -> Self {
        Self {
            P1: 0.05,
            P2: 6.6,
            lambda_star: 1.4,
        }
    }
}

impl TensionCurve for PhysBam {
    #[inline(always)]
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        parabola_with_tails(l, 25.0 / 6.0, 25.0 / 3.0)
    }

    #[inline(always)]
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        let toe = Toe::new(l, self.lambda_star);
        if !T::any(!toe.slack) {
            return CurvePoint::zero();
        }
        let [e1, e2, e3] = exponential_remainders(T::from_f64(self.P2) * toe.inside);
        toe.straight_beyond(CurvePoint {
            integral: T::from_f64(self.P1 / self.P2) * e3,
            value: T::from_f64(self.P1) * e2,
            slope: T::from_f64(self.P1 * self.P2) * e1,
        })
    }

    fn has_passive(&self) -> bool {
        self.P1 != 0.0
    }
}
