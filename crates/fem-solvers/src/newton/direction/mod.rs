//! Where Newton's method gets its directions: an open trait, and a file for each policy of the crate.

mod auto;
mod dense_qr;
mod direct;
mod multigrid;
mod pcg;
mod rigid;
mod single;
mod thrifty;

pub use multigrid::MultigridDirection;
pub(crate) use multigrid::{FLOPS_PER_BYTE, bytes_of_an_iteration};
pub use pcg::PcgDirection;

use super::factorizer::Factorizer;
use super::{LinearSolver, NewtonFailure, PreconditionerChoice, Tangent};
use crate::cholesky::SymbolicCholesky;
use crate::multigrid::NearKernel;
use crate::preconditioner::{BlockIc0, BlockJacobi, Identity};
use std::sync::Arc;

/// What a [`DescentDirection`] found out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DescentOutcome {
    /// `dx` is a direction; Newton's method still checks that it is finite and leads downhill.
    Found,
    /// The matrix is not positive definite: Newton's method repairs it and asks again.
    Indefinite,
    /// Not worth more work: a sparse factorization takes over for this step. Without a matrix `dx` is
    /// taken as it stands.
    TooSlow,
}

/// An outcome and the work that it took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Descent {
    /// What was found out.
    pub outcome: DescentOutcome,
    /// Iterations of a linear solver.
    pub linear_iterations: usize,
    /// Factorizations.
    pub factorizations: usize,
}

impl Descent {
    /// An outcome that took `linear_iterations` and no factorization.
    pub fn iterated(outcome: DescentOutcome, linear_iterations: usize) -> Self {
        Self {
            outcome,
            linear_iterations,
            factorizations: 0,
        }
    }

    /// An outcome that took one factorization.
    pub fn factored(outcome: DescentOutcome) -> Self {
        Self {
            outcome,
            linear_iterations: 0,
            factorizations: 1,
        }
    }

    /// This outcome after the work of `before`.
    #[must_use]
    pub fn after(self, before: Self) -> Self {
        Self {
            outcome: self.outcome,
            linear_iterations: before.linear_iterations + self.linear_iterations,
            factorizations: before.factorizations + self.factorizations,
        }
    }
}

/// The linear system of one Newton step, `K dx = −g`.
pub struct NewtonSystem<'a, const D: usize> {
    pub(super) tangent: Tangent<'a, D>,
    pub(super) at: &'a [f64],
    pub(super) gradient: &'a [f64],
    pub(super) forcing: f64,
    pub(super) near_kernel: &'a (dyn Fn() -> NearKernel + 'a),
    pub(super) factorizer: &'a mut Factorizer<D>,
}

impl<'a, const D: usize> NewtonSystem<'a, D> {
    /// `K`: the Hessian, or what a [`ProjectionPolicy`](super::ProjectionPolicy) makes of it.
    pub fn tangent(&self) -> Tangent<'a, D> {
        self.tangent
    }
    /// `x`, where the step starts.
    pub fn at(&self) -> &'a [f64] {
        self.at
    }
    /// `g`, in the unit of the problem's gradient.
    pub fn gradient(&self) -> &'a [f64] {
        self.gradient
    }
    /// The accuracy `η` that the step deserves, `‖K dx + g‖ ≤ η ‖g‖`.
    pub fn forcing(&self) -> f64 {
        self.forcing
    }
    /// The problem's vectors of nearly no curvature at [`at`](Self::at).
    pub fn near_kernel(&self) -> NearKernel {
        (self.near_kernel)()
    }
    /// `−g`.
    pub fn right_hand_side(&self) -> Vec<f64> {
        self.gradient.iter().map(|g| -g).collect()
    }
    /// The analysis of the matrix, made once in the life of the solver.
    ///
    /// # Errors
    /// [`NewtonFailure::NeedsMatrix`] when the problem only gives products.
    pub fn symbolic(&mut self) -> Result<Arc<SymbolicCholesky<D>>, NewtonFailure> {
        Ok(self.factorizer.symbolic(self.tangent.assembled()?).clone())
    }
    /// Solves by sparse Cholesky in `f64`, in memory that the solver keeps.
    ///
    /// # Errors
    /// [`NewtonFailure::NeedsMatrix`] when the problem only gives products, and whatever stops a
    /// factorization other than an indefinite matrix, which is an outcome.
    pub fn solve_directly(&mut self, dx: &mut [f64]) -> Result<Descent, NewtonFailure> {
        direct::solve(self, dx)
    }
}

/// How Newton's method gets its direction, in place of a [`LinearSolver`]; what it keeps in itself it
/// remembers from step to step and from solve to solve.
pub trait DescentDirection<const D: usize>: Send + Sync {
    /// Writes `dx` with `‖K dx + g‖ ≤ η ‖g‖`. `dx` has the length of `g` and is zero on entry.
    ///
    /// # Errors
    /// What ends the whole solve; a matrix that is only indefinite is an outcome.
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure>;

    /// Drops what earlier systems have left: the next direction is to depend on its own system alone.
    fn forget(&mut self) {}
}

/// The policy of a setting, with nothing remembered yet.
pub(super) fn policy<const D: usize>(solver: LinearSolver) -> Box<dyn DescentDirection<D>> {
    match solver {
        LinearSolver::Direct => Box::new(direct::Direct),
        LinearSolver::DirectSingle => Box::new(single::Single::default()),
        LinearSolver::QrLeastSquares => Box::new(dense_qr::DenseQr),
        LinearSolver::Auto => Box::new(auto::Auto::default()),
        LinearSolver::Pcg {
            preconditioner,
            max_iterations: budget,
        } => match preconditioner {
            PreconditionerChoice::Identity => Box::new(PcgDirection::new(Identity, budget)),
            PreconditionerChoice::BlockJacobi => {
                Box::new(PcgDirection::new(BlockJacobi::default(), budget))
            }
            PreconditionerChoice::BlockIc0 => {
                Box::new(PcgDirection::new(BlockIc0::default(), budget))
            }
        },
    }
}
