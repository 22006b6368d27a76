//! What stands in one place of a vector: a number, or those of several right-hand sides.

use super::precision::LevelScalar;
use std::array::from_fn;
use std::ops::{Add, AddAssign, Mul, SubAssign};

/// Largest block whose columns are read in whole registers.
pub const LANES: usize = 8;

/// One number `T`, or one for each of several right-hand sides, so that a matrix is read once for all.
pub trait Entry<T>:
    Copy
    + Default
    + Send
    + Sync
    + Add<Output = Self>
    + AddAssign
    + SubAssign
    + Mul<T, Output = Self>
    + 'static
{
    /// How many numbers.
    const NUMBERS: usize;
    /// One of them.
    fn number(&self, k: usize) -> T;
    /// Overwrites one of them.
    fn set(&mut self, k: usize, value: T);
    /// `sum += block · x`, a block of `D` columns of `D` numbers; what stands behind it may be read and
    /// is not used.
    fn add_columns<const D: usize>(sum: &mut [Self; LANES], block: &[T], x: &[Self; D]);
}

impl<T: LevelScalar> Entry<T> for T {
    const NUMBERS: usize = 1;
    #[inline(always)]
    fn number(&self, _: usize) -> T {
        *self
    }
    #[inline(always)]
    fn set(&mut self, _: usize, value: T) {
        *self = value;
    }
    #[inline(always)]
    fn add_columns<const D: usize>(sum: &mut [T; LANES], block: &[T], x: &[T; D]) {
        if D <= 4 {
            for c in 0..D {
                for r in 0..4 {
                    sum[r] += block[c * D + r] * x[c];
                }
            }
        } else {
            for c in 0..D {
                for r in 0..LANES {
                    sum[r] += block[c * D + r] * x[c];
                }
            }
        }
    }
}

/// The numbers of `B` right-hand sides.
#[derive(Clone, Copy, Debug)]
pub struct Several<T, const B: usize>(pub [T; B]);

impl<T: LevelScalar, const B: usize> Default for Several<T, B> {
    fn default() -> Self {
        Self([T::default(); B])
    }
}

impl<T: LevelScalar, const B: usize> Add for Several<T, B> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl<T: LevelScalar, const B: usize> AddAssign for Several<T, B> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for k in 0..B {
            self.0[k] += other.0[k];
        }
    }
}

impl<T: LevelScalar, const B: usize> SubAssign for Several<T, B> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        for k in 0..B {
            self.0[k] -= other.0[k];
        }
    }
}

impl<T: LevelScalar, const B: usize> Mul<T> for Several<T, B> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self(from_fn(|k| self.0[k] * factor))
    }
}

impl<T: LevelScalar, const B: usize> Entry<T> for Several<T, B> {
    const NUMBERS: usize = B;
    #[inline(always)]
    fn number(&self, k: usize) -> T {
        self.0[k]
    }
    #[inline(always)]
    fn set(&mut self, k: usize, value: T) {
        self.0[k] = value;
    }
    #[inline(always)]
    fn add_columns<const D: usize>(sum: &mut [Self; LANES], block: &[T], x: &[Self; D]) {
        for c in 0..D {
            for r in 0..D {
                sum[r] += x[c] * block[c * D + r];
            }
        }
    }
}
