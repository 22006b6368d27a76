//! Quadruples in the registers of x86-64.
//!
//! # Safety
//! As in [`crate::dispatch::registers`]: the types are private, and [`super::dispatch_quads`] alone
//! names them, after it has detected the instructions that they need.

use super::Quad;
use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Sub};

/// What the macro below cannot write for all kinds alike.
trait Shape<T>: Sized {
    fn load_three(from: &[T; 3]) -> Self;
    fn store_three(self, to: &mut [T; 3]);
    fn floor(self) -> Self;
    fn to_integers(self) -> [i32; 4];
    fn all_at_most(self, other: Self) -> bool;
    fn transposed(rows: [Self; 4]) -> [Self; 4];
}

macro_rules! quad {
    (
        $(#[$doc:meta])*
        $name:ident, $scalar:ty, [$register:ty; $count:literal], [$($i:tt)*], $width:literal,
        $set:path, $load:path, $store:path, $add:path, $sub:path, $mul:path, $div:path,
        $max:path, $and_not:path
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(in super::super) struct $name([$register; $count]);
        quad!(operator $name, [$($i)*], Add, add, $add);
        quad!(operator $name, [$($i)*], Sub, sub, $sub);
        quad!(operator $name, [$($i)*], Mul, mul, $mul);
        quad!(operator $name, [$($i)*], Div, div, $div);
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
            fn load_three(from: &[$scalar; 3]) -> Self {
                Shape::load_three(from)
            }
            #[inline(always)]
            fn store(self, to: &mut [$scalar; 4]) {
                // SAFETY: see the module; each store writes numbers of the array.
                unsafe { $($store(to.as_mut_ptr().add($i * $width), self.0[$i]);)* }
            }
            #[inline(always)]
            fn store_three(self, to: &mut [$scalar; 3]) {
                Shape::store_three(self, to);
            }
            #[inline(always)]
            fn floor(self) -> Self {
                Shape::floor(self)
            }
            #[inline(always)]
            fn to_integers(self) -> [i32; 4] {
                Shape::to_integers(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { [$($and_not($set(-0.0), self.0[$i])),*] })
            }
            #[inline(always)]
            fn max(self, o: Self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { [$($max(self.0[$i], o.0[$i])),*] })
            }
            #[inline(always)]
            fn all_at_most(self, other: Self) -> bool {
                Shape::all_at_most(self, other)
            }
            #[inline(always)]
            fn transposed(rows: [Self; 4]) -> [Self; 4] {
                Shape::transposed(rows)
            }
        }
    };
    (operator $name:ident, [$($i:tt)*], $trait:ident, $function:ident, $intrinsic:path) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $function(self, o: Self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { [$($intrinsic(self.0[$i], o.0[$i])),*] })
            }
        }
    };
}

quad! {
    /// One AVX register.
    Avx, f64, [__m256d; 1], [0], 4,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_sub_pd,
    _mm256_mul_pd, _mm256_div_pd, _mm256_max_pd, _mm256_andnot_pd
}
quad! {
    /// Two SSE2 registers.
    Sse2, f64, [__m128d; 2], [0 1], 2,
    _mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_add_pd, _mm_sub_pd,
    _mm_mul_pd, _mm_div_pd, _mm_max_pd, _mm_andnot_pd
}
quad! {
    /// One SSE register.
    Sse, f32, [__m128; 1], [0], 4,
    _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_add_ps, _mm_sub_ps,
    _mm_mul_ps, _mm_div_ps, _mm_max_ps, _mm_andnot_ps
}

// SAFETY of the blocks below: see the module; what is read and written lies in the arrays.
impl Shape<f64> for Avx {
    #[inline(always)]
    fn load_three(from: &[f64; 3]) -> Self {
        // SAFETY: as said above; a masked load does not touch what its mask leaves out.
        Self([unsafe { _mm256_maskload_pd(from.as_ptr(), _mm256_setr_epi64x(-1, -1, -1, 0)) }])
    }
    #[inline(always)]
    fn store_three(self, to: &mut [f64; 3]) {
        // SAFETY: as said above.
        unsafe {
            _mm_storeu_pd(to.as_mut_ptr(), _mm256_castpd256_pd128(self.0[0]));
            _mm_store_sd(
                to.as_mut_ptr().add(2),
                _mm256_extractf128_pd::<1>(self.0[0]),
            );
        }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: as said above.
        Self([unsafe { _mm256_floor_pd(self.0[0]) }])
    }
    #[inline(always)]
    fn to_integers(self) -> [i32; 4] {
        let mut integers = [0; 4];
        // SAFETY: as said above.
        unsafe {
            _mm_storeu_si128(integers.as_mut_ptr().cast(), _mm256_cvttpd_epi32(self.0[0]));
        }
        integers
    }
    #[inline(always)]
    fn all_at_most(self, other: Self) -> bool {
        // SAFETY: as said above.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0[0], other.0[0])) == 0b1111 }
    }
    #[inline(always)]
    fn transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: as said above.
        unsafe {
            let (even, odd) = (
                [
                    _mm256_unpacklo_pd(a.0[0], b.0[0]),
                    _mm256_unpacklo_pd(c.0[0], d.0[0]),
                ],
                [
                    _mm256_unpackhi_pd(a.0[0], b.0[0]),
                    _mm256_unpackhi_pd(c.0[0], d.0[0]),
                ],
            );
            [
                Self([_mm256_permute2f128_pd::<0x20>(even[0], even[1])]),
                Self([_mm256_permute2f128_pd::<0x20>(odd[0], odd[1])]),
                Self([_mm256_permute2f128_pd::<0x31>(even[0], even[1])]),
                Self([_mm256_permute2f128_pd::<0x31>(odd[0], odd[1])]),
            ]
        }
    }
}

