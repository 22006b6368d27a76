//! Four numbers in registers of their own: what one node of a grid carries.
//!
//! # Safety
//! As in [`super::registers`]: the types are private, and [`dispatch_quads`] alone names them,
//! after it has detected the instructions that they need.

use core::ops::{Add, Div, Mul, Sub};

/// Four numbers `T` in the registers of the instruction set that [`dispatch_quads`] chose.
pub trait Quad<T>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The same number four times.
    fn splat(value: T) -> Self;
    /// From memory.
    fn load(from: &[T; 4]) -> Self;
    /// From memory, with zeros behind the third.
    fn load_three(from: &[T; 3]) -> Self;
    /// To memory.
    fn store(self, to: &mut [T; 4]);
    /// The first three to memory.
    fn store_three(self, to: &mut [T; 3]);
    /// The largest whole numbers that are not larger, for numbers within the range of `i32`; beyond it,
    /// and for NaN, a number beyond ±(2³¹ − 1), or NaN.
    #[must_use]
    fn floor(self) -> Self;
    /// Whole numbers as `i32`; any number for one that `i32` does not have.
    fn to_integers(self) -> [i32; 4];
    /// Absolute values.
    #[must_use]
    fn abs(self) -> Self;
    /// The larger of each two; either of them where one is NaN.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// Is every number at most that of `other`? Not where one is NaN.
    fn all_at_most(self, other: Self) -> bool;
    /// The transpose of the matrix with these rows.
    fn transposed(rows: [Self; 4]) -> [Self; 4];
    /// `self + s v`, rounded twice: never fused.
    #[inline(always)]
    #[must_use]
    fn plus_scaled(self, s: T, v: Self) -> Self {
        self + Self::splat(s) * v
    }
}

/// A computation on quadruples, to be compiled once for each instruction set.
///
/// For loops over the nodes of a grid, each with four numbers in a row; see
/// [`PackedKernel`](super::PackedKernel) for loops over elements. Mark `run` and all that it calls
/// `#[inline(always)]`, and call no closure twice: what is not inlined is compiled for the
/// baseline and passes its quadruples through memory.
///
/// ```
/// use fem_kinematics::{Quad, QuadKernel, dispatch_quads};
/// struct Doubled<'a>(&'a mut [[f32; 4]]);
/// impl QuadKernel<f32> for Doubled<'_> {
///     type Output = ();
///     #[inline(always)]
///     fn run<Q: Quad<f32>>(self) {
///         for node in self.0 {
///             (Q::splat(2.0) * Q::load(node)).store(node);
///         }
///     }
/// }
/// let mut nodes = [[1.0, 2.0, 3.0, 4.0]];
/// dispatch_quads(Doubled(&mut nodes));
/// assert_eq!(nodes, [[2.0, 4.0, 6.0, 8.0]]);
/// ```
pub trait QuadKernel<T> {
    /// What the computation returns.
    type Output;
    /// The computation.
    fn run<Q: Quad<T>>(self) -> Self::Output;
}

/// The numbers that [`dispatch_quads`] knows: `f64` and `f32`.
pub trait QuadScalar: sealed::Sealed + Copy {
    #[doc(hidden)]
    fn dispatch<K: QuadKernel<Self>>(kernel: K) -> K::Output;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
}

/// Runs `kernel` with the quadruples of this processor; the bits are the same with all.
#[inline]
pub fn dispatch_quads<T: QuadScalar, K: QuadKernel<T>>(kernel: K) -> K::Output {
    T::dispatch(kernel)
}

/// Quadruples of plain numbers, for processors and builds without the others.
#[cfg_attr(
    all(target_arch = "x86_64", not(debug_assertions), not(test)),
    allow(dead_code)
)]
#[derive(Clone, Copy)]
pub(super) struct Plain<T>([T; 4]);

