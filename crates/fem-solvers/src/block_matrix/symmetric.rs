//! The values, and the product with a vector.

use super::BlockPattern;
use super::pattern::RowChunk;
use super::product::RowsProduct;
use crate::operator::{LinearOperator, Structure};
use crate::parallel::map;
use std::sync::Arc;

/// A symmetric matrix of D×D blocks, of which the lower half and the diagonal are stored.
///
/// `values()[k][r][c]` is row `r`, column `c` of stored block `k` of the [`BlockPattern`]. A block
/// `(i, j)` with `j < i` stands for itself and for its transpose at `(j, i)`; diagonal blocks are
/// stored in full.
///
/// Rows and columns of [absent](BlockPattern::with_absent) scalars are padding and no part of the system,
/// whatever they hold to a factorization, which does not read them. Products and the other
/// preconditioners work on whole blocks and need the padding of [`fill_padding`](Self::fill_padding): with
/// it, and 0 in the absent places of a vector, no number of the system depends on it.
#[derive(Clone, Debug)]
pub struct BlockSymmetric<const D: usize> {
    pattern: Arc<BlockPattern>,
    values: Vec<[[f64; D]; D]>,
    structure: Structure,
    /// Was nothing written since [`fill_padding`](Self::fill_padding)?
    padded: bool,
}

impl<const D: usize> BlockSymmetric<D> {
    /// The zero matrix on a pattern. It claims [`Structure::Symmetric`].
    pub fn zeros(pattern: Arc<BlockPattern>) -> Self {
        let values = vec![[[0.0; D]; D]; pattern.stored()];
        Self {
            pattern,
            values,
            structure: Structure::Symmetric,
            padded: false,
        }
    }

    /// The same matrix with another claim, which the caller vouches for.
    #[must_use]
    pub fn claiming(mut self, structure: Structure) -> Self {
        self.structure = structure;
        self
    }

    /// Where the blocks are.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// All stored blocks, row by row.
    pub fn values(&self) -> &[[[f64; D]; D]] {
        &self.values
    }

    /// All stored blocks, for the assembly to fill.
    pub fn values_mut(&mut self) -> &mut [[[f64; D]; D]] {
        self.padded = false;
        &mut self.values
    }

    /// The diagonal block of row `i`.
    pub fn diagonal_block(&self, i: usize) -> &[[f64; D]; D] {
        &self.values[self.pattern.diagonal(i)]
    }

