//! What a gradient is measured against, and when that is asked for.

use crate::promise::{Newton, Summed};
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, NewtonParams, NonlinearProblem, StopReason,
};
use std::cell::Cell;
use std::sync::Arc;

/// `x⁴/4 + x²/2 − x` with the minimum x³ + x = 1.
struct Quartic {
    pattern: Arc<BlockPattern>,
    /// How large a gradient is, where it knows, and the largest that this can be.
    scale: Option<f64>,
    largest: Option<f64>,
    /// How often it was asked for its scale.
    asked: Cell<usize>,
}

impl Quartic {
    fn new(scale: Option<f64>, largest: Option<f64>) -> Self {
        Self {
            pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
            scale,
            largest,
            asked: Cell::new(0),
        }
    }
}

impl NonlinearProblem<1> for Quartic {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        0.25 * x[0].powi(4) + 0.5 * x[0] * x[0] - x[0]
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = x[0].powi(3) + x[0] - 1.0;
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        out.values_mut()[0] = [[3.0 * x[0] * x[0] + 1.0]];
    }
    fn gradient_scales(&self, _: &[f64]) -> Option<Vec<f64>> {
        self.asked.set(self.asked.get() + 1);
        self.scale.map(|scale| vec![scale])
    }
    fn largest_gradient_scales(&self) -> Option<Vec<f64>> {
        self.largest.map(|scale| vec![scale])
    }
}

impl Summed<1> for Quartic {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![x[0] * x[0] * x[0], x[0], -1.0]]
    }
}

#[test]
fn a_start_far_away_does_not_loosen_the_tolerance_of_a_problem_that_knows_its_scale() {
    let solve = |scale, start, params: &NewtonParams| {
        let problem = Quartic::new(scale, None);
        let mut x = [start];
        Newton::new(&problem)
            .solve(&problem, &mut x, params)
            .unwrap();
        x[0]
    };
    let (minimum, default) = (0.682_327_803_828_019_3, NewtonParams::default());
    assert!((solve(Some(1.0), 1e9, &default) - minimum).abs() < 1e-8);
    // Relative to the start alone 1e27 · 1e-8 would do, and a reference of one's own still rules.
    assert!((solve(None, 1e9, &default) - minimum).abs() > 1e3);
    let own = NewtonParams {
        reference: Some(1e27),
        ..default
    };
    assert!((solve(Some(1.0), 1e9, &own) - minimum).abs() > 1e3);
    // Nor does a start close by tighten it: what is good enough stays as it is.
    assert_eq!(solve(Some(1.0), minimum + 1e-12, &default), minimum + 1e-12);
    assert!((solve(Some(1e-4), minimum + 1e-12, &default) - minimum).abs() < 1e-12);
}

#[test]
fn scales_are_asked_for_only_where_a_gradient_may_be_small_enough() {
    let solve = |largest| {
        let problem = Quartic::new(Some(0.5), largest);
        let mut x = [1e3];
        let info = Newton::new(&problem)
            .solve(&problem, &mut x, &NewtonParams::default())
            .unwrap();
        // Once more by the check.
        (x[0], info.iterations, problem.asked.get() - 1)
    };
    let (each, last) = (solve(None), solve(Some(1.0)));
    assert_eq!((each.0, each.1), (last.0, last.1));
    assert_eq!(each.2, each.1 + 1);
    // At the start, and after the last step.
    assert_eq!(last.2, 2, "of {} steps", last.1);
}

/// `(x − middle)²/2` whose gradient is off by `noise`, and who says that it may be by `own`.
struct Noisy {
    pattern: Arc<BlockPattern>,
    middle: f64,
    noise: f64,
    own: Option<f64>,
}

impl NonlinearProblem<1> for Noisy {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        0.5 * (x[0] - self.middle).powi(2)
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = x[0] - self.middle + self.noise;
    }
    fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        out.values_mut()[0] = [[1.0]];
    }
    fn gradient_rounding(&self, _: &[f64]) -> Option<Vec<f64>> {
        self.own.map(|own| vec![own])
    }
}

impl Summed<1> for Noisy {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![x[0], -self.middle, self.noise]]
    }
}

/// The floor is the larger of what rounding of x moves, 4 ε |K| |x|, and what the problem's sums lose.
#[test]
fn a_gradient_is_rounding_below_the_larger_of_two_floors() {
    let by_x = 4.0 * f64::EPSILON * 1000.0;
    for (own, noise, is_rounding) in [
        (None, 0.5 * by_x, true),
        (None, 2.0 * by_x, false),
        (Some(1e-3 * by_x), 0.5 * by_x, true),
        (Some(1e-3 * by_x), 2.0 * by_x, false),
        (Some(1e3 * by_x), 0.5e3 * by_x, true),
        (Some(1e3 * by_x), 2e3 * by_x, false),
        (Some(f64::NAN), 0.5 * by_x, false),
        (Some(f64::INFINITY), 2.0 * by_x, false),
    ] {
        let problem = Noisy {
            pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
            middle: 1000.0,
            noise,
            own,
        };
        let params = NewtonParams {
            relative_gradient_tolerance: 0.0,
            ..NewtonParams::default()
        };
        let mut x = [1000.0];
        let solved = Newton::new(&problem).solve(&problem, &mut x, &params);
        let at_once = matches!(&solved, Ok(info) if info.iterations == 0);
        assert_eq!(at_once, is_rounding, "{own:?}, {noise:e}: {solved:?}");
        if is_rounding {
            assert_eq!(solved.unwrap().stop, StopReason::Rounding);
        }
    }
}
