//! What the energy of a pair depends on: the gap and three shares, by six scalars, and their derivatives.
//!
//! With a = e₁·e₁, b = e₁·e₂, c = e₂·e₂, p = u·e₁, q = u·e₂, v = u·(e₁×e₂) and Δ = a c − b² all of them are
//! v/√Δ or quotients of forms with two products each.

use super::pair::{BAND, Kind, PARALLEL};

/// Of each of (gap, three shares), by (a, b, c, p, q, v).
pub(super) struct Measures {
    pub values: [f64; 4],
    pub slopes: [[f64; 6]; 4],
}

/// Second derivatives of the four.
pub(super) type Curvatures = [[[f64; 6]; 6]; 4];

/// ± sᵢ sⱼ ± sₖ sₗ.
struct Form([(usize, usize, f64); 2]);

/// Δ, c p − b q, a q − b p, a c.
const AREA: Form = Form([(0, 2, 1.0), (1, 1, -1.0)]);
const SECOND: Form = Form([(2, 3, 1.0), (1, 4, -1.0)]);
const THIRD: Form = Form([(0, 4, 1.0), (1, 3, -1.0)]);
const SQUARES: Form = Form([(0, 2, 1.0), (0, 2, 0.0)]);

impl Form {
    fn value(&self, s: &[f64; 6]) -> f64 {
        self.0.iter().map(|&(i, j, sign)| sign * s[i] * s[j]).sum()
    }
    fn slopes(&self, s: &[f64; 6]) -> [f64; 6] {
        let mut slopes = [0.0; 6];
        for (i, j, sign) in self.0 {
            slopes[i] += sign * s[j];
            slopes[j] += sign * s[i];
        }
        slopes
    }
    /// Adds so many times its second derivatives.
    fn add_curvatures(&self, times: f64, to: &mut [[f64; 6]; 6]) {
        for (i, j, sign) in self.0 {
            to[i][j] += times * sign;
            to[j][i] += times * sign;
        }
    }
}

/// N/M with its slopes.
struct Quotient {
    of: [Form; 2],
    value: f64,
    slopes: [f64; 6],
    below: f64,
    below_slopes: [f64; 6],
}

impl Quotient {
    fn new(of: [Form; 2], s: &[f64; 6]) -> Self {
        let [above, below] = [&of[0], &of[1]].map(|form| form.value(s));
        let [above_slopes, below_slopes] = [&of[0], &of[1]].map(|form| form.slopes(s));
        let value = above / below;
        let slope = |i: usize| (above_slopes[i] - value * below_slopes[i]) / below;
        Self {
            value,
            slopes: std::array::from_fn(slope),
            of,
            below,
            below_slopes,
        }
    }

    /// (N'' − q' M' − M' q' − q M'')/M.
    fn curvatures(&self) -> [[f64; 6]; 6] {
        let mut curvatures = both_ways(&self.slopes, &self.below_slopes, -1.0 / self.below);
        self.of[0].add_curvatures(1.0 / self.below, &mut curvatures);
        self.of[1].add_curvatures(-self.value / self.below, &mut curvatures);
        curvatures
    }
}

/// f (x yᵀ + y xᵀ).
fn both_ways(x: &[f64; 6], y: &[f64; 6], f: f64) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| f * (x[i] * y[j] + y[i] * x[j])))
}

fn gap_slopes(s: &[f64; 6]) -> (f64, [f64; 6]) {
    let area = AREA.value(s);
    let root = area.sqrt();
    let gap = s[5] / root;
    let mut slopes = AREA.slopes(s).map(|slope| -0.5 * gap * slope / area);
    slopes[5] += 1.0 / root;
    (gap, slopes)
}

/// −½ (g' Δ' + Δ' g' + g Δ'' − ½ g Δ' Δ'/Δ)/Δ.
fn gap_curvatures(s: &[f64; 6], gap: f64, slopes: &[f64; 6]) -> [[f64; 6]; 6] {
    let (area, by) = (AREA.value(s), AREA.slopes(s));
    let half = -0.5 / area;
    let shifted: [f64; 6] = std::array::from_fn(|i| slopes[i] - 0.25 * gap * by[i] / area);
    let mut curvatures = both_ways(&shifted, &by, half);
    AREA.add_curvatures(half * gap, &mut curvatures);
    curvatures
}

/// Which sign the gap has.
fn side(kind: Kind) -> f64 {
    if kind == Kind::EdgeAgainst { -1.0 } else { 1.0 }
}

impl Measures {
    pub fn new(kind: Kind, s: &[f64; 6]) -> Self {
        let (gap, slopes) = gap_slopes(s);
        let second = Quotient::new([SECOND, AREA], s);
        let third = Quotient::new([THIRD, AREA], s);
        let (first, shares, rows) = if kind == Kind::Point {
            let both = std::array::from_fn(|i| -second.slopes[i] - third.slopes[i]);
            let shares = [second.value, third.value];
            let rows = [second.slopes, third.slopes];
            ((1.0 - second.value - third.value, both), shares, rows)
        } else {
            let across = Quotient::new([AREA, SQUARES], s);
            let shares = [-third.value, across.value];
            let rows = [third.slopes.map(|t| -t), across.slopes];
            ((second.value, second.slopes), shares, rows)
        };
        let side = side(kind);
        Self {
            values: [side * gap, first.0, shares[0], shares[1]],
            slopes: [slopes.map(|g| side * g), first.1, rows[0], rows[1]],
        }
    }

    pub fn curvatures(&self, kind: Kind, s: &[f64; 6]) -> Curvatures {
        // The sign of the gap is that of its slopes.
        let gap = gap_curvatures(s, self.values[0], &self.slopes[0]);
        let second = Quotient::new([SECOND, AREA], s).curvatures();
        let third = Quotient::new([THIRD, AREA], s).curvatures();
        if kind == Kind::Point {
            let first =
                std::array::from_fn(|i| std::array::from_fn(|j| -second[i][j] - third[i][j]));
            [gap, first, second, third]
        } else {
            let across = Quotient::new([AREA, SQUARES], s).curvatures();
            [gap, second, third.map(|row| row.map(|x| -x)), across]
        }
    }
}

/// A function of one number with two derivatives.
pub(super) type Ramp = [f64; 3];

/// From 0 to 1 between 0 and 1, by z = (x − start)/length.
fn ramp(x: f64, start: f64, length: f64) -> Ramp {
    let z = (x - start) / length;
    if z <= 0.0 {
        return [0.0; 3];
    }
    if z >= 1.0 {
        return [1.0, 0.0, 0.0];
    }
    let rest = 1.0 - z;
    [
        z * z * z * (10.0 + z * (6.0 * z - 15.0)),
        30.0 * (z * rest) * (z * rest) / length,
        60.0 * z * rest * (1.0 - 2.0 * z) / (length * length),
    ]
}

fn product([f, df, ddf]: Ramp, [g, dg, ddg]: Ramp) -> Ramp {
    [f * g, df * g + f * dg, ddf * g + 2.0 * df * dg + f * ddg]
}

/// The windows that each of the three shares has.
pub(super) fn windows(kind: Kind, [_, first, second, third]: [f64; 4]) -> [Ramp; 3] {
    let window = |share: f64| ramp(share, -BAND, 2.0 * BAND);
    if kind == Kind::Point {
        return [first, second, third].map(window);
    }
    let both = |share: f64| {
        let [end, slope, bend] = window(1.0 - share);
        product(window(share), [end, -slope, bend])
    };
    let [low, high] = PARALLEL;
    [both(first), both(second), ramp(third, low, high - low)]
}
