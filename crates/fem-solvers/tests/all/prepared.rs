//! A problem that gets another pattern for a step, and no step that leads anywhere.

use crate::promise::{Newton, Summed};
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, NewtonFailure, NewtonParams, NonlinearProblem,
};
use std::cell::Cell;
use std::sync::Arc;

/// Two unknowns that a spring couples from the first step on; energies that never fall.
struct Growing {
    apart: Arc<BlockPattern>,
    coupled: Arc<BlockPattern>,
    prepared: Cell<bool>,
}

impl NonlinearProblem<1> for Growing {
    fn blocks(&self) -> usize {
        2
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        let pattern = if self.prepared.get() {
            &self.coupled
        } else {
            &self.apart
        };
        Some(pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        1e3 * ((x[0] - 1.0).abs() + (x[1] - 2.0).abs())
    }
    fn gradient(&self, _: &[f64], g: &mut [f64]) {
        g.copy_from_slice(&[1.0, 2.0]);
    }
    fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        let blocks: &[[[f64; 1]; 1]] = if self.prepared.get() {
            &[[[2.0]], [[-1.0]], [[2.0]]]
        } else {
            &[[[1.0]], [[1.0]]]
        };
        out.values_mut().copy_from_slice(blocks);
    }
    fn prepare(&self, _: &[f64], _: &[f64]) -> bool {
        !self.prepared.replace(true)
    }
}

impl Summed<1> for Growing {
    fn terms(&self, _: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![2.0]]
    }
}

#[test]
fn a_step_that_fails_in_a_new_pattern_is_an_error_and_no_panic() {
    let pattern = |pairs: &[(usize, usize)]| {
        Arc::new(BlockPattern::from_adjacency(2, pairs.iter().copied()).unwrap())
    };
    let problem = Growing {
        apart: pattern(&[]),
        coupled: pattern(&[(1, 0)]),
        prepared: Cell::new(false),
    };
    let mut x = [1.0, 2.0];
    let solved = Newton::new(&problem).solve(&problem, &mut x, &NewtonParams::default());
    let failure = solved.expect_err("no step leads anywhere").reason;
    assert!(
        matches!(failure, NewtonFailure::LineSearchFailed { .. }),
        "{failure:?}"
    );
    assert!(problem.prepared.get());
}
