//! A problem is asked what nothing determines when a solve has failed, and never otherwise.

use crate::promise::{Newton, Summed};
use fem_kinematics::HessianProjection;
use fem_solvers::{BlockPattern, BlockSymmetric, NewtonParams, NonlinearProblem, Watch};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

/// x⁴/4 − f x for one unknown; nothing but the first is looked at.
struct Quartic {
    pattern: Arc<BlockPattern>,
    force: f64,
    asked: Cell<usize>,
}

impl Quartic {
    fn new(force: f64) -> Self {
        let pattern = BlockPattern::from_adjacency(1, []).unwrap();
        Self {
            pattern: Arc::new(pattern),
            force,
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
        0.25 * x[0].powi(4) - self.force * x[0]
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = x[0].powi(3) - self.force;
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        out.values_mut().fill([[3.0 * x[0] * x[0]]]);
    }
    fn undetermined(&self, x: &[f64]) -> Option<String> {
        self.asked.set(self.asked.get() + 1);
        Some(format!("it slides at {}", x[0]))
    }
}

impl Summed<1> for Quartic {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![x[0] * x[0] * x[0], -self.force]]
    }
}

#[test]
fn only_a_solve_that_failed_asks() {
    let solve = |params: &NewtonParams, watch: Option<Watch>| {
        let problem = Quartic::new(8.0);
        let mut newton = Newton::new(&problem);
        if let Some(watch) = watch {
            newton = newton.watched_by(watch);
        }
        let mut x = [5.0];
        let solved = newton.solve(&problem, &mut x, params);
        (solved.map(|_| x[0]), problem.asked.get(), x[0])
    };
    let (solved, asked, _) = solve(&NewtonParams::default(), None);
    assert!((solved.unwrap() - 2.0).abs() < 1e-6);
    assert_eq!(asked, 0);
    let short = NewtonParams {
        max_iterations: 2,
        ..NewtonParams::default()
    };
    let (failed, asked, x) = solve(&short, None);
    let failed = failed.unwrap_err();
    // Asked of the place that it came to.
    assert!(x < 4.0, "{x}");
    let told = format!("it slides at {x}");
    assert_eq!((failed.undetermined.as_deref(), asked), (Some(&*told), 1));
    let told = format!("not converged; {told}");
    assert!(failed.to_string().ends_with(&told), "{failed}");
    // Neither a program that ends it nor a setting that makes no sense has to do with the problem.
    let (cancelled, asked, _) = solve(&short, Some(Watch::new(|_| ControlFlow::Break(()))));
    assert_eq!((cancelled.unwrap_err().undetermined, asked), (None, 0));
    let nonsense = NewtonParams {
        step_tolerance: f64::NAN,
        ..NewtonParams::default()
    };
    let (refused, asked, _) = solve(&nonsense, None);
    assert_eq!((refused.unwrap_err().undetermined, asked), (None, 0));
}
