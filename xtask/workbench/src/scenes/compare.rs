//! Comparisons of fields, as errors relative to the largest entry or absolute.

use crate::numbers::worse;
use crate::report::Report;

/// Tolerance of energies, relative; this and the others are those that the scenes' notes suggest.
pub const ENERGY: f64 = 1e-11;
/// Of positions, meters.
pub const POSITION: f64 = 1e-9;
/// Of forces, of the largest.
pub const FORCE: f64 = 1e-11;
/// Of a Jacobian's column, of its largest entry.
pub const COLUMN: f64 = 1e-8;
/// Of θ and residual norms along a fit.
pub const PATH: f64 = 1e-9;

/// Where results of one scene go.
pub struct Record<'a> {
    /// The book.
    pub report: &'a mut Report,
    /// `scene a0`, …
    pub scene: &'a str,
    /// Material, variant, …
    pub category: String,
    /// Which case.
    pub id: String,
}

impl Record<'_> {
    /// Any error against a bound.
    pub fn error(&mut self, quantity: &str, error: f64, bound: f64) {
        self.report
            .record(self.scene, quantity, &self.category, &self.id, error, bound);
    }

    /// A number, relative.
    pub fn relative(&mut self, quantity: &str, got: f64, exact: f64, bound: f64) {
        self.error(quantity, (got - exact).abs() / exact.abs(), bound);
    }

    /// Vectors over nodes, relative to the largest entry.
    pub fn of_largest(&mut self, quantity: &str, got: &[[f64; 3]], exact: &[[f64; 3]], bound: f64) {
        self.error(quantity, apart(got, exact) / largest(exact), bound);
    }

    /// Vectors over nodes, absolute.
    pub fn absolute(&mut self, quantity: &str, got: &[[f64; 3]], exact: &[[f64; 3]], bound: f64) {
        self.error(quantity, apart(got, exact), bound);
    }
}

/// The largest |entry|; NaN where one is NaN.
pub fn largest(field: &[[f64; 3]]) -> f64 {
    field
        .as_flattened()
        .iter()
        .fold(0.0, |m, x| worse(m, x.abs()))
}

/// The largest |difference|; NaN where one is NaN or the lengths differ.
pub fn apart(got: &[[f64; 3]], exact: &[[f64; 3]]) -> f64 {
    largest_difference(got.as_flattened(), exact.as_flattened())
}

/// The largest |difference|; NaN where one is NaN or the lengths differ.
pub fn largest_difference(got: &[f64], exact: &[f64]) -> f64 {
    if got.len() != exact.len() {
        return f64::NAN;
    }
    let errors = got.iter().zip(exact).map(|(a, b)| (a - b).abs());
    errors.fold(0.0, worse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_in_the_first_entry_is_not_forgotten() {
        assert!(largest(&[[f64::NAN, 1.0, 2.0]]).is_nan());
        assert!(largest_difference(&[f64::NAN, 1.0, 2.0], &[0.0; 3]).is_nan());
        assert!(largest_difference(&[1.0], &[]).is_nan());
        assert_eq!(largest_difference(&[1.0, -3.0, 2.0], &[0.0; 3]), 3.0);
    }
}
