//! What a gradient is measured against is asked for only where it matters.

use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, Newton, NewtonParams, NonlinearProblem,
};
use std::sync::Arc;

/// A quartic that counts how often it is asked for its scales.
struct Asked {
    pattern: Arc<BlockPattern>,
    tells_largest: bool,
    asked: std::cell::Cell<usize>,
}

impl NonlinearProblem<1> for Asked {
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
        Some(vec![0.5])
    }
    fn largest_gradient_scales(&self) -> Option<Vec<f64>> {
        self.tells_largest.then(|| vec![1.0])
    }
}

#[test]
fn scales_are_asked_for_only_where_a_gradient_may_be_small_enough() {
    let solve = |tells_largest| {
        let problem = Asked {
            pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
            tells_largest,
            asked: std::cell::Cell::new(0),
        };
        let mut x = [1e3];
        let params = NewtonParams::default();
        let info = Newton::new(&problem)
            .solve(&problem, &mut x, &params)
            .unwrap();
        (x[0], info.iterations, problem.asked.get())
    };
    let (each, last) = (solve(false), solve(true));
    assert_eq!((each.0, each.1), (last.0, last.1));
    assert_eq!(each.2, each.1 + 1);
    // At the start, and after the last step.
    assert_eq!(last.2, 2, "of {} steps", last.1);
}
