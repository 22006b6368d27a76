//! Runs a kernel with the widest vector instructions that this processor has.
//!
//! This is the one place with `unsafe`: a function compiled for AVX-512 or AVX2 may only be
//! called where the processor has it, which is checked here right before the call. Kernels stay
//! plain safe code; no fused multiply-add is ever formed, so the bits are the same on every path.
#![allow(unsafe_code)]

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
        if std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512bw")
        {
            // SAFETY: the four features that the function was compiled for were just detected.
            return unsafe { with_avx512(kernel) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was just detected.
            return unsafe { with_avx2(kernel) };
        }
    }
    kernel.run()
}
