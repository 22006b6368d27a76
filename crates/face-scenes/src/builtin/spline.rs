//! Natural cubic splines through a few control points.

/// A C2 curve through control points; beyond the ends it goes on straight.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    knots: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the knots.
    bend: Vec<f64>,
}

impl Spline {
    /// `points` are `(knot, value)` with ascending knots, at least two.
    pub fn new(points: &[[f64; 2]]) -> Self {
        let n = points.len();
        let knots: Vec<f64> = points.iter().map(|p| p[0]).collect();
        let values: Vec<f64> = points.iter().map(|p| p[1]).collect();
        // The tridiagonal system of the natural spline, by elimination.
        let mut bend = vec![0.0; n];
        let mut upper = vec![0.0; n];
        for i in 1..n.saturating_sub(1) {
            let (h0, h1) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
            let slope = (values[i + 1] - values[i]) / h1 - (values[i] - values[i - 1]) / h0;
            let pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
            upper[i] = h1 / pivot;
            bend[i] = (6.0 * slope - h0 * bend[i - 1]) / pivot;
        }
        for i in (1..n.saturating_sub(1)).rev() {
            bend[i] -= upper[i] * bend[i + 1];
        }
        Self {
            knots,
            values,
            bend,
        }
    }

    pub fn at(&self, x: f64) -> f64 {
        let n = self.knots.len();
        let i = self.knots[1..n - 1].partition_point(|&k| k <= x);
        let h = self.knots[i + 1] - self.knots[i];
        let inside = x.clamp(self.knots[0], self.knots[n - 1]);
        let (a, b) = (
            (self.knots[i + 1] - inside) / h,
            (inside - self.knots[i]) / h,
        );
        let value = a * self.values[i]
            + b * self.values[i + 1]
            + ((a * a * a - a) * self.bend[i] + (b * b * b - b) * self.bend[i + 1]) * h * h / 6.0;
        let slope = (self.values[i + 1] - self.values[i]) / h
            + ((1.0 - 3.0 * a * a) * self.bend[i] + (3.0 * b * b - 1.0) * self.bend[i + 1]) * h
                / 6.0;
        value + slope * (x - inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_through_its_points_and_is_smooth() {
        let s = Spline::new(&[[0.0, 1.0], [1.0, 3.0], [2.5, -1.0], [4.0, 0.0]]);
        for (x, y) in [(0.0, 1.0), (1.0, 3.0), (2.5, -1.0), (4.0, 0.0)] {
            assert!((s.at(x) - y).abs() < 1e-13);
        }
        let second = |x: f64| (s.at(x + 1e-3) - 2.0 * s.at(x) + s.at(x - 1e-3)) / 1e-6;
        for knot in [1.0, 2.5] {
            assert!((second(knot - 2e-3) - second(knot + 2e-3)).abs() < 0.2);
        }
        assert!((s.at(6.0) - s.at(5.0) - (s.at(5.0) - s.at(4.0))).abs() < 1e-12);
    }
}
