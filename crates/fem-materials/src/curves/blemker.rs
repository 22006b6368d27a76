//! The curves of Blemker, Pinsky and Delp (2005), used by Teran et al. (2003, 2005).

use super::exponential::exponential_remainders;
use super::parabola::parabola_with_tails;
use super::toe::Toe;
use super::{CurvePoint, TensionCurve};
use fem_kinematics::Real;

/// f_a = 1 − 4 e², tails 9 (|e| − 0.6)²; f_p = P₁ (e^{P₂ e} − 1) for 0 < e < λ* − 1, then its
/// tangent; e = l − 1.
///
/// The slope of f_a jumps at |e| = 0.4 (3.6 to 3.2) and that of f_p at l = 1 (0 to P₁ P₂), so the
/// stiffness is not continuous there; [`PhysBam`](super::PhysBam) is smoother.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blemker {
    /// P₁, no unit.
    pub P1: f64,
    /// P₂, no unit.
    pub P2: f64,
    /// λ*, the stretch from which the passive curve is straight.
    pub lambda_star: f64,
}

impl Default for Blemker {
    /// P₁ = 0.05, P₂ = 6.6, λ* = 1.4 (Blemker et al. 2005 as in ArtiSynth's `BlemkerMuscle`).
    fn default() -> Self {
        Self {
            P1: 0.05,
            P2: 6.6,
            lambda_star: 1.4,
        }
    }
}

impl TensionCurve for Blemker {
    #[inline(always)]
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        parabola_with_tails(l, 4.0, 9.0)
    }

    #[inline(always)]
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        let toe = Toe::new(l, self.lambda_star);
        if !T::any(!toe.slack) {
            return CurvePoint::zero();
        }
        let [e1, e2, _] = exponential_remainders(T::from_f64(self.P2) * toe.inside);
        toe.straight_beyond(CurvePoint {
            integral: T::from_f64(self.P1 / self.P2) * e2,
            value: T::from_f64(self.P1) * e1,
            slope: T::from_f64(self.P1 * self.P2) * (T::one() + e1),
        })
    }

    fn has_passive(&self) -> bool {
        self.P1 != 0.0
    }
}
