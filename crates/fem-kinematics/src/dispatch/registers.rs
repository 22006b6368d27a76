//! Eight `f64`, or four of them, in vector registers of a given kind.
//!
//! The compiler may or may not turn arrays of numbers into vector code: it does for short
//! kernels and gives up, silently, on long ones. These types leave it no choice.
//!
//! # Safety
//! The intrinsics need a processor with the instructions that they stand for. The types are
//! private, and [`super::dispatch_registers`] alone names them, after it has detected those
//! instructions; SSE2, which belongs to every x86-64 processor, is named by debug builds.

use super::Pack;
use super::bits::Bits;
use crate::mat::Mat;
use crate::math;
use crate::scalar::Real;
use crate::svd::{self, Svd};
use core::arch::x86_64::*;
use core::fmt::{self, Debug};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// An operation on all registers of one or two operands, written without closures: those would
/// stay outside the function that may use the instructions.
macro_rules! each {
    ($f:path, $a:expr, [$($i:tt)*]) => {
        // SAFETY: see the module.
        unsafe { [$($f($a[$i])),*] }
    };
    ($f:path, $a:expr, $b:expr, [$($i:tt)*]) => {
        // SAFETY: see the module.
        unsafe { [$($f($a[$i], $b[$i])),*] }
    };
}

