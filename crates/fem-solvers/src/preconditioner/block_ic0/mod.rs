//! Incomplete Cholesky without fill, in blocks.

mod factor;
mod order;
mod sweep;

use super::PreconditionerError;
use crate::block_matrix::{BlockPattern, BlockSymmetric};
use crate::operator::{MatrixPreconditioner, Preconditioner};
use crate::parallel::each;
use crate::small;
use crate::vector::norm_inf;
use order::Order;
use std::ops::Range;
use std::sync::Arc;
use sweep::Sweep;

/// `L Lᵀ ≈ A + shift · diag(A)` with `L` on the pattern of the lower half of `A`, kept in `f32`.
///
/// From a few thousand block rows on they are taken from both ends towards the middle (van der Vorst 1987),
/// by two threads where there are two, if the numbering of the rows allows it; bits do not depend on the
/// number of threads. `A` and what it is applied to may have any unit: both are brought to the range of
/// `f32` by powers of two.
///
/// The factorization need not exist for every positive definite matrix. When a pivot block is not
/// positive definite, it starts over with a larger shift (Manteuffel 1980). The default is for a matrix
/// without rows, to be [updated](MatrixPreconditioner::update) before use; an update keeps the memory,
/// and after one that failed the preconditioner is unusable until another succeeds.
#[derive(Clone, Debug, Default)]
pub struct BlockIc0<const D: usize> {
    pattern: Arc<BlockPattern>,
    order: Order,
    /// Strictly lower blocks of `L`; at the diagonal, the inverse of the pivot block's factor. One
    /// block more, which reading in whole registers reaches into.
    blocks: Vec<[[f32; D]; D]>,
    /// `L` is that of the matrix times this.
    scale: f64,
    shift: f64,
}

const FIRST_SHIFT: f64 = 1e-3;
const LAST_SHIFT: f64 = 10.0;

impl<const D: usize> BlockIc0<D> {
    /// Factors `A`, with growing diagonal shifts (0, 1e-3, 1e-2, 0.1, 1, 10) until it succeeds.
    ///
    /// # Errors
    /// [`PreconditionerError::NonFinite`] for NaN or infinite input,
    /// [`PreconditionerError::NotPositiveDefinite`] if a diagonal block of `A` is not positive
    /// definite, [`PreconditionerError::Breakdown`] if the largest shift does not help.
    pub fn new(matrix: &BlockSymmetric<D>) -> Result<Self, PreconditionerError> {
        let mut made = Self::default();
        made.update(matrix)?;
        Ok(made)
    }

    #[cfg(test)]
    pub(super) fn memory(&self) -> *const [[f32; D]; D] {
        self.blocks.as_ptr()
    }

    /// The relative diagonal shift that was needed, 0 when none was.
    pub fn shift(&self) -> f64 {
        self.shift
    }

    fn sweep(&self, rows: &Range<usize>, first: usize) -> Sweep<'_, D> {
        Sweep {
            order: &self.order,
            blocks: &self.blocks,
            rows: rows.clone(),
            first,
        }
    }

    /// Vectors in the order of the factor have `W` numbers a row.
    fn apply_in<const W: usize>(&self, r: &[f64], z: &mut [f64]) {
        let (order, waiting) = (&self.order, self.order.waiting());
        let ((r, _), (z, _)) = (r.as_chunks::<D>(), z.as_chunks_mut::<D>());
        let down = to_unit(norm_inf(r.as_flattened()));
        let take = |rows: &Range<usize>, own: &mut [[f32; W]]| {
            for (own, &row) in own.iter_mut().zip(&order.rows[rows.clone()]) {
                for (own, r) in own.iter_mut().zip(&r[row as usize]) {
                    *own = (r * down) as f32;
                }
            }
        };
        let mut all = vec![[0.0; W]; order.rows.len()];
        let (parts, last) = order.cut(&mut all, Range::len);
        each(parts, |(part, own)| {
            take(&part.rows, own);
            self.sweep(&part.rows, part.rows.start).forward(own);
        });
        take(&waiting, last);
        self.sweep(&waiting, 0).forward(&mut all);
        self.sweep(&waiting, 0).backward(&mut all);
        let (parts, last) = order.cut(&mut all, Range::len);
        let (mut tasks, mut rest) = (Vec::with_capacity(parts.len()), z);
        for (part, own) in parts {
            let (z, after) = rest.split_at_mut(part.of_matrix.len());
            tasks.push((part, own, z));
            rest = after;
        }
        let (last, up) = (&*last, self.scale / down);
        each(tasks, |(part, own, z)| {
            self.sweep(&part.rows, part.rows.start).backward(own);
            for (row, z) in part.of_matrix.clone().zip(z) {
                let place = order.place(row);
                let found = match place.checked_sub(waiting.start) {
                    Some(behind) => &last[behind],
                    None => &own[place - part.rows.start],
                };
                for (z, found) in z.iter_mut().zip(found) {
                    *z = f64::from(*found) * up;
                }
            }
        });
    }
}

/// The power of two that takes `largest` to between 1 and 2; 1 for what has no size.
fn to_unit(largest: f64) -> f64 {
    if largest > 0.0 && largest.is_finite() {
        (-largest.log2().floor()).clamp(-1000.0, 1000.0).exp2()
    } else {
        1.0
    }
}

/// Refuses what no shift repairs.
fn check<const D: usize>(matrix: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
    let (values, start) = (matrix.values(), matrix.pattern().row_start());
    for block in 0..matrix.pattern().blocks() {
        let row = &values[start[block]..start[block + 1]];
        if row.iter().flatten().flatten().any(|v| !v.is_finite()) {
            return Err(PreconditionerError::NonFinite { block });
        }
        if small::cholesky(matrix.diagonal_block(block)).is_none() {
            return Err(PreconditionerError::NotPositiveDefinite { block });
        }
    }
    Ok(())
}

impl<const D: usize> Preconditioner for BlockIc0<D> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        if D == 3 {
            self.apply_in::<4>(r, z);
        } else {
            self.apply_in::<D>(r, z);
        }
    }
}

impl<const D: usize> MatrixPreconditioner<D> for BlockIc0<D> {
    fn update(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        if !Arc::ptr_eq(&self.pattern, matrix.pattern()) {
            self.pattern.clone_from(matrix.pattern());
            self.order = Order::new(&self.pattern);
        }
        let length = self.order.columns.len() + 1;
        self.blocks.resize(length, [[0.0; D]; D]);
        self.scale = to_unit(norm_inf(&matrix.diagonal()));
        self.shift = 0.0;
        while let Err(block) = self.factor(matrix) {
            check(matrix)?;
            if self.shift >= LAST_SHIFT {
                return Err(PreconditionerError::Breakdown {
                    block,
                    shift: self.shift,
                });
            }
            self.shift = (10.0 * self.shift).max(FIRST_SHIFT);
        }
        Ok(())
    }
}