impl Shape<f64> for Sse2 {
    #[inline(always)]
    fn load_three(from: &[f64; 3]) -> Self {
        // SAFETY: as said above.
        Self(unsafe {
            [
                _mm_loadu_pd(from.as_ptr()),
                _mm_load_sd(from.as_ptr().add(2)),
            ]
        })
    }
    #[inline(always)]
    fn store_three(self, to: &mut [f64; 3]) {
        // SAFETY: as said above.
        unsafe {
            _mm_storeu_pd(to.as_mut_ptr(), self.0[0]);
            _mm_store_sd(to.as_mut_ptr().add(2), self.0[1]);
        }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        #[inline(always)]
        fn half(x: __m128d) -> __m128d {
            // SAFETY: SSE2 is part of x86-64.
            unsafe {
                let truncated = _mm_cvtepi32_pd(_mm_cvttpd_epi32(x));
                let above = _mm_cmpgt_pd(truncated, x);
                _mm_sub_pd(truncated, _mm_and_pd(above, _mm_set1_pd(1.0)))
            }
        }
        Self([half(self.0[0]), half(self.0[1])])
    }
    #[inline(always)]
    fn to_integers(self) -> [i32; 4] {
        let mut integers = [0; 4];
        // SAFETY: as said above.
        unsafe {
            let (low, high) = (_mm_cvttpd_epi32(self.0[0]), _mm_cvttpd_epi32(self.0[1]));
            _mm_storeu_si128(integers.as_mut_ptr().cast(), _mm_unpacklo_epi64(low, high));
        }
        integers
    }
    #[inline(always)]
    fn all_at_most(self, other: Self) -> bool {
        // SAFETY: as said above.
        unsafe {
            let low = _mm_cmple_pd(self.0[0], other.0[0]);
            let high = _mm_cmple_pd(self.0[1], other.0[1]);
            _mm_movemask_pd(_mm_and_pd(low, high)) == 0b11
        }
    }
    #[inline(always)]
    fn transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: as said above.
        unsafe {
            [
                Self([
                    _mm_unpacklo_pd(a.0[0], b.0[0]),
                    _mm_unpacklo_pd(c.0[0], d.0[0]),
                ]),
                Self([
                    _mm_unpackhi_pd(a.0[0], b.0[0]),
                    _mm_unpackhi_pd(c.0[0], d.0[0]),
                ]),
                Self([
                    _mm_unpacklo_pd(a.0[1], b.0[1]),
                    _mm_unpacklo_pd(c.0[1], d.0[1]),
                ]),
                Self([
                    _mm_unpackhi_pd(a.0[1], b.0[1]),
                    _mm_unpackhi_pd(c.0[1], d.0[1]),
                ]),
            ]
        }
    }
}

impl Shape<f32> for Sse {
    #[inline(always)]
    fn load_three(from: &[f32; 3]) -> Self {
        // SAFETY: as said above.
        Self([unsafe {
            let two = _mm_castpd_ps(_mm_load_sd(from.as_ptr().cast()));
            _mm_movelh_ps(two, _mm_load_ss(from.as_ptr().add(2)))
        }])
    }
    #[inline(always)]
    fn store_three(self, to: &mut [f32; 3]) {
        // SAFETY: as said above.
        unsafe {
            _mm_store_sd(to.as_mut_ptr().cast(), _mm_castps_pd(self.0[0]));
            _mm_store_ss(to.as_mut_ptr().add(2), _mm_movehl_ps(self.0[0], self.0[0]));
        }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: as said above.
        Self([unsafe {
            let truncated = _mm_cvtepi32_ps(_mm_cvttps_epi32(self.0[0]));
            let above = _mm_cmpgt_ps(truncated, self.0[0]);
            _mm_sub_ps(truncated, _mm_and_ps(above, _mm_set1_ps(1.0)))
        }])
    }
    #[inline(always)]
    fn to_integers(self) -> [i32; 4] {
        let mut integers = [0; 4];
        // SAFETY: as said above.
        unsafe {
            _mm_storeu_si128(integers.as_mut_ptr().cast(), _mm_cvttps_epi32(self.0[0]));
        }
        integers
    }
    #[inline(always)]
    fn all_at_most(self, other: Self) -> bool {
        // SAFETY: as said above.
        unsafe { _mm_movemask_ps(_mm_cmple_ps(self.0[0], other.0[0])) == 0b1111 }
    }
    #[inline(always)]
    fn transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: as said above.
        unsafe {
            let (mut a, mut b, mut c, mut d) = (a.0[0], b.0[0], c.0[0], d.0[0]);
            _MM_TRANSPOSE4_PS(&mut a, &mut b, &mut c, &mut d);
            [Self([a]), Self([b]), Self([c]), Self([d])]
        }
    }
}
