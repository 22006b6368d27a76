//! Elementary functions without branches or tables, on one `f64` or on packs of them.
//!
//! A call of libm's `ln` would stop vector code; these are plain arithmetic, bit operations and
//! selections. A lane has the same bits as the scalar, on every processor.
//! Reductions and coefficients of `ln`, `ln_1p`, `exp` and `exp_m1`: fdlibm 5.3 (Sun Microsystems
//! 1993, e_log.c, s_log1p.c, e_exp.c, s_expm1.c; "Permission to use, copy, modify, and distribute
//! this software is freely granted").

use crate::dispatch::Bits;

/// 33 leading bits of ln 2, so that k·LN2_HIGH is exact; LN2_LOW is the rest.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Bits of about √½, where the reduced mantissa begins.
const ROOT_HALF: u64 = 0x3fe6_a09e_0000_0000;
const ONE: u64 = 0x3ff0_0000_0000_0000;
/// 1.5·2⁵²: adding it rounds to an integer, which then stands in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// 2⁵⁴ lifts subnormal numbers into the normal range; it is the cube of 2¹⁸.
const LIFT: f64 = 18_014_398_509_481_984.0;

/// c₀ + c₁ x + c₂ x² + …
#[inline(always)]
fn polynomial<B: Bits, const N: usize>(x: B, c: [f64; N]) -> B {
    let mut sum = B::from_f64(c[N - 1]);
    for i in (0..N - 1).rev() {
        sum = sum * x + B::from_f64(c[i]);
    }
    sum
}

#[inline(always)]
fn is<B: Bits>(x: B, value: f64) -> B::Mask {
    x.le(B::from_f64(value)) & B::from_f64(value).le(x)
}

/// x lifted out of the subnormal range, and where that was needed.
#[inline(always)]
fn lift<B: Bits>(x: B) -> (B, B::Mask) {
    let subnormal = x.lt(B::from_f64(f64::MIN_POSITIVE));
    (B::select(subnormal, x * B::from_f64(LIFT), x), subnormal)
}

/// x = 2ᵏ m with m in [√½, √2), for normal positive x.
#[inline(always)]
fn split<B: Bits>(x: B) -> (B, B) {
    let shifted = x.plus(B::from_bits(ONE - ROOT_HALF));
    let m = shifted
        .and(B::from_bits((1 << 52) - 1))
        .plus(B::from_bits(ROOT_HALF));
    // The exponent as the low bits of a number near 2⁵²: AVX2 converts no 64-bit integers.
    let k = shifted.right::<52>().or(B::from_bits(0x4330 << 48))
        - B::from_f64(4_503_599_627_370_496.0 + 1023.0);
    (k, m)
}

/// [`split`] of any positive number.
#[inline(always)]
fn split_lifted<B: Bits>(x: B) -> (B, B) {
    let (lifted, subnormal) = lift(x);
    let (k, m) = split(lifted);
    let zero = B::zero();
    (k - B::select(subnormal, B::from_f64(54.0), zero), m)
}

/// ln(1 + f) = f − f²/2 + correction: returns f²/2 and the correction.
#[inline(always)]
fn ln_series<B: Bits>(f: B) -> (B, B) {
    let s = f / (B::from_f64(2.0) + f);
    let z = s * s;
    let w = z * z;
    let even = w * polynomial(
        w,
        [
            0.399_999_999_994_094_2,
            0.222_221_984_321_497_84,
            0.153_138_376_992_093_73,
        ],
    );
    let odd = z * polynomial(
        w,
        [
            0.666_666_666_666_673_5,
            0.285_714_287_436_623_9,
            0.181_835_721_616_180_5,
            0.147_981_986_051_165_86,
        ],
    );
    let half_square = B::from_f64(0.5) * f * f;
    (half_square, s * (half_square + (even + odd)))
}

/// −∞ at 0, NaN below, x itself for ∞ and NaN.
#[inline(always)]
fn ln_limits<B: Bits>(x: B, y: B) -> B {
    let y = B::select(x.lt(B::from_f64(f64::INFINITY)), y, x);
    let y = B::select(is(x, 0.0), B::from_f64(f64::NEG_INFINITY), y);
    B::select(x.lt(B::zero()), B::from_f64(f64::NAN), y)
}

/// Natural logarithm, error below 1 ulp.
#[inline(always)]
pub(crate) fn ln<B: Bits>(x: B) -> B {
    let (k, m) = split_lifted(x);
    let f = m - B::one();
    let (half_square, correction) = ln_series(f);
    let tail = half_square - (correction + k * B::from_f64(LN2_LOW));
    ln_limits(x, k * B::from_f64(LN2_HIGH) - (tail - f))
}

