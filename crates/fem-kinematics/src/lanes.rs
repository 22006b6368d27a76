//! Packs of numbers that the compiler turns into SIMD registers.

use crate::scalar::Real;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// `N` numbers side by side; every operation is done lane by lane, so each lane has the very
/// bits that the scalar code would give, on any processor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<S, const N: usize>(pub [S; N]);

/// Eight `f64`: one AVX-512 register, two AVX2 registers.
pub type F64x8 = Lanes<f64, 8>;
/// Sixteen `f32`: one AVX-512 register, two AVX2 registers.
pub type F32x16 = Lanes<f32, 16>;

/// One truth value per lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneMask<const N: usize>(pub [bool; N]);

impl<const N: usize> BitAnd for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] & other.0[i]))
    }
}
impl<const N: usize> BitOr for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}
impl<const N: usize> Not for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|b| !b))
    }
}

impl<S: Copy + Default, const N: usize> Default for Lanes<S, N> {
    #[inline(always)]
    fn default() -> Self {
        Self([S::default(); N])
    }
}

macro_rules! lane_op {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<S: Real, const N: usize> $trait for Lanes<S, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(core::array::from_fn(|i| self.0[i] $op other.0[i]))
            }
        }
    };
}
lane_op!(Add, add, +);
lane_op!(Sub, sub, -);
lane_op!(Mul, mul, *);
lane_op!(Div, div, /);

macro_rules! lane_assign {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<S: Real, const N: usize> $trait for Lanes<S, N> {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                *self = *self $op other;
            }
        }
    };
}
lane_assign!(AddAssign, add_assign, +);
lane_assign!(SubAssign, sub_assign, -);
lane_assign!(MulAssign, mul_assign, *);

impl<S: Real, const N: usize> Neg for Lanes<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(core::array::from_fn(|i| -self.0[i]))
    }
}

impl<S: Real<Mask = bool>, const N: usize> Real for Lanes<S, N> {
    type Mask = LaneMask<N>;
    const EPSILON: f64 = S::EPSILON;
    const DERIVATIVES: usize = S::DERIVATIVES;
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self([S::from_f64(value); N])
    }
    #[inline(always)]
    fn constant(self) -> Self {
        Self(self.0.map(S::constant))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].sqrt()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].abs()))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].ln()))
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].ln_1p()))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].exp()))
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i].exp_m1()))
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        Self(core::array::from_fn(|i| self.0[i].powf(exponent)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<N> {
        LaneMask(core::array::from_fn(|i| self.0[i].lt(other.0[i])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<N> {
        LaneMask(core::array::from_fn(|i| self.0[i].le(other.0[i])))
    }
    #[inline(always)]
    fn select(mask: LaneMask<N>, if_true: Self, if_false: Self) -> Self {
        Self(core::array::from_fn(|i| {
            S::select(mask.0[i], if_true.0[i], if_false.0[i])
        }))
    }
    #[inline(always)]
    fn any(mask: LaneMask<N>) -> bool {
        mask.0.iter().any(|&b| b)
    }
}
