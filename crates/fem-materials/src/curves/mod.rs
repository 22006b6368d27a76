//! How strongly a muscle fiber pulls at a given stretch.
//!
//! Curves are pure numbers: multiply by σ_max. Their argument is the normalized stretch
//! l = λ/λ_ofl, 1 at the length where the active force peaks.

mod blemker;
mod exponential;
mod parabola;
mod physbam;
mod spline;
mod tendon;
mod toe;

pub use blemker::Blemker;
pub use physbam::PhysBam;
pub use spline::{CurveError, Ends, Spline, SplineCurve};
pub use tendon::Tendon;

use fem_kinematics::Real;

/// A curve f at one l, with what stands above and below it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvePoint<T> {
    /// ∫₁ˡ f, the energy's shape.
    pub integral: T,
    /// f(l), the tension's shape.
    pub value: T,
    /// f′(l), the stiffness' shape.
    pub slope: T,
}

impl<T: Real> CurvePoint<T> {
    /// A slack fiber.
    #[inline(always)]
    fn zero() -> Self {
        Self {
            integral: T::zero(),
            value: T::zero(),
            slope: T::zero(),
        }
    }
}

/// The active and the passive tension of a fiber as functions of the normalized stretch l.
///
/// Implementations don't branch on values, so that eight fibers side by side cost little more
/// than one; a curve that is not a formula is a [`SplineCurve`].
pub trait TensionCurve: Send + Sync {
    /// Active tension f_a, to be multiplied by the activation: 1 at l = 1.
    fn active<T: Real>(&self, l: T) -> CurvePoint<T>;
    /// Passive tension f_p: 0 up to l = 1.
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T>;
    /// May f_a be other than 0 at some l? Where it may not, an activation changes nothing and nobody
    /// asks what it changes.
    fn has_active(&self) -> bool {
        true
    }
    /// May f_p be other than 0 at some l? Where it may not, a relaxed fiber is nothing and nobody
    /// evaluates it.
    fn has_passive(&self) -> bool {
        true
    }
}

impl<C: TensionCurve> TensionCurve for &C {
    #[inline(always)]
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        (**self).active(l)
    }
    #[inline(always)]
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        (**self).passive(l)
    }
    fn has_active(&self) -> bool {
        (**self).has_active()
    }
    fn has_passive(&self) -> bool {
        (**self).has_passive()
    }
}

/// One of the two built-in curves, chosen at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuiltinCurve {
    /// [`PhysBam`]: continuous stiffness; the default.
    PhysBam(PhysBam),
    /// [`Blemker`]: as published, with small jumps of the stiffness.
    Blemker(Blemker),
}

impl Default for BuiltinCurve {
    fn default() -> Self {
        Self::PhysBam(PhysBam::default())
    }
}

impl TensionCurve for BuiltinCurve {
    #[inline(always)]
    fn active<T: Real>(&self, l: T) -> CurvePoint<T> {
        match self {
            Self::PhysBam(curve) => curve.active(l),
            Self::Blemker(curve) => curve.active(l),
        }
    }
    #[inline(always)]
    fn passive<T: Real>(&self, l: T) -> CurvePoint<T> {
        match self {
            Self::PhysBam(curve) => curve.passive(l),
            Self::Blemker(curve) => curve.passive(l),
        }
    }
    fn has_passive(&self) -> bool {
        match self {
            Self::PhysBam(curve) => curve.has_passive(),
            Self::Blemker(curve) => curve.has_passive(),
        }
    }
}
