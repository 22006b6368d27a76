//! Runs a kernel with the widest vector instructions that this processor has.
//!
//! This is the one place with `unsafe`: a function compiled for AVX-512 or AVX2 may only be
//! called where the processor has it, which is checked here right before the call. Kernels stay
//! plain safe code; no fused multiply-add is ever formed, so the bits are the same on every path.
#![allow(unsafe_code)]

mod bits;
mod quad;
#[cfg(target_arch = "x86_64")]
#[cfg_attr(debug_assertions, allow(dead_code))]
mod registers;

pub(crate) use bits::Bits;
pub use quad::{Quad, QuadKernel, QuadScalar, dispatch_quads};

use crate::scalar::Real;
use std::sync::atomic::{AtomicBool, Ordering};

/// A computation to be compiled once for each instruction set.
///
/// Mark `run` (and all that it calls on lanes) `#[inline(always)]`, or it is compiled for the
/// baseline only and runs several times slower.
pub trait Kernel {
    /// What the computation returns.
    type Output;
    /// The computation.
    fn run(self) -> Self::Output;
}

/// Runs `kernel` with AVX-512, AVX2 or the baseline instructions, whichever is the widest here.
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
        fn with_avx512<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        #[target_feature(enable = "avx2")]
        fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        match widest() {
            // SAFETY: the features that the function was compiled for were just detected.
            InstructionSet::Avx512 => return unsafe { with_avx512(kernel) },
            // SAFETY: likewise.
            InstructionSet::Avx2 => return unsafe { with_avx2(kernel) },
            InstructionSet::Baseline => {}
        }
    }
    kernel.run()
}

/// Some of eight `f64` that lie side by side in memory: all or half of them in the registers of the
/// instruction set that [`dispatch_packed`] chose, or one, where it chose none.
pub trait Pack: Real {
    /// How many: eight, four or one.
    const WIDTH: usize;
    /// Those of the eight that begin with `first`, a multiple of [`Pack::WIDTH`].
    ///
    /// # Panics
    /// When it is 8 or more.
    fn load(eight: &[f64; 8], first: usize) -> Self;
    /// Back to their places.
    ///
    /// # Panics
    /// As [`Pack::load`].
    fn store(self, eight: &mut [f64; 8], first: usize);
}

impl Pack for f64 {
    const WIDTH: usize = 1;
    #[inline(always)]
    fn load(eight: &[f64; 8], first: usize) -> Self {
        eight[first]
    }
    #[inline(always)]
    fn store(self, eight: &mut [f64; 8], first: usize) {
        eight[first] = self;
    }
}

/// A computation on eight elements side by side, to be compiled once for each instruction set.
///
/// Where a [`Kernel`] that works on [`F64x8`](crate::F64x8) hopes that the compiler finds the vector
/// instructions (it gives up on long kernels), this one is made of them. For each `part` of
/// `0..8 / V::WIDTH` load with [`Pack::load`] from `part * V::WIDTH` on, compute with `V` as the
/// [`Real`], store with [`Pack::store`]. Mark `run` and what it calls `#[inline(always)]`.
///
/// ```
/// use fem_kinematics::{F64x8, Lanes, Pack, PackedKernel, dispatch_packed};
/// struct Logarithms<'a>(&'a mut [F64x8]);
/// impl PackedKernel for Logarithms<'_> {
///     type Output = ();
///     #[inline(always)]
///     fn run<V: Pack>(self) {
///         for x in self.0 {
///             for part in 0..8 / V::WIDTH {
///                 let first = part * V::WIDTH;
///                 V::load(&x.0, first).ln().store(&mut x.0, first);
///             }
///         }
///     }
/// }
/// let mut x = [Lanes([1.0; 8])];
/// dispatch_packed(Logarithms(&mut x));
/// assert_eq!(x[0], Lanes([0.0; 8]));
/// ```
pub trait PackedKernel {
    /// What the computation returns.
    type Output;
    /// Does it spend its time waiting for quotients and roots of which each needs the one before, as
    /// decompositions do? AVX2 then takes two registers side by side, nearly half again as fast. Without,
    /// it takes one, which is faster where many values are kept at once (AVX2 has sixteen registers), a
    /// little slower where few are, and compiles sooner.
    const WAITS: bool = false;
    /// The computation.
    fn run<V: Pack>(self) -> Self::Output;
    /// The computation where there are no such registers: number by number, or what gives the same bits
    /// from code that is there already.
    #[inline(always)]
    fn without_registers(self) -> Self::Output
    where
        Self: Sized,
    {
        self.run::<f64>()
    }
}

/// Runs `kernel` in the widest registers that this processor has, or number by number where it has
/// neither AVX-512 nor AVX2; the bits are the same.
#[inline]
pub fn dispatch_packed<K: PackedKernel>(kernel: K) -> K::Output {
    // Debug builds compile one way instead of three, twice as fast there as number by number.
    #[cfg(all(target_arch = "x86_64", debug_assertions))]
    return kernel.run::<registers::Sse2>();
    #[cfg(not(all(target_arch = "x86_64", debug_assertions)))]
    dispatch_registers(kernel)
}

/// [`dispatch_packed`] as release builds have it, in every build: for tests that compare its ways.
#[inline]
pub fn dispatch_registers<K: PackedKernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
        fn with_avx512<K: PackedKernel>(kernel: K) -> K::Output {
            kernel.run::<registers::Avx512>()
        }
        #[target_feature(enable = "avx2")]
        fn with_avx2<K: PackedKernel>(kernel: K) -> K::Output {
            if K::WAITS {
                kernel.run::<registers::Avx2Pair>()
            } else {
                kernel.run::<registers::Avx2>()
            }
        }
        match widest() {
            // SAFETY: the features that the function was compiled for were just detected.
            InstructionSet::Avx512 => return unsafe { with_avx512(kernel) },
            // SAFETY: likewise.
            InstructionSet::Avx2 => return unsafe { with_avx2(kernel) },
            InstructionSet::Baseline => {}
        }
    }
    kernel.without_registers()
}

#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InstructionSet {
    Avx512,
    Avx2,
    Baseline,
}

/// Is nothing wider wanted than what every processor has?
static PORTABLE: AtomicBool = AtomicBool::new(false);

/// From now on this process uses no instructions that it would have to look for (true), or again the
/// widest that are there: what other processors do, to be tested and timed on this one. Quadruples of
/// x86-64 stay in the registers that belong to each of them.
pub fn portable_only(yes: bool) {
    PORTABLE.store(yes, Ordering::Relaxed);
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn widest() -> InstructionSet {
    if PORTABLE.load(Ordering::Relaxed) {
        InstructionSet::Baseline
    } else if std::arch::is_x86_feature_detected!("avx512f")
        && std::arch::is_x86_feature_detected!("avx512dq")
        && std::arch::is_x86_feature_detected!("avx512vl")
        && std::arch::is_x86_feature_detected!("avx512bw")
    {
        InstructionSet::Avx512
    } else if std::arch::is_x86_feature_detected!("avx2") {
        InstructionSet::Avx2
    } else {
        InstructionSet::Baseline
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests;
