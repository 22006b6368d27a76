//! Whether a short step is the end, or only short because it was damped.

use super::linear_step::Model;
use super::{Bounds, GaussNewtonParams};
use crate::vector::norm_inf;

/// Share of the Gauss-Newton matrix's diagonal that keeps a step without damping defined where the
/// Jacobian has lost rank.
const ALMOST_NOTHING: f64 = 1e-10;
/// Differences of cost below this share of it are rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Share of what the undamped model promises that an undisturbed step is predicted to gain.
const MOST: f64 = 0.5;

/// What is left to gain from a point, as the model there says without damping.
pub(super) struct Remaining {
    gain: f64,
    length: f64,
    cost: f64,
    residual: f64,
    groups: f64,
}

impl Remaining {
    /// `None` where the model has no step even with almost no damping.
    pub fn of(
        model: &Model<'_>,
        theta: &[f64],
        params: &GaussNewtonParams,
        (cost, residual): (f64, f64),
    ) -> Option<Self> {
        let diagonal = &model.diagonal;
        let largest = diagonal.iter().fold(0.0_f64, |a, &b| a.max(b));
        let floor = if largest > 0.0 { largest } else { 1.0 };
        let damping: Vec<f64> = diagonal
            .iter()
            .map(|d| ALMOST_NOTHING * d.max(ALMOST_NOTHING * floor))
            .collect();
        let bounds: Option<&Bounds> = params.bounds.as_ref();
        let d = model
            .step(params.method, theta, bounds, Some(&damping))
            .ok()?;
        Some(Self {
            gain: model.decrease(&d),
            length: norm_inf(&d),
            cost,
            residual,
            groups: (model.residuals / params.group_size.max(1)) as f64,
        })
    }

    /// Would no step, of whatever damping, gain anything by the tests of the settings?
    pub fn is_nothing(&self, params: &GaussNewtonParams) -> bool {
        let share = params.cost_tolerance.max(ROUNDING);
        // ½ groups rms² falls by the gain.
        let left = (self.residual * self.residual - 2.0 * self.gain / self.groups).max(0.0);
        self.gain <= share * self.cost
            || self.length <= params.step_tolerance
            || self.residual - left.sqrt() < params.residual_change
    }

    /// Was a step predicted to gain `predicted` about as good as an undamped one?
    pub fn is_taken_by(&self, predicted: f64) -> bool {
        predicted >= MOST * self.gain
    }
}

#[cfg(test)]
mod tests {
    use super::{GaussNewtonParams, Model, Remaining};
    use crate::gauss_newton::StepMethod;

    /// What is left to gain is told per residual, however many rows stand for them.
    #[test]
    fn a_triangle_promises_what_all_rows_promise() {
        let wave = |k: usize| ((k * k) as f64 * 0.37 + k as f64).sin();
        let (rows, columns) = (120, 3);
        let j: Vec<f64> = (0..rows * columns).map(wave).collect();
        let r: Vec<f64> = (0..rows).map(|k| 2.0 + wave(7 * k)).collect();
        let (theta, params) = ([0.0; 3], GaussNewtonParams::default());
        let cost = 0.5 * r.iter().map(|r| r * r).sum::<f64>();
        let residual = (2.0 * cost / rows as f64).sqrt();
        let model = || Model::new(columns, &r, &j, None);
        let left = |model: &Model<'_>| {
            let left = Remaining::of(model, &theta, &params, (cost, residual)).unwrap();
            (left.residual * left.residual - 2.0 * left.gain / left.groups).sqrt()
        };
        let whole = left(&model());
        let triangle = left(&model().reduced(StepMethod::Qr, &theta, None));
        assert!(
            whole > 0.5 && (whole - triangle).abs() < 1e-12,
            "{whole} {triangle}"
        );
    }
    #[test]
    fn what_is_left_counts_for_nothing_by_each_test_alone() {
        // ½ · 2 · 5² falls by 16: to 3.
        let left = |gain| Remaining {
            gain,
            length: 1.0,
            cost: 25.0,
            residual: 5.0,
            groups: 2.0,
        };
        let none = GaussNewtonParams {
            cost_tolerance: 0.0,
            step_tolerance: 0.0,
            residual_change: 0.0,
            ..GaussNewtonParams::default()
        };
        assert!(!left(16.0).is_nothing(&none));
        // Rounding of a cost of 25 says nothing; more than that does.
        assert!(left(8.0 * f64::EPSILON * 25.0).is_nothing(&none));
        assert!(!left(1e3 * f64::EPSILON * 25.0).is_nothing(&none));
        for (change, is_nothing) in [(1.99, false), (2.01, true)] {
            let by_residual = GaussNewtonParams {
                residual_change: change,
                ..none.clone()
            };
            assert_eq!(left(16.0).is_nothing(&by_residual), is_nothing, "{change}");
        }
        for (share, is_nothing) in [(0.63, false), (0.65, true)] {
            let by_cost = GaussNewtonParams {
                cost_tolerance: share,
                ..none.clone()
            };
            assert_eq!(left(16.0).is_nothing(&by_cost), is_nothing, "{share}");
        }
        assert!(left(16.0).is_taken_by(8.0) && !left(16.0).is_taken_by(7.9));
    }

    /// A column of zeros leaves a step all the same, of the others.
    #[test]
    fn a_parameter_without_any_effect_leaves_a_promise() {
        let (r, j) = ([3.0, 4.0], [1.0, 0.0, 0.0, 0.0]);
        let model = Model::new(2, &r, &j, None);
        let params = GaussNewtonParams::default();
        let left = Remaining::of(&model, &[0.0; 2], &params, (12.5, 5.0)).unwrap();
        // ½ · 3², but for a damping of 1e-10.
        assert!((left.gain - 4.5).abs() < 1e-8 && (left.length - 3.0).abs() < 1e-8);
    }
}
