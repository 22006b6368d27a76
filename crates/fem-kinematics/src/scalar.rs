//! The scalar that every kernel is generic over: `f64`, `f32`, SIMD lanes and dual numbers.

use crate::mat::Mat;
use crate::svd::{self, Svd};
use core::fmt::Debug;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// A real number, or a pack of them.
///
/// Kernels written against this trait never branch on values: they compare to get a
/// [`Real::Mask`] and [`Real::select`] between two results, so that one code serves a single
/// number, eight elements side by side, and a dual number that carries an exact derivative.
pub trait Real:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// One truth value for each number in the pack.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// Distance from 1 to the next representable number.
    const EPSILON: f64;

    /// How many derivatives the number carries: 0, or one more for each level of dual numbers.
    /// Iterations of fixed length take this many more rounds, for the derivatives converge later.
    const DERIVATIVES: usize = 0;

    /// The same constant in every lane; a dual number with zero derivative.
    fn from_f64(value: f64) -> Self;

    /// Square root; NaN for negative numbers.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Natural logarithm; −∞ at 0, NaN below.
    fn ln(self) -> Self;
    /// ln(1 + x) without cancellation for small x.
    fn ln_1p(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// exp(x) − 1 without cancellation for small x.
    fn exp_m1(self) -> Self;
    /// `self` raised to a constant power.
    fn powf(self, exponent: f64) -> Self;

    /// [`signed_svd`](crate::signed_svd) of a matrix of these.
    #[doc(hidden)]
    #[inline(always)]
    fn signed_svd<const D: usize>(F: &Mat<Self, D>) -> Svd<Self, D> {
        svd::in_place(F)
    }

    /// `self < other`, false where either is NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`, false where either is NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `if_true` where the mask holds, else `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// Does the mask hold anywhere? Lets a kernel skip work that no lane needs.
    fn any(mask: Self::Mask) -> bool;

    /// The same number with its derivatives, if it carries any, set to zero.
    #[inline(always)]
    fn constant(self) -> Self {
        self
    }
    /// 0.
    #[inline(always)]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    /// 1.
    #[inline(always)]
    fn one() -> Self {
        Self::from_f64(1.0)
    }
    /// The larger of two numbers; `other` where `self` is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    /// The smaller of two numbers; `other` where `self` is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    /// 1/x.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// x².
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
}

macro_rules! native {
    ($t:ty) => {
        impl Real for $t {
            type Mask = bool;
            const EPSILON: f64 = <$t>::EPSILON as f64;
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$t>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                crate::math::scalar::ln(f64::from(self)) as $t
            }
            #[inline(always)]
            fn ln_1p(self) -> Self {
                crate::math::scalar::ln_1p(f64::from(self)) as $t
            }
            #[inline(always)]
            fn exp(self) -> Self {
                crate::math::scalar::exp(f64::from(self)) as $t
            }
            #[inline(always)]
            fn exp_m1(self) -> Self {
                crate::math::scalar::exp_m1(f64::from(self)) as $t
            }
            #[inline(always)]
            fn powf(self, exponent: f64) -> Self {
                crate::math::scalar::powf(f64::from(self), exponent) as $t
            }
            #[inline(always)]
            fn signed_svd<const D: usize>(F: &Mat<Self, D>) -> Svd<Self, D> {
                svd::called(F)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
                if mask { if_true } else { if_false }
            }
            #[inline(always)]
            fn any(mask: bool) -> bool {
                mask
            }
        }
    };
}
native!(f64);
native!(f32);
