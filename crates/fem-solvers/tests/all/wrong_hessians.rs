//! Newton's method with Hessians that are not the energy's own: what the line search and the last
//! shift are for.

use crate::promise::{Newton, Summed};
use fem_solvers::{
    BlockPattern, BlockSymmetric, HessianProjection, LinearSolver, Merit, NewtonFailure,
    NewtonIteration, NewtonParams, NonlinearProblem, ProjectionPolicy,
};
use std::sync::Arc;

/// `½ xᵀ A x − bᵀ x` in two unknowns whose Hessian is said to be `said`.
struct Quadratic {
    pattern: Arc<BlockPattern>,
    a: [[f64; 2]; 2],
    b: [f64; 2],
    said: [[f64; 2]; 2],
}

impl NonlinearProblem<2> for Quadratic {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        (0..2)
            .map(|i| x[i] * (0.5 * (self.a[i][0] * x[0] + self.a[i][1] * x[1]) - self.b[i]))
            .sum()
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        for (i, g) in g.iter_mut().enumerate() {
            *g = self.a[i][0] * x[0] + self.a[i][1] * x[1] - self.b[i];
        }
    }
    fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<2>) {
        out.values_mut()[0] = self.said;
    }
    fn largest_step(&self, _: &[f64], _: &[f64]) -> f64 {
        f64::INFINITY
    }
}

impl Summed<2> for Quadratic {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let of = |i: usize| vec![self.a[i][0] * x[0], self.a[i][1] * x[1], -self.b[i]];
        vec![of(0), of(1)]
    }
}

fn quadratic(a: [[f64; 2]; 2], b: [f64; 2], said: [[f64; 2]; 2]) -> Quadratic {
    let pattern = Arc::new(BlockPattern::from_adjacency(1, []).unwrap());
    Quadratic {
        pattern,
        a,
        b,
        said,
    }
}

/// A well around 1, left of which the energy rises to 0 and right of it to a plateau: −exp(−(x − 1)²), and
/// −c − (1 − c) exp(−(x − 1)²).
struct Plateau {
    pattern: Arc<BlockPattern>,
    c: f64,
}

impl NonlinearProblem<1> for Plateau {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let c = if x[0] < 1.0 { 0.0 } else { self.c };
        -c - (1.0 - c) * (-(x[0] - 1.0).powi(2)).exp()
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        let c = if x[0] < 1.0 { 0.0 } else { self.c };
        g[0] = 2.0 * (x[0] - 1.0) * (1.0 - c) * (-(x[0] - 1.0).powi(2)).exp();
    }
    fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        // Far too soft at the start, right in the well.
        out.values_mut()[0] = [[if x[0] < 0.0 { 0.05 } else { 2.0 }]];
    }
}

impl Summed<1> for Plateau {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let c = if x[0] < 1.0 { 0.0 } else { self.c };
        let well = 2.0 * (1.0 - c) * (-x[0] * x[0] + 2.0 * x[0] - 1.0).exp();
        vec![vec![well * x[0], -well]]
    }
}

#[test]
fn a_decrease_that_is_too_small_for_the_slope_shortens_the_step() {
    // The whole first step ends on the plateau, lower than the start by 1e-6 where its slope asks for
    // 2e-4, and flat: nothing would lead away from there.
    let start: f64 = -0.5;
    let problem = Plateau {
        pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
        c: (-(start - 1.0).powi(2)).exp() + 1e-6,
    };
    let mut x = [start];
    let solved = Newton::new(&problem).solve(&problem, &mut x, &NewtonParams::default());
    assert!(
        solved.is_ok() && (x[0] - 1.0).abs() < 1e-6,
        "{x:?}, {solved:?}"
    );
}

