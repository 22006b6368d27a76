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

use crate::lanes::F64x8;
use crate::scalar::Real;

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

/// Eight `f64` in the registers of the instruction set that [`dispatch_packed`] chose.
pub trait Pack: Real {
    /// From memory.
    fn from_lanes(lanes: F64x8) -> Self;
    /// To memory.
    fn to_lanes(self) -> F64x8;
}

impl Pack for F64x8 {
    #[inline(always)]
    fn from_lanes(lanes: F64x8) -> Self {
        lanes
    }
    #[inline(always)]
    fn to_lanes(self) -> F64x8 {
        self
    }
}

/// A computation on eight elements side by side, to be compiled once for each instruction set.
///
/// Where a [`Kernel`] that works on [`F64x8`] hopes that the compiler finds the vector
/// instructions (it gives up on long kernels), this one is made of them. Load with
/// [`Pack::from_lanes`], compute with `V` as the [`Real`], store with [`Pack::to_lanes`]. Mark
/// `run` and what it calls `#[inline(always)]`.
///
/// ```
/// use fem_kinematics::{F64x8, Lanes, Pack, PackedKernel, dispatch_packed};
/// struct Logarithms<'a>(&'a mut [F64x8]);
/// impl PackedKernel for Logarithms<'_> {
///     type Output = ();
///     #[inline(always)]
///     fn run<V: Pack>(self) {
///         for x in self.0 {
///             *x = V::from_lanes(*x).ln().to_lanes();
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
    /// The computation.
    fn run<V: Pack>(self) -> Self::Output;
}

/// Runs `kernel` in the widest registers that this processor has; the bits are the same in all.
#[inline]
pub fn dispatch_packed<K: PackedKernel>(kernel: K) -> K::Output {
    // Debug builds compile one register type instead of three; the bits are the same.
    #[cfg(all(target_arch = "x86_64", debug_assertions))]
    return kernel.run::<registers::Sse2>();
    #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
    {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
        fn with_avx512<K: PackedKernel>(kernel: K) -> K::Output {
            kernel.run::<registers::Avx512>()
        }
        #[target_feature(enable = "avx2")]
        fn with_avx2<K: PackedKernel>(kernel: K) -> K::Output {
            kernel.run::<registers::Avx2>()
        }
        match widest() {
            // SAFETY: the features that the function was compiled for were just detected.
            InstructionSet::Avx512 => unsafe { with_avx512(kernel) },
            // SAFETY: likewise.
            InstructionSet::Avx2 => unsafe { with_avx2(kernel) },
            InstructionSet::Baseline => kernel.run::<registers::Sse2>(),
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    kernel.run::<F64x8>()
}

#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InstructionSet {
    Avx512,
    Avx2,
    Baseline,
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn widest() -> InstructionSet {
    if std::arch::is_x86_feature_detected!("avx512f")
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
