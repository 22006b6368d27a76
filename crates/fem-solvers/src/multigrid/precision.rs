//! The numbers that a hierarchy is kept in.

use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

mod sealed {
    /// Closed: a hierarchy is in one of two precisions.
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The precision of a hierarchy: `f32`, or `f64` with twice the memory.
pub trait LevelScalar:
    Copy
    + Send
    + Sync
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + SubAssign
    + sealed::Sealed
    + 'static
{
    /// Rounds.
    fn narrow(value: f64) -> Self;
    /// Widens.
    fn widen(self) -> f64;
}

impl LevelScalar for f64 {
    #[inline(always)]
    fn narrow(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        self
    }
}

impl LevelScalar for f32 {
    #[inline(always)]
    fn narrow(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self)
    }
}
