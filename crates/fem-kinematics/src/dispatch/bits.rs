//! Bit operations on packs of `f64`, which the elementary functions are made of.

use crate::scalar::Real;

/// A pack of `f64` whose bits can be worked on as `u64`, lane by lane.
pub(crate) trait Bits: Real {
    /// The number with these bits in every lane.
    fn from_bits(bits: u64) -> Self;
    /// Sum of the bits as integers, wrapping.
    fn plus(self, other: Self) -> Self;
    /// Difference of the bits as integers, wrapping.
    fn minus(self, other: Self) -> Self;
    /// Bitwise and.
    fn and(self, other: Self) -> Self;
    /// Bitwise or.
    fn or(self, other: Self) -> Self;
    /// Bits shifted right, zeros from the left.
    fn right<const N: i32>(self) -> Self;
    /// Bits shifted left.
    fn left<const N: i32>(self) -> Self;
    /// Product of the low 32 bits of both.
    fn times_low(self, other: Self) -> Self;
}

impl Bits for f64 {
    #[inline(always)]
    fn from_bits(bits: u64) -> Self {
        Self::from_bits(bits)
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self::from_bits(self.to_bits().wrapping_add(other.to_bits()))
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self::from_bits(self.to_bits().wrapping_sub(other.to_bits()))
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() & other.to_bits())
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() | other.to_bits())
    }
    #[inline(always)]
    fn right<const N: i32>(self) -> Self {
        Self::from_bits(self.to_bits() >> N)
    }
    #[inline(always)]
    fn left<const N: i32>(self) -> Self {
        Self::from_bits(self.to_bits() << N)
    }
    #[inline(always)]
    fn times_low(self, other: Self) -> Self {
        Self::from_bits((self.to_bits() & 0xffff_ffff) * (other.to_bits() & 0xffff_ffff))
    }
}
