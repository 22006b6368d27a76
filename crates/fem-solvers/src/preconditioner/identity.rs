//! No preconditioning.

use super::PreconditionerError;
use crate::block_matrix::BlockSymmetric;
use crate::operator::{LinearOperator, MatrixPreconditioner, Preconditioner};

/// `z = r`: plain conjugate gradients (document 000, Algorithm 1).
#[derive(Clone, Copy, Debug, Default)]
pub struct Identity;

impl Preconditioner for Identity {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        z.copy_from_slice(r);
    }
}

impl<const D: usize> MatrixPreconditioner<D> for Identity {
    fn update(&mut self, _: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        Ok(())
    }
    fn update_products(&mut self, _: &dyn LinearOperator) -> Result<(), PreconditionerError> {
        Ok(())
    }
}
