//! The two storage scalars of the host: `f64` and `f32`.

use fem_kinematics::{QuadScalar, Real};

/// A single machine number: what particles and nodes are stored in.
pub trait Float: Real<Mask = bool> + QuadScalar + PartialOrd {
    /// The smallest normal number; nodes lighter than this carry no velocity.
    const TINY: Self;
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
    /// ⌊x⌋, saturating at the ends of `i32`.
    fn floor_to_i32(self) -> i32;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
}

macro_rules! float {
    ($t:ty) => {
        impl Float for $t {
            const TINY: Self = <$t>::MIN_POSITIVE;
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn floor_to_i32(self) -> i32 {
                // A cast truncates; one comparison makes it a floor without a call to libm.
                let truncated = self as i32;
                truncated.saturating_sub(i32::from((truncated as $t) > self))
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$t>::is_finite(self)
            }
        }
    };
}
float!(f64);
float!(f32);

/// The larger of two errors, NaN being the largest: a NaN, once met, stays to the end of a fold
/// (`f64::max` would drop it).
#[inline(always)]
pub fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// Does every entry hold a finite number?
#[inline(always)]
pub(crate) fn all_finite<T: Float, const N: usize>(v: &[T; N]) -> bool {
    // 0 x is NaN for an x that is not finite; one comparison for the whole array.
    let mut sum = T::zero();
    for &x in v {
        sum += x * T::zero();
    }
    sum == T::zero()
}