/// ln(1 + x), error below 1 ulp.
#[inline(always)]
pub(crate) fn ln_1p<B: Bits>(x: B) -> B {
    let one = B::one();
    let u = one + x;
    let (k, m) = split(u);
    let near = is(k, 0.0);
    // What rounding 1 + x lost, relative to u.
    let large = B::from_f64(2.0).le(k);
    let lost = B::select(large, one - (u - x), x - (u - one)) / u;
    let c = B::select(near, B::zero(), lost);
    let f = B::select(near, x, m - one);
    let (half_square, correction) = ln_series(f);
    let tail = half_square - (correction + (k * B::from_f64(LN2_LOW) + c));
    ln_limits(u, k * B::from_f64(LN2_HIGH) - (tail - f))
}

/// 2ᵏ for an integer k in −1022 … 1023.
#[inline(always)]
fn power_of_two<B: Bits>(k: B) -> B {
    (k + B::from_f64(ROUNDER))
        .plus(B::from_bits(1023))
        .left::<52>()
}

/// 2ᵏ x for an integer |k| ≤ 1100, in two steps for the ends of the range.
#[inline(always)]
fn scale<B: Bits>(x: B, k: B) -> B {
    let rounder = B::from_f64(ROUNDER);
    let half = (k * B::from_f64(0.5) + rounder) - rounder;
    x * power_of_two(half) * power_of_two(k - half)
}

/// x between two bounds; NaN stays NaN.
#[inline(always)]
fn clamp<B: Bits>(x: B, low: f64, high: f64) -> B {
    let (low, high) = (B::from_f64(low), B::from_f64(high));
    B::select(x.lt(low), low, B::select(high.lt(x), high, x))
}

/// x = k ln 2 + (high − low): k, high, low.
#[inline(always)]
fn reduce<B: Bits>(x: B) -> (B, B, B) {
    let rounder = B::from_f64(ROUNDER);
    let k = (x * B::from_f64(core::f64::consts::LOG2_E) + rounder) - rounder;
    (k, x - k * B::from_f64(LN2_HIGH), k * B::from_f64(LN2_LOW))
}

/// Exponential, error below 1 ulp.
#[inline(always)]
pub(crate) fn exp<B: Bits>(x: B) -> B {
    exp_of_sum(x, B::zero())
}

/// exp(x + tail) for a tail below an ulp or two of x.
#[inline(always)]
fn exp_of_sum<B: Bits>(x: B, tail: B) -> B {
    let (k, high, low) = reduce(clamp(x, -746.0, 710.0));
    let low = low - tail;
    let r = high - low;
    let t = r * r;
    let c = r - t * polynomial(
        t,
        [
            0.166_666_666_666_666_02,
            -2.777_777_777_701_559_3e-3,
            6.613_756_321_437_934e-5,
            -1.653_390_220_546_525_2e-6,
            4.138_136_797_057_238_5e-8,
        ],
    );
    let quotient = r * c / (B::from_f64(2.0) - c);
    scale(B::one() + (quotient - low + high), k)
}

/// exp(x) − 1, error below 1.5 ulp.
#[inline(always)]
pub(crate) fn exp_m1<B: Bits>(x: B) -> B {
    let (k, high, low) = reduce(clamp(x, -50.0, 710.0));
    let r = high - low;
    let c = (high - r) - low;
    let half = B::from_f64(0.5) * r;
    let square = r * half;
    let r1 = polynomial(
        square,
        [
            1.0,
            -3.333_333_333_333_313e-2,
            1.587_301_587_254_814_6e-3,
            -7.936_507_578_674_88e-5,
            4.008_217_827_329_362e-6,
            -2.010_992_181_836_243_7e-7,
        ],
    );
    let t = B::from_f64(3.0) - r1 * half;
    let e = square * ((r1 - t) / (B::from_f64(6.0) - r * t));
    let e = r * (e - c) - c - square;
    // 2ᵏ (1 + r − e) − 1 = 2ᵏ ((r + (1 − 2⁻ᵏ)) − e); beyond 2⁶⁰ the 1 no longer counts.
    let shift = B::one() - power_of_two(-clamp(k, -80.0, 60.0));
    scale((r + shift) - e, k)
}

/// x^(−1/3) and x^(−2/3) of a positive normal number, error below 1.5 ulp: no division.
#[inline(always)]
fn inverse_cube_roots<B: Bits>(x: B) -> (B, B) {
    let one = B::one();
    // A third of the exponent, negated, good for 5 %. The upper word alone, for there is no
    // 64-bit high product in SIMD; 0x5555_5556 is 2³²/3, rounded up.
    let third = x
        .right::<32>()
        .times_low(B::from_bits(0x5555_5556))
        .right::<32>();
    let y = B::from_bits(0x553e_f0ff).minus(third).left::<32>();
    // Fourth order: (1 − h)^(−1/3) = 1 + h/3 + 2h²/9 + 14h³/81 + … with 1 − h = x y³.
    let h = one - x * y * y * y;
    let y = y + y * (h * polynomial(h, [1.0 / 3.0, 2.0 / 9.0, 14.0 / 81.0]));
    // Of 26 bits the square is exact, and so are the leading parts of both results.
    let y = y.and(B::from_bits(!((1 << 27) - 1)));
    let square = y * y;
    let h = one - x * square * y;
    (
        y + y * (h * polynomial(h, [1.0 / 3.0, 2.0 / 9.0, 14.0 / 81.0, 35.0 / 243.0])),
        square + square * (h * polynomial(h, [2.0 / 3.0, 5.0 / 9.0, 40.0 / 81.0, 110.0 / 243.0])),
    )
}

