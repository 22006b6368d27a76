//! The numeric factorization.

use super::dense::FactorScalar;
use super::fronts::Fronts;
use super::pool::Pool;
use super::symbolic::SymbolicCholesky;
use crate::block_matrix::{BlockPattern, BlockSymmetric};
use std::sync::Arc;
use thiserror::Error;

/// Why a matrix could not be factored.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CholeskyError {
    /// The matrix is not positive definite, or too ill-conditioned for the precision of the factor.
    #[error(
        "not positive definite: the pivot of block row {block_row}, axis {axis}, is not positive beyond rounding"
    )]
    NotPositiveDefinite {
        /// Block row of the matrix, in its own numbering.
        block_row: usize,
        /// Row of the block.
        axis: usize,
    },
    /// The matrix holds a NaN, an infinity, or a value outside the range of the factor's scalar.
    #[error(
        "block row {block_row} holds a value that is not finite in the precision of the factor"
    )]
    NonFinite {
        /// Block row of the matrix, in its own numbering.
        block_row: usize,
    },
    /// The matrix lives on another pattern than the one that was analysed.
    #[error(
        "the matrix has {found} stored blocks in another pattern than the {expected} that were analysed"
    )]
    PatternMismatch {
        /// Stored blocks of the matrix.
        found: usize,
        /// Stored blocks of the analysed pattern.
        expected: usize,
    },
}

/// `P A Pᵀ = L Lᵀ` with `L` in precision `T`.
///
/// The bits of `L` do not depend on the number of threads: contributions are added in the order of
/// the children, and large kernels are cut by size alone.
#[derive(Clone, Debug)]
pub struct CholeskyFactor<T, const D: usize> {
    pub(super) symbolic: Arc<SymbolicCholesky<D>>,
    pub(super) panels: Vec<T>,
}

impl<T: FactorScalar, const D: usize> CholeskyFactor<T, D> {
    /// Factors a matrix on the analysed pattern.
    ///
    /// # Errors
    /// [`CholeskyError`] names the block row that failed.
    pub fn factor(
        symbolic: &Arc<SymbolicCholesky<D>>,
        matrix: &BlockSymmetric<D>,
    ) -> Result<Self, CholeskyError> {
        let mut factor = Self::allocate(symbolic);
        factor.refactor(matrix)?;
        Ok(factor)
    }

    /// Memory for a factor; to be filled by [`refactor`](Self::refactor) before use.
    pub(crate) fn allocate(symbolic: &Arc<SymbolicCholesky<D>>) -> Self {
        let panels = vec![T::from_f64(0.0); symbolic.panel_scalars];
        Self {
            symbolic: symbolic.clone(),
            panels,
        }
    }

    /// Factors another matrix on the same pattern into the same memory.
    ///
    /// # Errors
    /// [`CholeskyError`] names the block row that failed; the factor is unusable then until a
    /// `refactor` succeeds.
    pub fn refactor(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), CholeskyError> {
        self.refill(matrix)?;
        let checked = self.check_pivots(matrix);
        if checked.is_err() {
            self.spoil();
        }
        checked
    }

    /// [`refactor`](Self::refactor) that takes pivots of rounding for what they are: for a direction of
    /// descent, which is tried before it is taken. Far from a solution matrices are as ill-conditioned
    /// as they like.
    pub(crate) fn refill(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), CholeskyError> {
        let symbolic = &*self.symbolic;
        check(&symbolic.pattern, matrix, |v| {
            T::from_f64(v).to_f64().is_finite()
        })?;
        let fronts = Fronts {
            symbolic,
            matrix,
            pool: &Pool::new(),
        };
        let roots: Vec<usize> = (0..symbolic.supernodes.len())
            .filter(|&s| symbolic.supernodes[s].parent == super::elimination_tree::NO_PARENT)
            .collect();
        let outcome = fronts.children(&roots, &mut self.panels, 0).map(drop);
        if let Err(error) = outcome {
            self.spoil();
            return Err(error);
        }
        Ok(())
    }

