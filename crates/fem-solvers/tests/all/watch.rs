//! A program around a solve.

use crate::promise::Newton;
use crate::rosenbrock::Rosenbrock;
use fem_solvers::{NewtonFailure, NewtonParams, Watch};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn a_watch_sees_every_step_and_ends_a_solve_where_it_stands() {
    let problem = Rosenbrock::new(40, 3.0);
    let start: Vec<f64> = (0..80)
        .map(|i| if i % 2 == 0 { 0.1 } else { 2.0 })
        .collect();
    let params = NewtonParams {
        gradient_tolerance: 1e-11,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let mut states = vec![start.clone()];
    for limit in 0..3 {
        let asked = Arc::new(AtomicUsize::new(0));
        let count = asked.clone();
        let watch = Watch::new(move |step| {
            assert_eq!(step.iteration, count.fetch_add(1, Ordering::Relaxed));
            if step.iteration == limit {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        let mut x = start.clone();
        let mut newton = Newton::new(&problem).watched_by(watch);
        let error = newton.solve(&problem, &mut x, &params).unwrap_err();
        assert_eq!(error.reason, NewtonFailure::Cancelled);
        assert_eq!(
            (error.iteration, asked.load(Ordering::Relaxed)),
            (limit, limit + 1)
        );
        if limit > 0 {
            states.push(x);
        }
    }
    // As far as a solve with that many steps allowed.
    for (steps, state) in states.iter().enumerate().skip(1) {
        let mut x = start.clone();
        let cut = NewtonParams {
            max_iterations: steps,
            ..params
        };
        Newton::new(&problem)
            .solve(&problem, &mut x, &cut)
            .unwrap_err();
        assert_eq!(x, *state);
    }
}
