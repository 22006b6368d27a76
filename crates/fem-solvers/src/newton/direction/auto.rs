//! [`LinearSolver::Auto`](crate::LinearSolver): the default, decided by counting operations.

use super::single::Single;
use super::thrifty::Thrifty;
use super::{Descent, DescentDirection, DescentOutcome, NewtonSystem, PcgDirection};
use crate::newton::NewtonFailure;
use crate::preconditioner::Identity;

/// Flops of a factorization below which nothing else is tried.
const CHEAP_FACTOR: f64 = 4e8;
/// Products in one step of a problem that has no matrix.
const PRODUCTS: usize = 2_000;

/// Small systems directly; larger ones by conjugate gradients until these prove dearer than a
/// factorization, from then on by an `f32` factor. Without a matrix plain conjugate gradients.
pub(super) struct Auto<const D: usize> {
    iterative: Option<Box<Thrifty<D>>>,
    single: Single<D>,
    prefer_direct: bool,
}

impl<const D: usize> Default for Auto<D> {
    fn default() -> Self {
        Self {
            iterative: None,
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
        let symbolic = system.symbolic()?;
        if symbolic.flops() < CHEAP_FACTOR {
            return system.solve_directly(dx);
        }
        if self.prefer_direct {
            return self.single.direction(system, dx);
        }
        let iterative = self.iterative.get_or_insert_with(|| {
            let motions = || system.near_kernel().count();
            Box::new(Thrifty::new(matrix, &symbolic, motions))
        });
        let found = iterative.direction(system, dx)?;
        if found.outcome != DescentOutcome::TooSlow {
            return Ok(found);
        }
        self.prefer_direct = true;
        self.iterative = None;
        Ok(self.single.direction(system, dx)?.after(found))
    }
}
