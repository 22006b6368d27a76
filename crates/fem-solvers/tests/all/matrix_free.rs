//! Newton's method on problems that give products with their Hessian and no matrix.

use crate::promise::{Newton, Summed};
use crate::rosenbrock::Rosenbrock;
use fem_solvers::{
    BlockJacobi, HessianProjection, Identity, LinearOperator, LinearSolver, MatrixPreconditioner,
    NewtonFailure, NewtonInfo, NewtonParams, NonlinearProblem, PcgDirection, Preconditioner,
    PreconditionerError, ProjectionPolicy,
};
use std::cell::Cell;

/// The forces and products of Rosenbrock's valley, entry by entry.
struct Products {
    inner: Rosenbrock,
    /// Whether a projected product leaves the indefinite part out.
    projects: bool,
    /// Whether a projected product was asked for.
    asked: Cell<bool>,
}

const COUPLING: f64 = 2.0;

impl NonlinearProblem<2> for Products {
    fn blocks(&self) -> usize {
        self.inner.blocks()
    }
    fn energy(&self, x: &[f64]) -> f64 {
        self.inner.energy(x)
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.inner.gradient(x, g);
    }
    fn hessian_vector(&self, x: &[f64], projection: HessianProjection, v: &[f64], y: &mut [f64]) {
        if projection != HessianProjection::None {
            self.asked.set(true);
        }
        for i in 0..self.blocks() {
            let (a, b) = (x[2 * i], x[2 * i + 1]);
            let bend = -400.0 * (b - a * a);
            let exact = projection == HessianProjection::None || !self.projects;
            let h = 2.0 + 800.0 * a * a + if exact { bend } else { 0.0 };
            y[2 * i] = h * v[2 * i] - 400.0 * a * v[2 * i + 1];
            y[2 * i + 1] = -400.0 * a * v[2 * i] + 200.0 * v[2 * i + 1];
        }
        for i in 1..self.blocks() {
            let pull = COUPLING * (v[2 * i - 1] - v[2 * i]);
            y[2 * i - 1] += pull;
            y[2 * i] -= pull;
        }
    }
}

impl Summed<2> for Products {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        self.inner.terms(x)
    }
}

fn params() -> NewtonParams {
    NewtonParams {
        gradient_tolerance: 1e-10,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    }
}

fn problem(projects: bool) -> Products {
    Products {
        inner: Rosenbrock::new(6, COUPLING),
        projects,
        asked: Cell::new(false),
    }
}

fn solve(mut newton: Newton<2>, problem: &Products, start: f64, p: &NewtonParams) -> NewtonInfo {
    let mut x = vec![start; 12];
    let info = newton.solve(problem, &mut x, p).unwrap();
    // The valley's floor is at 1, whatever the coupling.
    assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-9), "{x:?}");
    assert_eq!(info.factorizations, 0);
    assert!(newton.matrix().is_none() && newton.symbolic().is_none());
    info
}

#[test]
fn products_alone_are_minimized_with_conjugate_gradients() {
    let problem = problem(true);
    let pcg = PcgDirection::new(Identity, 500);
    let auto = solve(Newton::new(&problem), &problem, 0.4, &params());
    let brought = solve(
        Newton::with_direction(&problem, pcg),
        &problem,
        0.4,
        &params(),
    );
    assert_eq!(auto, brought);
    assert!(auto.linear_iterations > auto.iterations);
}

#[test]
fn the_steps_are_those_with_the_matrix_up_to_rounding() {
    let (free, assembled) = (problem(true), Rosenbrock::new(6, COUPLING));
    let pcg = || PcgDirection::new(Identity, 500);
    let one = NewtonParams {
        max_iterations: 3,
        ..params()
    };
    let (mut x, mut y) = (vec![0.4; 12], vec![0.4; 12]);
    Newton::with_direction(&free, pcg())
        .solve(&free, &mut x, &one)
        .unwrap_err();
    Newton::with_direction(&assembled, pcg())
        .solve(&assembled, &mut y, &one)
        .unwrap_err();
    assert!(
        x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-9),
        "{x:?} {y:?}"
    );
    assert!(x.iter().any(|x| (x - 0.4).abs() > 1e-3));
}

#[test]
fn indefinite_products_are_projected_or_shifted() {
    for (projection, projects) in [
        (ProjectionPolicy::ExactFirst, true),
        (ProjectionPolicy::ExactThenShifted, false),
        (ProjectionPolicy::ExactThenBlended, true),
        // A projection that changes nothing leaves the last shifts.
        (ProjectionPolicy::ExactFirst, false),
    ] {
        let problem = problem(projects);
        let params = NewtonParams {
            projection,
            max_iterations: 300,
            ..params()
        };
        let mut x: Vec<f64> = (0..12)
            .map(|i| if i % 2 == 0 { 0.1 } else { 2.0 })
            .collect();
        let info = Newton::new(&problem)
            .solve(&problem, &mut x, &params)
            .unwrap();
        assert!(info.projected_steps > 0, "{projection:?} {projects}");
        let shifts_only = projection == ProjectionPolicy::ExactThenShifted;
        assert_eq!(problem.asked.get(), !shifts_only);
        assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-9), "{x:?}");
    }
}

#[test]
fn a_direction_cut_short_is_taken_as_it_stands() {
    let problem = problem(true);
    let params = NewtonParams {
        max_iterations: 3_000,
        ..params()
    };
    let pcg = PcgDirection::new(Identity, 6);
    let info = solve(
        Newton::with_direction(&problem, pcg),
        &problem,
        0.9,
        &params,
    );
    assert!(info.linear_iterations <= 6 * info.iterations);
}

/// Knows the diagonal of the matrix that nobody assembles, at the solution.
struct KnownDiagonal;

impl Preconditioner for KnownDiagonal {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for (i, (z, r)) in z.iter_mut().zip(r).enumerate() {
            *z = r / if i % 2 == 0 { 802.0 } else { 200.0 };
        }
    }
}

impl MatrixPreconditioner<2> for KnownDiagonal {
    fn update(&mut self, _: &fem_solvers::BlockSymmetric<2>) -> Result<(), PreconditionerError> {
        Ok(())
    }
    fn update_products(
        &mut self,
        operator: &dyn LinearOperator,
    ) -> Result<(), PreconditionerError> {
        assert_eq!(operator.dim(), 12);
        Ok(())
    }
}

#[test]
fn what_needs_a_matrix_says_so_and_what_needs_none_works() {
    let problem = problem(true);
    let known = PcgDirection::new(KnownDiagonal, 500);
    solve(
        Newton::with_direction(&problem, known),
        &problem,
        0.9,
        &params(),
    );
    for linear_solver in [
        LinearSolver::Direct,
        LinearSolver::DirectSingle,
        LinearSolver::QrLeastSquares,
    ] {
        let params = NewtonParams {
            linear_solver,
            ..params()
        };
        let error = Newton::new(&problem)
            .solve(&problem, &mut [0.4; 12], &params)
            .unwrap_err();
        assert_eq!(error.reason, NewtonFailure::NeedsMatrix);
        assert_eq!(error.iteration, 0);
    }
    let jacobi = PcgDirection::new(BlockJacobi::default(), 500);
    let error = Newton::with_direction(&problem, jacobi)
        .solve(&problem, &mut [0.4; 12], &params())
        .unwrap_err();
    assert_eq!(
        error.reason,
        NewtonFailure::Preconditioner(PreconditionerError::NeedsMatrix)
    );
    assert_eq!(
        Newton::new(&problem)
            .factor_at(&problem, &[1.0; 12])
            .unwrap_err(),
        NewtonFailure::NeedsMatrix
    );
}
