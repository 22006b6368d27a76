//! eˣ with its first Taylor terms removed, without the cancellation.

use fem_kinematics::{Real, vector};

/// 6/(k + 3)! for k = 17 … 0.
const SERIES: [f64; 18] = {
    let mut c = [1.0; 18];
    let mut k = 1;
    let mut value = 1.0;
    while k < 18 {
        value /= (k + 3) as f64;
        c[17 - k] = value;
        k += 1;
    }
    c
};

/// (eˣ − 1, eˣ − 1 − x, eˣ − 1 − x − x²/2) for x ≥ 0, each to relative rounding.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exponential_remainders<T: Real>(x: T) -> [T; 3] {
    let square_half = T::from_f64(0.5) * x * x;
    let large = T::one().le(x);
    let mut s = T::from_f64(SERIES[0]);
    for c in &SERIES[1..] {
        s = s * x + T::from_f64(*c);
    }
    let third = s * x * square_half * T::from_f64(1.0 / 3.0);
    let second = square_half + third;
    let near = [x + second, second, third];
    if !T::any(large) {
        return near;
    }
    let first = x.exp_m1();
    let far = [first, first - x, first - x - square_half];
    vector(|i| T::select(large, far[i], near[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joins_its_two_formulas() {
        let below = exponential_remainders(1.0_f64 - f64::EPSILON);
        let above = exponential_remainders(1.0_f64);
        for i in 0..3 {
            assert!((below[i] - above[i]).abs() < 3e-15, "{below:?} {above:?}");
        }
    }
    #[test]
    fn keeps_its_digits_near_zero() {
        let [a, b, c] = exponential_remainders(1e-9_f64);
        assert!((a / 1e-9 - 1.0).abs() < 1e-8);
        assert!((b / 0.5e-18 - 1.0).abs() < 1e-8);
        assert!((c / (1e-27 / 6.0) - 1.0).abs() < 1e-8);
    }
}
