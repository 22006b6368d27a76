//! A preconditioner and a direction that the crate does not know.

use crate::promise::Newton;
use crate::rosenbrock::Rosenbrock;
use fem_solvers::{
    BlockIc0, BlockJacobi, BlockSymmetric, Descent, DescentDirection, DescentOutcome, Identity,
    LinearSolver, MatrixPreconditioner, NewtonFailure, NewtonParams, NewtonSystem, PcgDirection,
    Preconditioner, PreconditionerChoice, PreconditionerError,
};

/// The diagonal, entry by entry.
struct Diagonal(Vec<f64>);

impl Preconditioner for Diagonal {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for ((z, r), d) in z.iter_mut().zip(r).zip(&self.0) {
            *z = r / d;
        }
    }
}

impl<const D: usize> MatrixPreconditioner<D> for Diagonal {
    fn update(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        self.0 = matrix.diagonal();
        match self.0.iter().position(|d| !(*d > 0.0)) {
            None => Ok(()),
            Some(row) => Err(PreconditionerError::NotPositiveDefinite { block: row / D }),
        }
    }
}

/// Gauss-Seidel, as often as Rosenbrock's valley, with its rate of 0.9975, needs.
const SWEEPS: usize = 20_000;

/// Gauss-Seidel sweeps with the dense matrix.
struct Sweeps;

impl DescentDirection<2> for Sweeps {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, 2>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let matrix = system.tangent().matrix();
        let a = matrix.ok_or(NewtonFailure::NeedsMatrix)?.to_dense();
        let (gradient, n) = (system.gradient(), dx.len());
        let mut converged = false;
        for _ in 0..SWEEPS {
            let before = dx.to_vec();
            for i in 0..n {
                let rest: f64 = (0..n)
                    .filter(|&j| j != i)
                    .map(|j| a[i * n + j] * dx[j])
                    .sum();
                dx[i] = (-gradient[i] - rest) / a[i * n + i];
            }
            let near = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-9 * y.abs();
            converged = dx.iter().zip(&before).all(near);
        }
        // The sweeps converge for every positive definite matrix and grow without bound otherwise.
        let outcome = if converged {
            DescentOutcome::Found
        } else {
            DescentOutcome::Indefinite
        };
        Ok(Descent::iterated(outcome, SWEEPS))
    }
}

fn solve(mut newton: Newton<2>, problem: &Rosenbrock, params: &NewtonParams) -> (Vec<f64>, usize) {
    let mut x = vec![0.4; 12];
    let info = newton.solve(problem, &mut x, params).unwrap();
    (x, info.linear_iterations)
}

#[test]
fn a_strangers_preconditioner_and_a_strangers_direction_solve() {
    let problem = Rosenbrock::new(6, 2.0);
    let params = NewtonParams {
        gradient_tolerance: 1e-10,
        relative_gradient_tolerance: 0.0,
        ..Default::default()
    };
    let diagonal = PcgDirection::new(Diagonal(Vec::new()), 500);
    for newton in [
        Newton::with_direction(&problem, diagonal),
        Newton::with_direction(&problem, Sweeps),
    ] {
        let (x, iterations) = solve(newton, &problem, &params);
        assert!(x.iter().all(|v| (v - 1.0).abs() < 1e-9), "{x:?}");
        assert!(iterations > 0);
    }
}

#[test]
fn the_crates_own_preconditioners_give_the_same_bits_through_the_open_trait() {
    let problem = Rosenbrock::new(6, 2.0);
    let by_name = |preconditioner| {
        let params = NewtonParams {
            linear_solver: LinearSolver::Pcg {
                preconditioner,
                max_iterations: 500,
            },
            ..Default::default()
        };
        solve(Newton::new(&problem), &problem, &params)
    };
    let identity = Newton::with_direction(&problem, PcgDirection::new(Identity, 500));
    assert_eq!(
        by_name(PreconditionerChoice::Identity),
        solve(identity, &problem, &NewtonParams::default())
    );
    let jacobi = PcgDirection::new(BlockJacobi::default(), 500);
    let jacobi = Newton::with_direction(&problem, jacobi);
    assert_eq!(
        by_name(PreconditionerChoice::BlockJacobi),
        solve(jacobi, &problem, &NewtonParams::default())
    );
    let ic = PcgDirection::new(BlockIc0::default(), 500);
    let ic = Newton::with_direction(&problem, ic);
    assert_eq!(
        by_name(PreconditionerChoice::BlockIc0),
        solve(ic, &problem, &NewtonParams::default())
    );
}