macro_rules! pack {
    (
        $(#[$doc:meta])*
        $name:ident, $mask:ident, $register:ty, $mask_register:ty, [$($i:tt)*], $width:literal, $lanes:literal,
        set: $set:path, load: $load:path, store: $store:path,
        add: $add:path, sub: $sub:path, mul: $mul:path, div: $div:path, sqrt: $sqrt:path,
        lt: $lt:path, le: $le:path, select: $select:path, any: $any:path,
        mask_and: $mask_and:path, mask_or: $mask_or:path, mask_not: $mask_not:path,
        and: $and:path, or: $or:path, xor: $xor:path, plus: $plus:path, minus: $minus:path, times_low: $times_low:path,
        shifts: $shifts:ident, features: $features:literal,
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(super) struct $name([$register; $lanes / $width]);

        /// Its truth values.
        #[derive(Clone, Copy)]
        pub(super) struct $mask([$mask_register; $lanes / $width]);

        impl Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let mut eight = [0.0; 8];
                self.store(&mut eight, 0);
                eight[..Self::WIDTH].fmt(f)
            }
        }
        impl Default for $name {
            #[inline(always)]
            fn default() -> Self {
                Self::from_f64(0.0)
            }
        }
        pack!(@operator $name, Add, add, AddAssign, add_assign, $add, [$($i)*]);
        pack!(@operator $name, Sub, sub, SubAssign, sub_assign, $sub, [$($i)*]);
        pack!(@operator $name, Mul, mul, MulAssign, mul_assign, $mul, [$($i)*]);
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                Self(each!($div, self.0, other.0, [$($i)*]))
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                let sign = Self::from_f64(-0.0);
                Self(each!($xor, self.0, sign.0, [$($i)*]))
            }
        }
        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(each!($mask_and, self.0, other.0, [$($i)*]))
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(each!($mask_or, self.0, other.0, [$($i)*]))
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(each!($mask_not, self.0, [$($i)*]))
            }
        }
        impl Bits for $name {
            #[inline(always)]
            fn from_bits(bits: u64) -> Self {
                Self::from_f64(f64::from_bits(bits))
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                Self(each!($plus, self.0, other.0, [$($i)*]))
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                Self(each!($minus, self.0, other.0, [$($i)*]))
            }
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                Self(each!($and, self.0, other.0, [$($i)*]))
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                Self(each!($or, self.0, other.0, [$($i)*]))
            }
            #[inline(always)]
            fn right<const N: i32>(self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { [$($shifts::right::<N>(self.0[$i])),*] })
            }
            #[inline(always)]
            fn left<const N: i32>(self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { [$($shifts::left::<N>(self.0[$i])),*] })
            }
            #[inline(always)]
            fn times_low(self, other: Self) -> Self {
                Self(each!($times_low, self.0, other.0, [$($i)*]))
            }
        }
        impl Pack for $name {
            const WIDTH: usize = $lanes;
            #[inline(always)]
            fn load(eight: &[f64; 8], first: usize) -> Self {
                let part = &eight[first..first + $lanes];
                // SAFETY: see the module; each load reads numbers of the part.
                Self(unsafe { [$($load(part.as_ptr().add($i * $width))),*] })
            }
            #[inline(always)]
            fn store(self, eight: &mut [f64; 8], first: usize) {
                let part = &mut eight[first..first + $lanes];
                // SAFETY: see the module; each store writes numbers of the part.
                unsafe { $($store(part.as_mut_ptr().add($i * $width), self.0[$i]);)* }
            }
        }
        impl Real for $name {
            type Mask = $mask;
            const EPSILON: f64 = f64::EPSILON;
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                // SAFETY: see the module.
                Self([unsafe { $set(value) }; $lanes / $width])
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(each!($sqrt, self.0, [$($i)*]))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.and(<Self as Bits>::from_bits(!(1 << 63)))
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn ln(self) -> Self {
                math::ln(self)
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn ln_1p(self) -> Self {
                math::ln_1p(self)
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn exp(self) -> Self {
                math::exp(self)
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn exp_m1(self) -> Self {
                math::exp_m1(self)
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn powf(self, exponent: f64) -> Self {
                math::powf(self, exponent)
            }
            #[inline(always)]
            fn signed_svd<const D: usize>(F: &Mat<Self, D>) -> Svd<Self, D> {
                #[inline(never)]
                #[target_feature(enable = $features)]
                fn called<const D: usize>(F: &Mat<$name, D>) -> Svd<$name, D> {
                    svd::in_place(F)
                }
                // SAFETY: see the module.
                unsafe { called(F) }
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                $mask(each!($lt, self.0, other.0, [$($i)*]))
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                $mask(each!($le, self.0, other.0, [$($i)*]))
            }
            #[inline(always)]
            fn select(mask: $mask, if_true: Self, if_false: Self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { [$($select(mask.0[$i], if_true.0[$i], if_false.0[$i])),*] })
            }
            #[inline(always)]
            fn any(mask: $mask) -> bool {
                // SAFETY: see the module.
                unsafe { false $(| $any(mask.0[$i]))* }
            }
        }
    };
    (@operator $name:ident, $trait:ident, $method:ident, $assign:ident, $assign_method:ident, $f:path, [$($i:tt)*]) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(each!($f, self.0, other.0, [$($i)*]))
            }
        }
        impl $assign for $name {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    };
}

