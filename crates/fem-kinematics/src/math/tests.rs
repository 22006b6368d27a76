//! Against the standard library, whose functions are within an ulp.

fn ulps(a: f64, b: f64) -> f64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0;
    }
    (a.to_bits() as i64)
        .wrapping_sub(b.to_bits() as i64)
        .unsigned_abs() as f64
}

/// Points of every size in the open interval.
fn points(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let mut state = 1_u64;
    (0..40_000).map(move |i| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let t = (state >> 11) as f64 / (1_u64 << 53) as f64;
        if i % 2 == 0 {
            low + t * (high - low)
        } else {
            // Close to the end that is nearer to zero, down to tiny sizes.
            let size = 10f64.powf(-18.0 * t);
            if low < 0.0 && high > 0.0 {
                if i % 4 == 1 { low * size } else { high * size }
            } else {
                low + (high - low) * size
            }
        }
    })
}

fn worst(low: f64, high: f64, ours: impl Fn(f64) -> f64, theirs: impl Fn(f64) -> f64) -> f64 {
    let mut worst = 0.0;
    for x in points(low, high) {
        let error = ulps(ours(x), theirs(x));
        if error > worst || error.is_nan() {
            worst = error;
        }
    }
    worst
}

#[test]
fn within_an_ulp_or_two_of_the_standard_library() {
    for (low, high) in [
        (0.5, 2.0),
        (0.9, 1.1),
        (1e-300, 1e-290),
        (1e-3, 1e6),
        (1e-320, 1e-309),
        (1e200, 1e308),
    ] {
        let error = worst(low, high, super::ln, f64::ln);
        assert!(error <= 1.0, "ln in {low}..{high}: {error}");
    }
    for (low, high) in [
        (-0.999_999, 1.0),
        (-0.3, 0.45),
        (-1e-9, 1e-9),
        (1.0, 1e17),
        (1e17, 1e300),
    ] {
        let error = worst(low, high, super::ln_1p, f64::ln_1p);
        assert!(error <= 1.0, "ln_1p in {low}..{high}: {error}");
    }
    for (low, high) in [
        (-1.0, 1.0),
        (-700.0, 700.0),
        (-745.0, -708.0),
        (700.0, 709.7),
    ] {
        let error = worst(low, high, super::exp, f64::exp);
        assert!(error <= 1.0, "exp in {low}..{high}: {error}");
    }
    for (low, high) in [
        (-1.0, 1.0),
        (-0.4, 0.4),
        (-60.0, 60.0),
        (30.0, 709.7),
        (-1e-9, 1e-9),
    ] {
        let error = worst(low, high, super::exp_m1, f64::exp_m1);
        assert!(error <= 2.0, "exp_m1 in {low}..{high}: {error}");
    }
}

#[test]
fn powers() {
    let mut table = Vec::new();
    for p in [
        0.0_f64,
        -2.0 / 3.0,
        -1.0 / 3.0,
        1.0 / 3.0,
        2.0 / 3.0,
        -4.0 / 3.0,
        -5.0 / 3.0,
        -8.0 / 3.0,
        0.5,
        -0.5,
        1.7,
        -3.3,
        2.0,
        -1.0,
        3.0,
        11.2,
    ] {
        for (low, high) in [
            (0.5, 2.0),
            (1e-6, 1e6),
            (1e-25, 1e25),
            (1e-320, 1e-309),
            (1e-300, 1e-290),
        ] {
            // A third is meant exactly; the standard library takes the exponent as rounded.
            let third = (p * 3.0).round();
            let is_third = (p * 3.0 - third).abs() < 1e-15;
            let lost = if is_third {
                p.mul_add(-3.0, third) / 3.0
            } else {
                0.0
            };
            let expected = |x: f64| {
                let y = x.powf(p);
                if y.is_normal() {
                    y + y * lost * x.ln()
                } else {
                    y
                }
            };
            let error = worst(low, high, |x| super::powf::<f64>(x, p), expected);
            table.push((p, low, error));
        }
    }
    for (p, low, error) in table {
        assert!(
            error <= 2.0 + 2.0 * p.abs(),
            "x^{p} from {low}: {error} ulp"
        );
    }
    // The dual number's slope asks for this exponent, one ulp beside −5/3.
    assert!(ulps(super::powf(1.3, -2.0 / 3.0 - 1.0), 1.3_f64.powf(-5.0 / 3.0)) <= 3.0);
}

/// (a³)^(n/3) = aⁿ, exact in integers.
#[test]
fn every_third_that_is_a_product_of_roots() {
    for n in -24_i32..=24 {
        for a in [2.0_f64, 3.0, 5.0] {
            let p = f64::from(n) / 3.0;
            let (found, exact) = (super::powf(a * a * a, p), a.powi(n));
            let error = ulps(found, exact);
            assert!(
                error <= 2.0 + 2.0 * p.abs(),
                "{a}^{n}: {found:e}, {exact:e}"
            );
        }
    }
}

#[test]
fn limits() {
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    for x in [
        0.0,
        -0.0,
        1.0,
        -1.0,
        inf,
        -inf,
        nan,
        f64::MAX,
        5e-324,
        -5e-324,
        f64::MIN_POSITIVE,
    ] {
        assert_eq!(ulps(super::ln(x), x.ln()), 0.0, "ln {x}");
        assert_eq!(ulps(super::ln_1p(x), x.ln_1p()), 0.0, "ln_1p {x}");
        assert!(ulps(super::exp(x), x.exp()) <= 1.0, "exp {x}");
        assert!(
            ulps(super::exp_m1(x).abs(), x.exp_m1().abs()) <= 1.0,
            "exp_m1 {x}"
        );
        for p in [-1.0, 2.0, -2.0 / 3.0, 1.0 / 3.0, 0.3, -0.3] {
            if x < 0.0 && p * p < 1.0 {
                // A third is no odd root here: NaN, as in the formula exp(p ln x).
                assert!(super::powf(x, p).is_nan());
                continue;
            }
            if x.is_finite() && x != 0.0 && x != 1.0 && p * p < 0.5 && p * p > 0.1 {
                // For a third the exact one is meant: `powers` compares those.
                continue;
            }
            let (ours, theirs) = (super::powf(x, p), x.powf(p));
            assert!(
                ulps(ours.abs(), theirs.abs()) <= 1.0,
                "{x}^{p}: {ours} {theirs}"
            );
        }
    }
    for x in [710.0, 1e4, 1e300, -746.0, -1e300, -745.13] {
        assert!(ulps(super::exp(x), x.exp()) <= 1.0, "exp {x}");
        assert!(ulps(super::exp_m1(x), x.exp_m1()) <= 1.0, "exp_m1 {x}");
    }
    assert!(super::ln_1p(-1.5).is_nan());
}