    /// No numbers are better than wrong ones.
    fn spoil(&mut self) {
        self.panels.fill(T::from_f64(f64::NAN));
    }

    /// Refuses a matrix with a pivot that is all rounding ([`FactorScalar::SINGULAR`]).
    pub(crate) fn check_pivots(&self, matrix: &BlockSymmetric<D>) -> Result<(), CholeskyError> {
        let (share, place) = self.weakest(matrix);
        let (block_row, axis) = (place / D, place % D);
        if share > T::SINGULAR {
            Ok(())
        } else {
            Err(CholeskyError::NotPositiveDefinite { block_row, axis })
        }
    }

    /// The smallest share of a diagonal entry of `matrix`, which was factored, that was left as its
    /// pivot: about the rounding of the factor's precision where the matrix is singular.
    pub(crate) fn weakest_pivot(&self, matrix: &BlockSymmetric<D>) -> f64 {
        self.weakest(matrix).0
    }

    /// That share, and the place of its scalar.
    fn weakest(&self, matrix: &BlockSymmetric<D>) -> (f64, usize) {
        let symbolic = &*self.symbolic;
        let mut weakest = (1.0_f64, 0);
        for node in &symbolic.supernodes {
            let height = node.height();
            for (k, &place) in symbolic.places[node.scalars.clone()].iter().enumerate() {
                let (row, axis) = (place / D, place % D);
                let pivot = self.panels[node.panel + k * height + k].to_f64();
                let share = pivot * pivot / matrix.diagonal_block(row)[axis][axis];
                // NaN is the weakest of all.
                if !(share >= weakest.0) {
                    weakest = (share, place);
                }
            }
        }
        weakest
    }

    /// The analysis this factor was made with.
    pub fn symbolic(&self) -> &Arc<SymbolicCholesky<D>> {
        &self.symbolic
    }
}

fn check<const D: usize>(
    pattern: &Arc<BlockPattern>,
    matrix: &BlockSymmetric<D>,
    fits: impl Fn(f64) -> bool,
) -> Result<(), CholeskyError> {
    if !(Arc::ptr_eq(pattern, matrix.pattern()) || **pattern == **matrix.pattern()) {
        return Err(CholeskyError::PatternMismatch {
            found: matrix.pattern().stored(),
            expected: pattern.stored(),
        });
    }
    let row_of = |k: usize| pattern.row_start().partition_point(|&s| s <= k) - 1;
    let is_refused = |(k, block): &(usize, &[[f64; D]; D])| {
        if block.iter().flatten().all(|&v| fits(v)) {
            return false;
        }
        // Padding may be anything.
        let (row, column) = (row_of(*k), pattern.columns()[*k] as usize);
        (0..D * D).map(|at| (at / D, at % D)).any(|(r, c)| {
            !fits(block[r][c]) && !pattern.is_absent(row, r) && !pattern.is_absent(column, c)
        })
    };
    match matrix.values().iter().enumerate().find(is_refused) {
        None => Ok(()),
        Some((k, _)) => Err(CholeskyError::NonFinite {
            block_row: row_of(k),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of [[3, 1], [1, 4]], scattered over two blocks, 11/12 is left of the second pivot in either order.
    #[test]
    fn the_weakest_pivot_is_one_of_those_that_are_there() {
        let pattern =
            BlockPattern::from_adjacency(2, [(0, 1)]).and_then(|p| p.with_absent([(0, 0), (1, 1)]));
        let mut a = BlockSymmetric::<2>::zeros(Arc::new(pattern.unwrap()));
        let nothing = 1e9;
        a.values_mut().copy_from_slice(&[
            [[nothing, nothing], [nothing, 3.0]],
            [[nothing, 1.0], [nothing, nothing]],
            [[4.0, nothing], [nothing, nothing]],
        ]);
        let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
        let factor = CholeskyFactor::<f64, 2>::factor(&symbolic, &a).unwrap();
        assert!((factor.weakest_pivot(&a) - 11.0 / 12.0).abs() < 1e-15);
    }
}
