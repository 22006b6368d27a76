//! The numeric factorization.

use super::dense::FactorScalar;
use super::symbolic::{Orientation, Supernode, SymbolicCholesky};
use crate::block_matrix::{BlockPattern, BlockSymmetric};
use crate::parallel::map;
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

/// Arithmetic below which a subtree is one task.
pub(super) const TASK_FLOPS: f64 = 2e6;
/// Deepest nesting of tasks; below, a subtree is done in a loop.
pub(super) const TASK_DEPTH: usize = 48;

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
        let task = Task { symbolic, matrix };
        let roots: Vec<usize> = (0..symbolic.supernodes.len())
            .filter(|&s| symbolic.supernodes[s].parent == super::elimination_tree::NO_PARENT)
            .collect();
        let outcome = task.children(&roots, &mut self.panels, 0);
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

struct Task<'a, const D: usize> {
    symbolic: &'a SymbolicCholesky<D>,
    matrix: &'a BlockSymmetric<D>,
}

impl<const D: usize> Task<'_, D> {
    /// The update matrices of several subtrees, which are neighbors in storage.
    fn children<T: FactorScalar>(
        &self,
        nodes: &[usize],
        panels: &mut [T],
        depth: usize,
    ) -> Result<Vec<Vec<T>>, CholeskyError> {
        let mut tasks = Vec::with_capacity(nodes.len());
        let mut rest = panels;
        for &s in nodes {
            let (own, tail) = rest.split_at_mut(self.subtree_scalars(s));
            tasks.push((s, own));
            rest = tail;
        }
        map(tasks, |(s, own)| self.subtree(s, own, depth))
    }

    fn subtree_scalars(&self, s: usize) -> usize {
        let node = &self.symbolic.supernodes[s];
        let end = self
            .symbolic
            .supernodes
            .get(s + 1)
            .map_or(self.symbolic.panel_scalars, |next| next.panel);
        end - self.symbolic.supernodes[node.subtree].panel
    }

    /// Factors the subtree of `s`, whose panels are `panels`, and returns the update matrix of `s`.
    fn subtree<T: FactorScalar>(
        &self,
        s: usize,
        panels: &mut [T],
        depth: usize,
    ) -> Result<Vec<T>, CholeskyError> {
        let nodes = &self.symbolic.supernodes;
        let node = &nodes[s];
        if node.subtree_flops < TASK_FLOPS || depth >= TASK_DEPTH {
            // Postorder: the updates of the children are the last ones on the stack.
            let mut stack: Vec<Vec<T>> = Vec::new();
            let mut rest = panels;
            for t in node.subtree..=s {
                let size = nodes[t].height() * nodes[t].width();
                let (own, tail) = rest.split_at_mut(size);
                rest = tail;
                let first = stack.len() - nodes[t].children.len();
                let update = self.front(&nodes[t], own, &stack[first..])?;
                stack.truncate(first);
                stack.push(update);
            }
            return Ok(stack.pop().unwrap_or_default());
        }
        let own_size = node.height() * node.width();
        let (below, own) = panels.split_at_mut(panels.len() - own_size);
        let children: Vec<usize> = node.children.iter().map(|&c| c as usize).collect();
        let updates = self.children(&children, below, depth + 1)?;
        self.front(node, own, &updates)
    }

    /// Assembles and eliminates one front.
    fn front<T: FactorScalar>(
        &self,
        node: &Supernode,
        panel: &mut [T],
        updates: &[Vec<T>],
    ) -> Result<Vec<T>, CholeskyError> {
        let zero = T::from_f64(0.0);
        let (height, columns, rows) = (node.height(), node.width(), node.below);
        panel.fill(zero);
        for entry in &node.entries {
            let block = &self.matrix.values()[entry.source as usize];
            let corner = entry.column as usize * height + entry.row as usize;
            for c in 0..D {
                for r in 0..D {
                    let value = match entry.orientation {
                        Orientation::AsStored => block[r][c],
                        Orientation::Transposed => block[c][r],
                    };
                    panel[corner + c * height + r] = T::from_f64(value);
                }
            }
        }
        let stored = self.matrix.values().as_flattened().as_flattened();
        for piece in &node.pieces {
            panel[piece.to] = T::from_f64(stored[piece.source]);
        }
        let mut update = vec![zero; rows * rows];
        for (&child, values) in node.children.iter().zip(updates) {
            extend_add(
                &self.symbolic.supernodes[child as usize],
                values,
                panel,
                &mut update,
                columns,
                rows,
            );
        }
        T::eliminate(panel, height, columns, &mut update).map_err(|column| {
            let place = self.symbolic.places[node.scalars.start + column];
            CholeskyError::NotPositiveDefinite {
                block_row: place / D,
                axis: place % D,
            }
        })?;
        Ok(update)
    }
}

/// Adds a child's update matrix into its parent's front, lower half.
fn extend_add<T: FactorScalar>(
    child: &Supernode,
    values: &[T],
    panel: &mut [T],
    update: &mut [T],
    columns: usize,
    rows: usize,
) {
    let child_rows = child.below;
    let height = columns + rows;
    for (at, column_run) in child.runs.iter().enumerate() {
        for c in 0..column_run.len as usize {
            let from = column_run.from as usize + c;
            let to = column_run.to as usize + c;
            let source = &values[from * child_rows..(from + 1) * child_rows];
            for (k, row_run) in child.runs[at..].iter().enumerate() {
                // In the run of the column itself, start at the diagonal.
                let skip = if k == 0 { c } else { 0 };
                let len = row_run.len as usize - skip;
                let (row_from, row_to) = (row_run.from as usize + skip, row_run.to as usize + skip);
                let target = if to < columns {
                    &mut panel[to * height + row_to..][..len]
                } else {
                    &mut update[(to - columns) * rows + row_to - columns..][..len]
                };
                for (t, s) in target.iter_mut().zip(&source[row_from..row_from + len]) {
                    *t += *s;
                }
            }
        }
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
