//! An energy that is a small difference of large numbers: near its minimum it is all rounding, its
//! gradient is not.

use crate::promise::{Newton, Summed};
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, NewtonFailure, NewtonParams, NonlinearProblem,
};
use std::sync::Arc;

/// Where the minimum lies.
const MIDDLE: f64 = 1000.1;

/// k (cosh d − 1) with d = x − MIDDLE, of which d²/2 is written as the sum of its three products;
/// `aside` gives the gradient of another energy, whose minimum lies so far off.
struct Cancelling {
    pattern: Arc<BlockPattern>,
    stiffness: f64,
    aside: f64,
    /// How many times as stiff it says it is.
    said: f64,
}

fn cancelling(stiffness: f64, aside: f64) -> Cancelling {
    let pattern = BlockPattern::from_adjacency(1, []).unwrap();
    Cancelling {
        pattern: Arc::new(pattern),
        stiffness,
        aside,
        said: 1.0,
    }
}

impl NonlinearProblem<1> for Cancelling {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let (x, d) = (x[0], x[0] - MIDDLE);
        let square = x * x - 2.0 * MIDDLE * x + MIDDLE * MIDDLE;
        self.stiffness * (0.5 * square + (d.cosh() - 1.0 - 0.5 * d * d))
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = self.stiffness * (x[0] - MIDDLE - self.aside).sinh();
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        let curvature = self.stiffness * (x[0] - MIDDLE - self.aside).cosh();
        out.values_mut()[0] = [[self.said * curvature]];
    }
}

impl Summed<1> for Cancelling {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let d = x[0] - MIDDLE - self.aside;
        let half = 0.5 * self.stiffness;
        vec![vec![half * d.exp(), -half * (-d).exp()]]
    }
}

#[test]
fn a_gradient_that_halves_leads_on_where_the_energy_is_all_rounding() {
    let params = NewtonParams::default();
    for stiffness in [1e-3, 1.0, 1e7] {
        let problem = cancelling(stiffness, 0.0);
        for k in 1..=200 {
            let start = 1e-6 * f64::from(k);
            let mut x = [MIDDLE + start];
            let solved = Newton::new(&problem).solve(&problem, &mut x, &params);
            assert!(solved.is_ok(), "{stiffness:e} {start:e}: {solved:?}");
            assert!((x[0] - MIDDLE).abs() < 1e-9, "{stiffness:e}: {x:?}");
        }
    }
}

/// What leads uphill by more than rounding is no step, however its gradient falls.
#[test]
fn a_gradient_of_another_energy_leads_nowhere() {
    let problem = cancelling(1.0, 1.0);
    let mut x = [MIDDLE + 0.5];
    let error = Newton::new(&problem)
        .solve(&problem, &mut x, &NewtonParams::default())
        .unwrap_err();
    assert!(
        matches!(error.reason, NewtonFailure::LineSearchFailed { .. }),
        "{error}"
    );
    assert!((x[0] - MIDDLE - 0.5).abs() < 1e-9, "{x:?}");
}

/// A third of the gradient is left where it says that it is 1.5 times as stiff, three quarters where 4 times.
#[test]
fn a_gradient_that_does_not_halve_leads_nowhere_where_the_energy_is_all_rounding() {
    for (said, leads) in [(1.5, true), (4.0, false)] {
        let problem = Cancelling {
            said,
            ..cancelling(1.0, 0.0)
        };
        let solved = |k: i32| {
            let mut x = [MIDDLE + 1e-6 * f64::from(k)];
            let params = NewtonParams::default();
            Newton::new(&problem)
                .solve(&problem, &mut x, &params)
                .is_ok()
        };
        assert_eq!((1..=200).all(solved), leads, "{said}");
    }
}

/// ¼ (x² − 1)² + offset, which says it is as stiff as it is bent, whichever way: steps off its saddle at 0
/// double what x is.
struct Saddle {
    pattern: Arc<BlockPattern>,
    offset: f64,
}

impl NonlinearProblem<1> for Saddle {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        0.25 * (x[0] * x[0] - 1.0).powi(2) + self.offset
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = x[0] * (x[0] * x[0] - 1.0);
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        out.values_mut()[0] = [[(3.0 * x[0] * x[0] - 1.0).abs()]];
    }
}

impl Summed<1> for Saddle {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![x[0] * x[0] * x[0], -x[0]]]
    }
}

/// The first steps lower the energy by less than can be seen, while the gradient and the slope grow.
#[test]
fn a_step_off_a_saddle_is_taken_where_its_energy_is_rounding() {
    let params = NewtonParams::default();
    for offset in [0.0, 1e3, -1e6] {
        let problem = Saddle {
            pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
            offset,
        };
        for start in [1e-6, -3e-5] {
            let mut x = [start];
            let solved = Newton::new(&problem).solve(&problem, &mut x, &params);
            assert!(solved.is_ok(), "{offset:e} {start:e}: {solved:?}");
            assert!((x[0].abs() - 1.0).abs() < 1e-9, "{offset:e}: {x:?}");
        }
    }
}