/// x to the power n/3.
#[inline(always)]
fn power_of_third<B: Bits>(x: B, n: i32) -> B {
    let (lifted, subnormal) = lift(x);
    let (y, z) = inverse_cube_roots(lifted);
    let root = B::select(subnormal, B::from_f64(262_144.0), B::one());
    let (y, z) = (y * root, z * (root * root));
    let finite = match n {
        -1 => y,
        -2 => z,
        -4 => z * z,
        -5 => z * z * y,
        1 => x * z,
        2 => x * y,
        4 => x * (x * z),
        _ if n < 0 => integer_power(z, -n / 2) * if n % 2 == 0 { B::one() } else { y },
        _ if n % 3 == 2 => integer_power(x, n / 3 + 1) * y,
        _ => integer_power(x, n / 3 + 1) * z,
    };
    power_limits(x, finite, f64::from(n))
}

#[inline(always)]
fn power_limits<B: Bits>(x: B, finite: B, p: f64) -> B {
    let (zero, infinity) = (B::zero(), B::from_f64(f64::INFINITY));
    let (at_zero, at_infinity) = if p < 0.0 {
        (infinity, zero)
    } else {
        (zero, infinity)
    };
    let y = B::select(x.lt(infinity), finite, at_infinity);
    let y = B::select(is(x, 0.0), at_zero, y);
    B::select(zero.le(x), y, B::from_f64(f64::NAN))
}

#[inline(always)]
fn integer_power<B: Bits>(x: B, n: i32) -> B {
    let mut result = B::one();
    let (mut base, mut rest) = (x, n.unsigned_abs());
    while rest > 0 {
        if rest & 1 == 1 {
            result *= base;
        }
        base *= base;
        rest >>= 1;
    }
    if n < 0 { result.recip() } else { result }
}

/// v in two parts of 26 bits (Veltkamp).
#[inline(always)]
fn halves<B: Bits>(v: B) -> (B, B) {
    let c = v * B::from_f64(134_217_729.0);
    let h = c - (c - v);
    (h, v - h)
}

/// x to a constant power p: products for small integers and thirds, else exp(p ln x) with the
/// logarithm in two parts; error below (2 + 2|p|) ulp.
///
/// An exponent that is a third but for rounding is taken for that third.
#[inline(always)]
pub(crate) fn powf<B: Bits>(x: B, p: f64) -> B {
    // Decided on the exponent, which all lanes share.
    let thirds = p * 3.0;
    let nearest = (thirds + ROUNDER) - ROUNDER;
    if (thirds - nearest).abs() <= 4e-16 * nearest.abs() && nearest.abs() <= 24.0 {
        let n = nearest as i32;
        return if n % 3 == 0 {
            integer_power(x, n / 3)
        } else {
            power_of_third(x, n)
        };
    }
    let (k, m) = split_lifted(x);
    let f = m - B::one();
    let (half_square, correction) = ln_series(f);
    let large = k * B::from_f64(LN2_HIGH);
    let small = f - (half_square - (correction + k * B::from_f64(LN2_LOW)));
    let high = large + small;
    let low = (large - high) + small;
    // p · high without rounding (Dekker's product; the baseline has no fused operation).
    let exponent = B::from_f64(p);
    let product = exponent * high;
    let ((a, b), (c, d)) = (halves(exponent), halves(high));
    let error = ((a * c - product) + a * d + b * c) + b * d;
    power_limits(x, exp_of_sum(product, error + exponent * low), p)
}

/// The same for one `f64`, as functions to be called: inlined wherever an `f64` or an array of
/// lanes takes a logarithm they would multiply the size, and the compile time, of every kernel.
pub(crate) mod scalar {
    /// [`super::ln`].
    #[inline]
    pub(crate) fn ln(x: f64) -> f64 {
        super::ln(x)
    }
    /// [`super::ln_1p`].
    #[inline]
    pub(crate) fn ln_1p(x: f64) -> f64 {
        super::ln_1p(x)
    }
    /// [`super::exp`].
    #[inline]
    pub(crate) fn exp(x: f64) -> f64 {
        super::exp(x)
    }
    /// [`super::exp_m1`].
    #[inline]
    pub(crate) fn exp_m1(x: f64) -> f64 {
        super::exp_m1(x)
    }
    /// [`super::powf`].
    #[inline]
    pub(crate) fn powf(x: f64, p: f64) -> f64 {
        super::powf(x, p)
    }
}

#[cfg(test)]
mod tests;
