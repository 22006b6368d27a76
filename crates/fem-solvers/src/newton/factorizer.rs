//! The sparse factorization that a solver and all its directions share.

use crate::block_matrix::BlockSymmetric;
use crate::cholesky::{CholeskyError, CholeskyFactor, SymbolicCholesky};
use std::sync::Arc;

/// The analysis, made on first use, and one factor in `f64`; both for the life of the solver.
pub(super) struct Factorizer<const D: usize> {
    coordinates: Option<Vec<[f64; D]>>,
    symbolic: Option<Arc<SymbolicCholesky<D>>>,
    factor: Option<CholeskyFactor<f64, D>>,
}

impl<const D: usize> Factorizer<D> {
    pub fn new(coordinates: Option<Vec<[f64; D]>>) -> Self {
        Self {
            coordinates,
            symbolic: None,
            factor: None,
        }
    }

    pub fn symbolic(&mut self, matrix: &BlockSymmetric<D>) -> &Arc<SymbolicCholesky<D>> {
        let (pattern, coordinates) = (matrix.pattern(), &self.coordinates);
        self.symbolic.get_or_insert_with(|| {
            Arc::new(match coordinates {
                Some(points) => SymbolicCholesky::with_coordinates(pattern, points),
                None => SymbolicCholesky::new(pattern),
            })
        })
    }

    /// For directions of descent: pivots of rounding are taken.
    pub fn factor(
        &mut self,
        matrix: &BlockSymmetric<D>,
    ) -> Result<&CholeskyFactor<f64, D>, CholeskyError> {
        let symbolic = self.symbolic(matrix).clone();
        let factor = self
            .factor
            .get_or_insert_with(|| CholeskyFactor::allocate(&symbolic));
        factor.refill(matrix)?;
        Ok(factor)
    }

    /// The factor made last, to keep; the next one is made in new memory.
    pub fn take(&mut self) -> Option<CholeskyFactor<f64, D>> {
        self.factor.take()
    }
}