macro_rules! plain_operator {
    ($trait:ident, $function:ident, $operator:tt) => {
        impl<T: Copy + $trait<Output = T>> $trait for Plain<T> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, o: Self) -> Self {
                let (a, b) = (self.0, o.0);
                Self([a[0] $operator b[0], a[1] $operator b[1], a[2] $operator b[2], a[3] $operator b[3]])
            }
        }
    };
}
plain_operator!(Add, add, +);
plain_operator!(Sub, sub, -);
plain_operator!(Mul, mul, *);
plain_operator!(Div, div, /);

macro_rules! plain {
    ($t:ty) => {
        impl Quad<$t> for Plain<$t> {
            #[inline(always)]
            fn splat(value: $t) -> Self {
                Self([value; 4])
            }
            #[inline(always)]
            fn load(from: &[$t; 4]) -> Self {
                Self(*from)
            }
            #[inline(always)]
            fn load_three(from: &[$t; 3]) -> Self {
                Self([from[0], from[1], from[2], 0.0])
            }
            #[inline(always)]
            fn store(self, to: &mut [$t; 4]) {
                *to = self.0;
            }
            #[inline(always)]
            fn store_three(self, to: &mut [$t; 3]) {
                *to = [self.0[0], self.0[1], self.0[2]];
            }
            #[inline(always)]
            fn floor(self) -> Self {
                Self(self.0.map(|x| {
                    // A cast truncates; one comparison makes it a floor without a call to libm.
                    let truncated = x as i32 as $t;
                    if truncated > x {
                        truncated - 1.0
                    } else if truncated <= x {
                        truncated
                    } else {
                        x
                    }
                }))
            }
            #[inline(always)]
            fn to_integers(self) -> [i32; 4] {
                self.0.map(|x| x as i32)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.map(<$t>::abs))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Self(core::array::from_fn(
                    |i| if a[i] > b[i] { a[i] } else { b[i] },
                ))
            }
            #[inline(always)]
            fn all_at_most(self, other: Self) -> bool {
                let (a, b) = (self.0, other.0);
                (a[0] <= b[0]) & (a[1] <= b[1]) & (a[2] <= b[2]) & (a[3] <= b[3])
            }
            #[inline(always)]
            fn transposed(rows: [Self; 4]) -> [Self; 4] {
                core::array::from_fn(|i| Self(core::array::from_fn(|j| rows[j].0[i])))
            }
        }
    };
}
plain!(f64);
plain!(f32);

#[cfg(target_arch = "x86_64")]
#[cfg_attr(all(debug_assertions, not(test)), allow(dead_code))]
pub(super) mod x86;

macro_rules! scalar {
    ($t:ty, $wide:ident, $baseline:ident) => {
        impl QuadScalar for $t {
            #[inline]
            fn dispatch<K: QuadKernel<Self>>(kernel: K) -> K::Output {
                // Debug builds compile one kind instead of three; the bits are the same.
                #[cfg(any(not(target_arch = "x86_64"), all(debug_assertions, not(test))))]
                return kernel.run::<Plain<Self>>();
                #[cfg(all(target_arch = "x86_64", any(test, not(debug_assertions))))]
                {
                    use super::{InstructionSet, widest};
                    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
                    fn with_avx512<K: QuadKernel<$t>>(kernel: K) -> K::Output {
                        kernel.run::<x86::$wide>()
                    }
                    #[target_feature(enable = "avx2")]
                    fn with_avx2<K: QuadKernel<$t>>(kernel: K) -> K::Output {
                        kernel.run::<x86::$wide>()
                    }
                    match widest() {
                        // SAFETY: the features that the function was compiled for were detected.
                        InstructionSet::Avx512 => unsafe { with_avx512(kernel) },
                        // SAFETY: likewise.
                        InstructionSet::Avx2 => unsafe { with_avx2(kernel) },
                        InstructionSet::Baseline => kernel.run::<x86::$baseline>(),
                    }
                }
            }
        }
    };
}
scalar!(f64, Avx, Sse2);
scalar!(f32, Sse, Sse);
