//! A push that acts on one side alone: a point in a ball, held by a spring.

use crate::promise::{Newton, Summed};
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, LinearSolver, NewtonInfo, NewtonParams,
    NonlinearProblem, ProjectionPolicy,
};
use std::cell::Cell;
use std::sync::Arc;

const RADIUS: f64 = 1.0;
const PUSH: f64 = 40.0;
/// Where the spring would have the point: inside, off the center.
const HOME: [f64; 2] = [0.2, 0.05];

/// ½ |x − home|² + PUSH/3 (RADIUS − |x|)₊³.
struct Ball {
    told: bool,
    /// Steps that were announced.
    prepared: Cell<usize>,
}

impl Ball {
    fn new(told: bool) -> Self {
        let prepared = Cell::new(0);
        Self { told, prepared }
    }

    /// Distance from the center, and how deep that is.
    fn depth(x: &[f64]) -> (f64, f64) {
        let r = x[0].hypot(x[1]);
        (r, (RADIUS - r).max(0.0))
    }

    fn assemble(x: &[f64], share: f64, projection: HessianProjection, out: &mut BlockSymmetric<2>) {
        let (r, depth) = Self::depth(x);
        let n = [x[0] / r, x[1] / r];
        // Along the normal, and across it, where the push turns with the point.
        let (along, across) = (2.0 * PUSH * depth, -PUSH * depth * depth / r);
        let across = match projection {
            HessianProjection::None => (1.0 - share) * across,
            _ => 0.0,
        };
        let entry = |i: usize, j: usize| {
            let identity = f64::from(u8::from(i == j));
            identity + along * n[i] * n[j] + across * (identity - n[i] * n[j])
        };
        out.values_mut()[0] = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
    }

    fn solve(&self) -> (Vec<f64>, NewtonInfo) {
        let mut x = vec![0.3, 0.0];
        let params = NewtonParams {
            projection: ProjectionPolicy::ExactThenBlended,
            linear_solver: LinearSolver::Direct,
            gradient_tolerance: 1e-12,
            relative_gradient_tolerance: 0.0,
            ..NewtonParams::default()
        };
        let info = Newton::new(self).solve(self, &mut x, &params).unwrap();
        (x, info)
    }
}

impl NonlinearProblem<2> for Ball {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        BlockPattern::from_adjacency(1, []).ok().map(Arc::new)
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let (_, depth) = Self::depth(x);
        let spring: f64 = x
            .iter()
            .zip(HOME)
            .map(|(x, h)| 0.5 * (x - h) * (x - h))
            .sum();
        spring + PUSH / 3.0 * depth * depth * depth
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        let (r, depth) = Self::depth(x);
        for i in 0..2 {
            g[i] = x[i] - HOME[i] - PUSH * depth * depth * x[i] / r;
        }
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<2>) {
        Self::assemble(x, 0.0, projection, out);
    }
    fn is_one_sided(&self) -> bool {
        self.told
    }
    fn one_sided_hessian(
        &self,
        x: &[f64],
        projection: HessianProjection,
        share: f64,
        out: &mut BlockSymmetric<2>,
    ) {
        Self::assemble(x, share, projection, out);
    }
    fn prepare(&self, _: &[f64], _: &[f64]) -> bool {
        self.prepared.set(self.prepared.get() + 1);
        false
    }
}

impl Summed<2> for Ball {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let r = (x[0] * x[0] + x[1] * x[1]).sqrt();
        // (R − r)₊² x/r, multiplied out.
        let push = if r < RADIUS { PUSH } else { 0.0 };
        let of = |(x, home): (&f64, f64)| {
            let push = [RADIUS * RADIUS / r, -2.0 * RADIUS, r].map(|part| -push * part * x);
            [vec![*x, -home], push.to_vec()].concat()
        };
        x.iter().zip(HOME).map(of).collect()
    }
}

#[test]
fn far_from_the_end_few_factorizations_are_refused_and_the_end_is_exact() {
    let told = Ball::new(true);
    let (x, info) = told.solve();
    let (other, blind) = Ball::new(false).solve();
    // The first matrix is indefinite as it stands: across the normal −40 · 0.7² / 0.3 + 1.
    assert!(blind.factorizations > blind.iterations, "{blind:?}");
    let refused = |info: &NewtonInfo| info.factorizations - info.iterations;
    assert!(refused(&info) <= 1, "{info:?}");
    assert!(refused(&info) < refused(&blind), "{info:?} {blind:?}");
    assert_eq!(told.prepared.get(), info.iterations);
    // On the ray of the spring's home, where the push and the spring are equal.
    for x in [&x, &other] {
        let r = x[0].hypot(x[1]);
        let home = HOME[0].hypot(HOME[1]);
        assert!((x[0] * HOME[1] - x[1] * HOME[0]).abs() < 1e-11, "{x:?}");
        assert!(
            (r - home - PUSH * (RADIUS - r).powi(2)).abs() < 1e-11,
            "{x:?}"
        );
    }
}
