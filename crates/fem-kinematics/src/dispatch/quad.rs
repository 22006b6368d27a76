//! Four numbers in registers of their own: what one node of a grid carries.
//!
//! # Safety
//! As in [`super::registers`]: the types are private, and [`dispatch_quads`] alone names them,
//! after it has detected the instructions that they need.

use core::ops::{Add, Mul};

/// Four numbers `T` in the registers of the instruction set that [`dispatch_quads`] chose.
pub trait Quad<T>: Copy + Add<Output = Self> + Mul<Output = Self> {
    /// The same number four times.
    fn splat(value: T) -> Self;
    /// From memory.
    fn load(from: &[T; 4]) -> Self;
    /// To memory.
    fn store(self, to: &mut [T; 4]);
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
impl<T: Copy + Add<Output = T>> Add for Plain<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
    }
}
impl<T: Copy + Mul<Output = T>> Mul for Plain<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let (a, b) = (self.0, o.0);
        Self([a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]])
    }
}
impl<T: Copy + Add<Output = T> + Mul<Output = T>> Quad<T> for Plain<T> {
    #[inline(always)]
    fn splat(value: T) -> Self {
        Self([value; 4])
    }
    #[inline(always)]
    fn load(from: &[T; 4]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn store(self, to: &mut [T; 4]) {
        *to = self.0;
    }
}

#[cfg(target_arch = "x86_64")]
#[cfg_attr(all(debug_assertions, not(test)), allow(dead_code))]
pub(super) mod x86 {
    use super::Quad;
    use core::arch::x86_64::*;
    use core::ops::{Add, Mul};

    macro_rules! quad {
        (
            $(#[$doc:meta])*
            $name:ident, $scalar:ty, [$register:ty; $count:literal], [$($i:tt)*], $width:literal,
            $set:path, $load:path, $store:path, $add:path, $mul:path
        ) => {
            $(#[$doc])*
            #[derive(Clone, Copy)]
            pub(in super::super) struct $name([$register; $count]);
            impl Add for $name {
                type Output = Self;
                #[inline(always)]
                fn add(self, o: Self) -> Self {
                    // SAFETY: see the module.
                    Self(unsafe { [$($add(self.0[$i], o.0[$i])),*] })
                }
            }
            impl Mul for $name {
                type Output = Self;
                #[inline(always)]
                fn mul(self, o: Self) -> Self {
                    // SAFETY: see the module.
                    Self(unsafe { [$($mul(self.0[$i], o.0[$i])),*] })
                }
            }
            impl Quad<$scalar> for $name {
                #[inline(always)]
                fn splat(value: $scalar) -> Self {
                    // SAFETY: see the module.
                    Self([unsafe { $set(value) }; $count])
                }
                #[inline(always)]
                fn load(from: &[$scalar; 4]) -> Self {
                    // SAFETY: see the module; each load reads numbers of the array.
                    Self(unsafe { [$($load(from.as_ptr().add($i * $width))),*] })
                }
                #[inline(always)]
                fn store(self, to: &mut [$scalar; 4]) {
                    // SAFETY: see the module; each store writes numbers of the array.
                    unsafe { $($store(to.as_mut_ptr().add($i * $width), self.0[$i]);)* }
                }
            }
        };
    }
    quad! {
        /// One AVX register.
        Avx, f64, [__m256d; 1], [0], 4,
        _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_mul_pd
    }
    quad! {
        /// Two SSE2 registers.
        Sse2, f64, [__m128d; 2], [0 1], 2,
        _mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_add_pd, _mm_mul_pd
    }
    quad! {
        /// One SSE register.
        Sse, f32, [__m128; 1], [0], 4,
        _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_add_ps, _mm_mul_ps
    }
}

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