#[test]
fn the_last_shift_starts_from_the_plain_matrix() {
    // No share of this diagonal makes the matrix definite, for one of its entries is zero.
    let said = [[0.0, 1.0], [1.0, 1.0]];
    // Mean diagonals weigh a block as a whole; single rows need D = 1.
    let pattern = Arc::new(BlockPattern::from_adjacency(2, [(0, 1)]).unwrap());
    struct Rows(Arc<BlockPattern>, [[f64; 2]; 2]);
    impl NonlinearProblem<1> for Rows {
        fn blocks(&self) -> usize {
            2
        }
        fn pattern(&self) -> Option<Arc<BlockPattern>> {
            Some(self.0.clone())
        }
        fn energy(&self, x: &[f64]) -> f64 {
            0.5 * (x[0] * x[0] + x[1] * x[1]) - x[0]
        }
        fn gradient(&self, x: &[f64], g: &mut [f64]) {
            g.copy_from_slice(&[x[0] - 1.0, x[1]]);
        }
        fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
            out.values_mut().copy_from_slice(&[
                [[self.1[0][0]]],
                [[self.1[1][0]]],
                [[self.1[1][1]]],
            ]);
        }
    }
    impl Summed<1> for Rows {
        fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
            vec![vec![x[0], -1.0], vec![x[1]]]
        }
    }
    let problem = Rows(pattern, said);
    let params = NewtonParams {
        projection: ProjectionPolicy::ExactThenShifted,
        linear_solver: LinearSolver::Direct,
        max_iterations: 1,
        ..Default::default()
    };
    let mut newton = Newton::new(&problem);
    let mut steps = Vec::new();
    let mut x = [0.0, 0.0];
    let outcome = newton.solve_observed(&problem, &mut x, &params, &mut |i| steps.push(*i));
    assert_eq!(outcome.unwrap_err().reason, NewtonFailure::NotConverged);
    // Tenfold from 1e-9 of the diagonal, 1 is the first that suffices: [[1, 1], [1, 2]] d = [1, 0].
    assert!((x[0] / steps[1].t - 2.0).abs() < 1e-9, "{x:?} {steps:?}");
    assert!((x[1] / steps[1].t + 1.0).abs() < 1e-9, "{x:?} {steps:?}");
}

#[test]
fn a_step_that_is_much_too_long_or_short_is_improved_along_its_line() {
    // Said to be four times as stiff: a quarter of the way, then three times that at most. Said to be
    // 0.6 times as stiff: beyond the minimum, where the slope tells how far.
    for (factor, part) in [(4.0, 3.0), (0.6, 0.6), (1.1, 1.0)] {
        let said = [[2.0 * factor, 0.0], [0.0, 2.0 * factor]];
        let problem = quadratic([[2.0, 0.0], [0.0, 2.0]], [1.0, 3.0], said);
        let params = NewtonParams {
            linear_solver: LinearSolver::Direct,
            max_iterations: 1,
            ..NewtonParams::default()
        };
        let (mut x, mut seen) = (vec![0.0; 2], Vec::new());
        let end = Newton::new(&problem).solve_observed(&problem, &mut x, &params, &mut |step| {
            seen.push(*step);
        });
        assert!((seen[1].t - part).abs() < 1e-12, "{factor}: {}", seen[1].t);
        assert!((x[0] - part / factor / 2.0).abs() < 1e-12, "{x:?}");
        if let Err(error) = end {
            let told = error.to_string();
            assert!(told.contains("of Newton's, the exact Hessian"), "{told}");
            assert_eq!(
                (error.factorizations, error.last.as_deref()),
                (1, Some(&seen[1]))
            );
        }
    }
}

/// ½ (x − 1)² + offset with a Hessian of `said`, its own domain and measure of progress.
struct Line {
    pattern: Arc<BlockPattern>,
    said: f64,
    offset: f64,
    least: f64,
    longest: f64,
    merit: Merit,
}

fn line(said: f64) -> Line {
    Line {
        pattern: Arc::new(BlockPattern::from_adjacency(1, []).unwrap()),
        said,
        offset: 0.0,
        least: f64::NEG_INFINITY,
        longest: f64::INFINITY,
        merit: Merit::Energy,
    }
}