    /// The scalar diagonal, padding included, length `D · blocks`.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.pattern.blocks())
            .flat_map(|i| {
                let block = self.diagonal_block(i);
                (0..D).map(move |r| block[r][r])
            })
            .collect()
    }

    /// Adds `shift` to every scalar diagonal entry.
    pub fn shift_diagonal(&mut self, shift: f64) {
        self.padded = false;
        for i in 0..self.pattern.blocks() {
            let k = self.pattern.diagonal(i);
            for r in 0..D {
                self.values[k][r][r] += shift;
            }
        }
    }

    /// The mean absolute diagonal entry of every row of blocks.
    pub fn mean_diagonals(&self) -> Vec<f64> {
        let mean =
            |block: &[[f64; D]; D]| (0..D).map(|r| block[r][r].abs()).sum::<f64>() / D as f64;
        (0..self.pattern.blocks())
            .map(|i| mean(self.diagonal_block(i)))
            .collect()
    }

    /// Adds `share · weights[i]` to every scalar diagonal entry of row `i` of blocks.
    pub fn add_to_diagonals(&mut self, weights: &[f64], share: f64) {
        self.padded = false;
        for (i, weight) in weights.iter().enumerate() {
            let k = self.pattern.diagonal(i);
            for r in 0..D {
                self.values[k][r][r] += share * weight;
            }
        }
    }

    /// Adds `share` times another matrix of the same pattern.
    pub(crate) fn add_scaled(&mut self, share: f64, other: &Self) {
        self.padded = false;
        for (block, added) in self.values.iter_mut().zip(&other.values) {
            for (row, added) in block.iter_mut().zip(added) {
                row.iter_mut().zip(added).for_each(|(a, b)| *a += share * b);
            }
        }
    }

    /// Overwrites the rows and columns of absent scalars: 0 off the diagonal, and on it the mean absolute
    /// value of the block's own diagonal, 1 in a block row without unknowns. Neither the largest entry of
    /// the diagonal nor a block's mean changes by it, and blocks are as invertible as without it.
    ///
    /// The matrix knows whether that is done: an assembly that pads what it gives away and a solver that
    /// pads what it is given cost it once.
    pub fn fill_padding(&mut self) {
        if self.padded || self.pattern.absent().is_empty() {
            return;
        }
        self.padded = true;
        let mut absent = vec![[false; D]; self.pattern.blocks()];
        for place in self.pattern.absent_places(D) {
            absent[place / D][place % D] = true;
        }
        for row in 0..self.pattern.blocks() {
            let stored = self.pattern.row_start()[row]..self.pattern.row_start()[row + 1];
            for k in stored {
                let column = self.pattern.columns()[k] as usize;
                let (rows, columns) = (&absent[row], &absent[column]);
                if rows.contains(&true) || columns.contains(&true) {
                    let padding = if column == row {
                        mean_present(&self.values[k], rows)
                    } else {
                        0.0
                    };
                    pad(&mut self.values[k], rows, columns, padding);
                }
            }
        }
    }

    /// `|A| |x|`: entry `i` is `Σ_j |A_ij| |x_j|`, 0 where a scalar is absent.
    pub(crate) fn absolute_product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; D * self.pattern.blocks()];
        for i in 0..self.pattern.blocks() {
            for k in self.pattern.row_start()[i]..self.pattern.row_start()[i + 1] {
                let j = self.pattern.columns()[k] as usize;
                for r in 0..D {
                    for c in 0..D {
                        let value = self.values[k][r][c].abs();
                        y[D * i + r] += value * x[D * j + c].abs();
                        if j != i {
                            y[D * j + c] += value * x[D * i + r].abs();
                        }
                    }
                }
            }
        }
        for place in self.pattern.absent_places(D) {
            y[place] = 0.0;
        }
        y
    }

    /// The whole matrix, padding included, both halves, row-major of size `dim × dim`.
    pub fn to_dense(&self) -> Vec<f64> {
        let n = D * self.pattern.blocks();
        let mut dense = vec![0.0; n * n];
        for i in 0..self.pattern.blocks() {
            for k in self.pattern.row_start()[i]..self.pattern.row_start()[i + 1] {
                let j = self.pattern.columns()[k] as usize;
                for r in 0..D {
                    for c in 0..D {
                        let value = self.values[k][r][c];
                        dense[(D * i + r) * n + D * j + c] = value;
                        if j != i {
                            dense[(D * j + c) * n + D * i + r] = value;
                        }
                    }
                }
            }
        }
        dense
    }
}

/// The mean absolute diagonal entry of the rows that are there, 1 if there is none.
fn mean_present<const D: usize>(block: &[[f64; D]; D], absent: &[bool; D]) -> f64 {
    let present = || (0..D).filter(|&r| !absent[r]);
    match present().count() {
        0 => 1.0,
        count => present().map(|r| block[r][r].abs()).sum::<f64>() / count as f64,
    }
}

/// Absent rows and columns of a block become 0, with `diagonal` where they cross themselves.
fn pad<const D: usize>(
    block: &mut [[f64; D]; D],
    rows: &[bool; D],
    columns: &[bool; D],
    diagonal: f64,
) {
    for r in 0..D {
        for c in 0..D {
            if rows[r] || columns[c] {
                block[r][c] = if r == c { diagonal } else { 0.0 };
            }
        }
    }
}

impl<const D: usize> LinearOperator for BlockSymmetric<D> {
    fn dim(&self) -> usize {
        D * self.pattern.blocks()
    }

    fn structure(&self) -> Structure {
        self.structure
    }

