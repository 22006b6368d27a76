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
