//! [`LinearSolver::Auto`](crate::LinearSolver): the default, decided by counting operations.

use super::single::Single;
use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem, PcgDirection};
use crate::newton::NewtonFailure;
use crate::preconditioner::{BlockIc0, Identity};

/// Flops of a factorization below which nothing else is tried.
const CHEAP_FACTOR: f64 = 4e8;
/// Flops of a dense front that take as long as moving one byte of a sparse product.
const FLOPS_PER_BYTE: f64 = 4.0;
/// Products in one step of a problem that has no matrix.
const PRODUCTS: usize = 2_000;

/// Small systems directly; larger ones by conjugate gradients until these prove dearer than a
/// factorization, from then on by an `f32` factor. Without a matrix plain conjugate gradients.
pub(super) struct Auto<const D: usize> {
    iterative: PcgDirection<BlockIc0<D>>,
    single: Single<D>,
    prefer_direct: bool,
}

impl<const D: usize> Default for Auto<D> {
    fn default() -> Self {
        Self {
            iterative: PcgDirection::new(BlockIc0::default(), 0),
            single: Single::default(),
            prefer_direct: false,
        }
    }
}

impl<const D: usize> DescentDirection<D> for Auto<D> {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, D>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let Some(matrix) = system.tangent.matrix() else {
            return PcgDirection::new(Identity, PRODUCTS).direction(system, dx);
        };
        let flops = system.symbolic()?.flops();
        if flops < CHEAP_FACTOR {
            return system.solve_directly(dx);
        }
        if self.prefer_direct {
            return self.single.direction(system, dx);
        }
        // One iteration moves the matrix once and its incomplete factor, in f32, twice.
        let bytes = 2.0 * (8 * D * D * matrix.pattern().stored()) as f64;
        let budget = (flops / (FLOPS_PER_BYTE * bytes)).ceil() as usize;
        self.iterative.set_budget(budget);
        let found = self.iterative.direction(system, dx)?;
        if found.outcome != DescentOutcome::TooSlow {
            return Ok(found);
        }
        self.prefer_direct = true;
        Ok(self.single.direction(system, dx)?.after(found))
    }
}