    /// Parallel over fixed runs of rows; the bits do not depend on the number of threads.
    ///
    /// # Panics
    /// If a slice is not [`dim`](LinearOperator::dim) long.
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        assert!(
            x.len() == self.dim() && y.len() == self.dim(),
            "slices must have length {}",
            self.dim()
        );
        let (x, _) = x.as_chunks::<D>();
        let (mut rest, _) = y.as_chunks_mut::<D>();
        let chunks = &self.pattern.chunks;
        let product = |chunk: &RowChunk, own| RowsProduct {
            matrix: self,
            rows: chunk.rows.clone(),
            first_column: chunk.first_column,
            x,
            own,
        };
        if let [only] = chunks.as_slice() {
            product(only, rest).run();
            return;
        }
        let mut tasks = Vec::with_capacity(chunks.len());
        for chunk in chunks {
            let (own, tail) = rest.split_at_mut(chunk.rows.len());
            tasks.push((chunk, own));
            rest = tail;
        }
        let before: Vec<Vec<[f64; D]>> = map(tasks, |(chunk, own)| product(chunk, own).run());
        let (y, _) = y.as_chunks_mut::<D>();
        for (chunk, part) in chunks.iter().zip(&before) {
            for (target, value) in y[chunk.first_column.min(chunk.rows.start)..]
                .iter_mut()
                .zip(part)
            {
                for c in 0..D {
                    target[c] += value[c];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BlockSymmetric;
    use crate::BlockPattern;
    use std::sync::Arc;

    /// |A| |x| of [[2, −3, 0], [−3, 5, 7], [0, 7, −1]] and (4, −10, 0.5).
    #[test]
    fn absolute_products_take_no_sign() {
        let pattern = BlockPattern::from_adjacency(3, [(0, 1), (1, 2)]).unwrap();
        let mut a = BlockSymmetric::<1>::zeros(Arc::new(pattern));
        let dense = [[2.0, -3.0, 0.0], [-3.0, 5.0, 7.0], [0.0, 7.0, -1.0]];
        let (starts, columns) = (
            a.pattern().row_start().to_vec(),
            a.pattern().columns().to_vec(),
        );
        for i in 0..3 {
            for k in starts[i]..starts[i + 1] {
                a.values_mut()[k] = [[dense[i][columns[k] as usize]]];
            }
        }
        assert_eq!(a.absolute_product(&[4.0, -10.0, 0.5]), [38.0, 65.5, 70.5]);
    }
    #[test]
    fn padding_is_filled_again_after_everything_that_writes() {
        let pattern = BlockPattern::from_adjacency(1, []).unwrap();
        let pattern = pattern.with_absent([(0, 1)]).unwrap();
        let mut padded = BlockSymmetric::<2>::zeros(Arc::new(pattern));
        padded.values_mut()[0] = [[3.0, 7.0], [7.0, 5.0]];
        padded.fill_padding();
        assert_eq!(padded.values(), [[[3.0, 0.0], [0.0, 3.0]]]);
        // The entry becomes negative, the padding is its size.
        let writes: [&dyn Fn(&mut BlockSymmetric<2>); 4] = [
            &|a| a.values_mut()[0] = [[-2.0, 9.0], [9.0, -4.0]],
            &|a| a.shift_diagonal(-5.0),
            &|a| a.add_to_diagonals(&[-10.0], 0.5),
            &|a| a.add_scaled(-5.0 / 3.0, &padded),
        ];
        for write in writes {
            let mut a = padded.clone();
            write(&mut a);
            for _ in 0..2 {
                a.fill_padding();
                assert_eq!(a.values(), [[[-2.0, 0.0], [0.0, 2.0]]]);
            }
        }
    }
    #[test]
    fn an_absolute_product_leaves_padding_out() {
        let pattern = BlockPattern::from_adjacency(2, [(0, 1)]).unwrap();
        let pattern = pattern.with_absent([(1, 0)]).unwrap();
        let mut a = BlockSymmetric::<2>::zeros(Arc::new(pattern));
        for (k, block) in a.values_mut().iter_mut().enumerate() {
            *block = [[3.0, -1.0], [-1.0, k as f64]];
        }
        a.fill_padding();
        // [[3, −1, −1], [−1, 0, 1], [−1, 1, 2]] is what is left.
        assert_eq!(
            a.absolute_product(&[1.0, -2.0, 9.0, 4.0]),
            [9.0, 5.0, 0.0, 11.0]
        );
    }
}