impl NonlinearProblem<1> for Line {
    fn blocks(&self) -> usize {
        1
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.pattern.clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        if x[0] < self.least {
            return f64::INFINITY;
        }
        0.5 * (x[0] - 1.0).powi(2) + self.offset
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        g[0] = x[0] - 1.0;
    }
    fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
        out.values_mut()[0] = [[self.said]];
    }
    fn merit(&self) -> Merit {
        self.merit
    }
    fn largest_step(&self, _: &[f64], _: &[f64]) -> f64 {
        self.longest
    }
}

impl Summed<1> for Line {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![x[0], -1.0]]
    }
}

/// The places and shares of the steps from `start`, and how it ended.
fn along(
    problem: &Line,
    start: f64,
    steps: usize,
) -> (f64, Vec<NewtonIteration>, Option<NewtonFailure>) {
    let params = NewtonParams {
        linear_solver: LinearSolver::Direct,
        max_iterations: steps,
        ..NewtonParams::default()
    };
    let (mut x, mut seen) = ([start], Vec::new());
    let end = Newton::new(problem).solve_observed(problem, &mut x, &params, &mut |s| seen.push(*s));
    (x[0], seen, end.err().map(|error| error.reason))
}

#[test]
fn a_step_that_is_too_long_is_cut_to_the_minimum_of_its_parabola() {
    for said in [0.12, 0.23, 0.4] {
        let (x, seen, end) = along(&line(said), 3.0, 10);
        // The energy of a line is its parabola.
        assert!((seen[1].t - said).abs() < 1e-12, "{said}: {}", seen[1].t);
        assert!((x - 1.0).abs() < 1e-12 && end.is_none());
    }
}

/// A step goes 1/said of the way; where energies are too close to tell, it must leave less than 0.9 of the
/// gradient, or lower the energy as it should.
#[test]
fn where_energies_cannot_tell_a_gradient_must_fall_by_a_tenth() {
    let failed = |said: f64, offset: f64, start: f64| {
        let problem = Line {
            offset,
            ..line(said)
        };
        let end = along(&problem, start, 1).2.unwrap();
        matches!(end, NewtonFailure::LineSearchFailed { .. })
    };
    for (said, fails) in [(5.0, false), (20.0, true)] {
        assert_eq!(failed(said, 1e16, 1.5), fails, "{said}");
    }
    // 1e-14 of the energy are no rounding where they are seen to fall.
    assert!(!failed(20.0, 1e4, 1.0001));
}

/// x goes nearly to 2 − x, which is nearly as far from the end: by 4e-5 of it, where 1e-4 are asked for.
#[test]
fn a_residual_nearly_as_large_as_before_is_no_progress() {
    let problem = Line {
        merit: Merit::ResidualNorm,
        ..line(0.50001)
    };
    let (x, seen, end) = along(&problem, 3.0, 5);
    assert!(end.is_none() && (x - 1.0).abs() < 1e-7, "{x} {seen:?}");
    assert_eq!(seen[1].t, 0.5);
}

#[test]
fn smaller_forces_outside_the_domain_are_no_progress() {
    for merit in [Merit::ResidualNorm, Merit::Energy] {
        let problem = Line {
            merit,
            least: 0.9,
            ..line(0.8)
        };
        // The whole step ends at 0.5.
        let (x, seen, end) = along(&problem, 3.0, 60);
        assert!(seen.iter().all(|s| s.energy < f64::INFINITY), "{seen:?}");
        // Its energy tells where on the line the minimum is.
        let shorter = if merit == Merit::Energy { 0.8 } else { 0.5 };
        assert!((seen[1].t - shorter).abs() < 1e-12, "{}", seen[1].t);
        assert!(end.is_none() && (x - 1.0).abs() < 1e-7);
    }
}

#[test]
fn no_step_is_improved_beyond_the_longest() {
    // Said to be four times as stiff: three times the step would be better.
    for (longest, t) in [(f64::INFINITY, 3.0), (3.5, 3.0), (2.9, 1.0), (0.5, 0.5)] {
        let problem = Line {
            longest,
            ..line(4.0)
        };
        let seen = along(&problem, 3.0, 1).1;
        assert!((seen[1].t - t).abs() < 1e-12, "{longest}: {}", seen[1].t);
    }
}
