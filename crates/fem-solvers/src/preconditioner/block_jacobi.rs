//! The inverse of the block diagonal.

use crate::block_matrix::{BlockSymmetric, PatternError};
use crate::multigrid::NearKernelError;
use crate::operator::{MatrixPreconditioner, Preconditioner};
use crate::small;
use thiserror::Error;

/// Why no preconditioner could be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PreconditionerError {
    /// A diagonal block is not positive definite, so the matrix is not either.
    #[error("diagonal block {block} is not positive definite: the matrix is not either")]
    NotPositiveDefinite {
        /// Block row.
        block: usize,
    },
    /// The matrix holds a NaN or an infinity.
    #[error("block row {block} holds a value that is not finite")]
    NonFinite {
        /// Block row.
        block: usize,
    },
    /// Even a diagonal shift as large as the diagonal did not make the factorization exist.
    #[error(
        "incomplete Cholesky broke down at block row {block} for every shift up to {shift:e} of the diagonal"
    )]
    Breakdown {
        /// Block row of the last breakdown.
        block: usize,
        /// The last relative shift tried.
        shift: f64,
    },
    /// A direction of negative or no curvature turned up: the matrix is not positive definite.
    #[error(
        "the matrix of multigrid level {level} has a direction of negative or no curvature: it is not positive definite"
    )]
    NegativeCurvature {
        /// The level, 0 for the matrix itself.
        level: usize,
    },
    /// The near kernel does not fit the matrix.
    #[error(transparent)]
    NearKernel(#[from] NearKernelError),
    /// A coarse matrix is too large.
    #[error("a coarse matrix cannot be stored: {0}")]
    Coarse(#[from] PatternError),
    /// The preconditioner is made from a matrix, the problem gives only products.
    #[error(
        "this preconditioner is made from a matrix and there is none: bring one that needs none, or use Identity"
    )]
    NeedsMatrix,
}

/// `z_i = A_ii⁻¹ r_i` for each D×D diagonal block; the default is for a matrix without rows, to be
/// [updated](MatrixPreconditioner::update) before use.
#[derive(Clone, Debug, Default)]
pub struct BlockJacobi<const D: usize> {
    inverses: Vec<[[f64; D]; D]>,
}

impl<const D: usize> BlockJacobi<D> {
    /// Inverts the diagonal blocks.
    ///
    /// # Errors
    /// [`PreconditionerError`] names the first block that is not positive definite or not finite.
    pub fn new(matrix: &BlockSymmetric<D>) -> Result<Self, PreconditionerError> {
        let mut made = Self::default();
        made.update(matrix)?;
        Ok(made)
    }

    #[cfg(test)]
    pub(super) fn memory(&self) -> *const [[f64; D]; D] {
        self.inverses.as_ptr()
    }
}

impl<const D: usize> Preconditioner for BlockJacobi<D> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        let (r, _) = r.as_chunks::<D>();
        let (z, _) = z.as_chunks_mut::<D>();
        for ((inverse, r), z) in self.inverses.iter().zip(r).zip(z) {
            for i in 0..D {
                let mut sum = 0.0;
                for k in 0..D {
                    sum += inverse[i][k] * r[k];
                }
                z[i] = sum;
            }
        }
    }
}

impl<const D: usize> MatrixPreconditioner<D> for BlockJacobi<D> {
    fn update(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        self.inverses.clear();
        for block in 0..matrix.pattern().blocks() {
            let a = matrix.diagonal_block(block);
            if a.iter().flatten().any(|v| !v.is_finite()) {
                return Err(PreconditionerError::NonFinite { block });
            }
            let inverse = small::inverse_positive_definite(a)
                .ok_or(PreconditionerError::NotPositiveDefinite { block })?;
            self.inverses.push(inverse);
        }
        Ok(())
    }
}