/// The operations of one AVX-512 register that have no intrinsic of the right shape.
mod avx512 {
    use core::arch::x86_64::*;

    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn lt(a: __m512d, b: __m512d) -> __mmask8 {
        _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn le(a: __m512d, b: __m512d) -> __mmask8 {
        _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b)
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn plus(a: __m512d, b: __m512d) -> __m512d {
        _mm512_castsi512_pd(_mm512_add_epi64(
            _mm512_castpd_si512(a),
            _mm512_castpd_si512(b),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn minus(a: __m512d, b: __m512d) -> __m512d {
        _mm512_castsi512_pd(_mm512_sub_epi64(
            _mm512_castpd_si512(a),
            _mm512_castpd_si512(b),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn times_low(a: __m512d, b: __m512d) -> __m512d {
        _mm512_castsi512_pd(_mm512_mul_epu32(
            _mm512_castpd_si512(a),
            _mm512_castpd_si512(b),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn right<const N: i32>(a: __m512d) -> __m512d {
        // The immediate form wants an unsigned constant; this one compiles to it.
        _mm512_castsi512_pd(_mm512_srl_epi64(
            _mm512_castpd_si512(a),
            _mm_cvtsi32_si128(N),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn left<const N: i32>(a: __m512d) -> __m512d {
        _mm512_castsi512_pd(_mm512_sll_epi64(
            _mm512_castpd_si512(a),
            _mm_cvtsi32_si128(N),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn select(mask: __mmask8, if_true: __m512d, if_false: __m512d) -> __m512d {
        _mm512_mask_blend_pd(mask, if_false, if_true)
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn any(mask: __mmask8) -> bool {
        mask != 0
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn mask_and(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn mask_or(a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
    pub(super) fn mask_not(a: __mmask8) -> __mmask8 {
        !a
    }
}

pack! {
    /// One AVX-512 register.
    Avx512, Avx512Mask, __m512d, __mmask8, [0], 8, 8,
    set: _mm512_set1_pd, load: _mm512_loadu_pd, store: _mm512_storeu_pd,
    add: _mm512_add_pd, sub: _mm512_sub_pd, mul: _mm512_mul_pd, div: _mm512_div_pd, sqrt: _mm512_sqrt_pd,
    lt: avx512::lt, le: avx512::le, select: avx512::select, any: avx512::any,
    mask_and: avx512::mask_and, mask_or: avx512::mask_or, mask_not: avx512::mask_not,
    and: _mm512_and_pd, or: _mm512_or_pd, xor: _mm512_xor_pd, plus: avx512::plus, minus: avx512::minus, times_low: avx512::times_low,
    shifts: avx512, features: "avx512f,avx512dq,avx512vl,avx512bw",
}

/// The operations of AVX2 registers that have no intrinsic of the right shape.
mod avx2 {
    use core::arch::x86_64::*;

    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn lt(a: __m256d, b: __m256d) -> __m256d {
        _mm256_cmp_pd::<_CMP_LT_OQ>(a, b)
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn le(a: __m256d, b: __m256d) -> __m256d {
        _mm256_cmp_pd::<_CMP_LE_OQ>(a, b)
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn plus(a: __m256d, b: __m256d) -> __m256d {
        _mm256_castsi256_pd(_mm256_add_epi64(
            _mm256_castpd_si256(a),
            _mm256_castpd_si256(b),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn minus(a: __m256d, b: __m256d) -> __m256d {
        _mm256_castsi256_pd(_mm256_sub_epi64(
            _mm256_castpd_si256(a),
            _mm256_castpd_si256(b),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn times_low(a: __m256d, b: __m256d) -> __m256d {
        _mm256_castsi256_pd(_mm256_mul_epu32(
            _mm256_castpd_si256(a),
            _mm256_castpd_si256(b),
        ))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn right<const N: i32>(a: __m256d) -> __m256d {
        _mm256_castsi256_pd(_mm256_srli_epi64::<N>(_mm256_castpd_si256(a)))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn left<const N: i32>(a: __m256d) -> __m256d {
        _mm256_castsi256_pd(_mm256_slli_epi64::<N>(_mm256_castpd_si256(a)))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn select(mask: __m256d, if_true: __m256d, if_false: __m256d) -> __m256d {
        _mm256_blendv_pd(if_false, if_true, mask)
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn any(mask: __m256d) -> bool {
        _mm256_movemask_pd(mask) != 0
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn mask_and(a: __m256d, b: __m256d) -> __m256d {
        _mm256_and_pd(a, b)
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn mask_or(a: __m256d, b: __m256d) -> __m256d {
        _mm256_or_pd(a, b)
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn mask_not(a: __m256d) -> __m256d {
        _mm256_xor_pd(a, _mm256_castsi256_pd(_mm256_set1_epi64x(-1)))
    }
}

/// One or more AVX2 registers.
macro_rules! avx2_pack {
    ($(#[$doc:meta])* $name:ident, $mask:ident, [$($i:tt)*], $lanes:literal) => {
        pack! {
            $(#[$doc])*
            $name, $mask, __m256d, __m256d, [$($i)*], 4, $lanes,
            set: _mm256_set1_pd, load: _mm256_loadu_pd, store: _mm256_storeu_pd,
            add: _mm256_add_pd, sub: _mm256_sub_pd, mul: _mm256_mul_pd, div: _mm256_div_pd, sqrt: _mm256_sqrt_pd,
            lt: avx2::lt, le: avx2::le, select: avx2::select, any: avx2::any,
            mask_and: avx2::mask_and, mask_or: avx2::mask_or, mask_not: avx2::mask_not,
            and: _mm256_and_pd, or: _mm256_or_pd, xor: _mm256_xor_pd, plus: avx2::plus, minus: avx2::minus, times_low: avx2::times_low,
            shifts: avx2, features: "avx2",
        }
    };
}

avx2_pack! {
    /// One AVX2 register.
    Avx2, Avx2Mask, [0], 4
}

avx2_pack! {
    /// Two AVX2 registers, for kernels whose operations wait for each other ([`super::PackedKernel::WAITS`]).
    Avx2Pair, Avx2PairMask, [0 1], 8
}

/// The operations of four SSE2 registers that have no intrinsic of the right shape.
#[cfg(any(test, debug_assertions))]
mod sse2 {
    use core::arch::x86_64::*;

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn lt(a: __m128d, b: __m128d) -> __m128d {
        _mm_cmplt_pd(a, b)
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn le(a: __m128d, b: __m128d) -> __m128d {
        _mm_cmple_pd(a, b)
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn plus(a: __m128d, b: __m128d) -> __m128d {
        _mm_castsi128_pd(_mm_add_epi64(_mm_castpd_si128(a), _mm_castpd_si128(b)))
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn minus(a: __m128d, b: __m128d) -> __m128d {
        _mm_castsi128_pd(_mm_sub_epi64(_mm_castpd_si128(a), _mm_castpd_si128(b)))
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn times_low(a: __m128d, b: __m128d) -> __m128d {
        _mm_castsi128_pd(_mm_mul_epu32(_mm_castpd_si128(a), _mm_castpd_si128(b)))
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn right<const N: i32>(a: __m128d) -> __m128d {
        _mm_castsi128_pd(_mm_srli_epi64::<N>(_mm_castpd_si128(a)))
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn left<const N: i32>(a: __m128d) -> __m128d {
        _mm_castsi128_pd(_mm_slli_epi64::<N>(_mm_castpd_si128(a)))
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn select(mask: __m128d, if_true: __m128d, if_false: __m128d) -> __m128d {
        _mm_or_pd(_mm_and_pd(mask, if_true), _mm_andnot_pd(mask, if_false))
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn any(mask: __m128d) -> bool {
        _mm_movemask_pd(mask) != 0
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn mask_and(a: __m128d, b: __m128d) -> __m128d {
        _mm_and_pd(a, b)
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn mask_or(a: __m128d, b: __m128d) -> __m128d {
        _mm_or_pd(a, b)
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn mask_not(a: __m128d) -> __m128d {
        _mm_xor_pd(a, _mm_castsi128_pd(_mm_set1_epi64x(-1)))
    }
}

#[cfg(any(test, debug_assertions))]
pack! {
    /// Four SSE2 registers, for debug builds.
    Sse2, Sse2Mask, __m128d, __m128d, [0 1 2 3], 2, 8,
    set: _mm_set1_pd, load: _mm_loadu_pd, store: _mm_storeu_pd,
    add: _mm_add_pd, sub: _mm_sub_pd, mul: _mm_mul_pd, div: _mm_div_pd, sqrt: _mm_sqrt_pd,
    lt: sse2::lt, le: sse2::le, select: sse2::select, any: sse2::any,
    mask_and: sse2::mask_and, mask_or: sse2::mask_or, mask_not: sse2::mask_not,
    and: _mm_and_pd, or: _mm_or_pd, xor: _mm_xor_pd, plus: sse2::plus, minus: sse2::minus, times_low: sse2::times_low,
    shifts: sse2, features: "sse2",
}
