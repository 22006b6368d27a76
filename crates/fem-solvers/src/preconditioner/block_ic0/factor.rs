//! The factorization, row by row.

use super::BlockIc0;
use super::order::{Order, Source};
use crate::block_matrix::BlockSymmetric;
use crate::parallel::map;
use crate::small;
use std::array::from_fn;
use std::ops::Range;

impl<const D: usize> BlockIc0<D> {
    /// Factors `scale (A + shift diag(A))`; `Err` is a block row whose pivot is not positive definite.
    pub(super) fn factor(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), usize> {
        let order = &self.order;
        let task = Task {
            order,
            matrix,
            scale: self.scale,
            shift: self.shift,
        };
        let (parts, _) = order.cut(&mut self.blocks, |rows| order.entries(rows));
        let factored: Vec<Result<(), usize>> = map(parts, |(part, own)| {
            task.factor(part.rows.clone(), order.row_start[part.rows.start], own)
        });
        let factored: Result<(), usize> = factored.into_iter().collect();
        let all = factored.and_then(|()| task.factor(order.waiting(), 0, &mut self.blocks));
        all.map_err(|here| order.rows[here] as usize)
    }
}

struct Task<'a, const D: usize> {
    order: &'a Order,
    matrix: &'a BlockSymmetric<D>,
    scale: f64,
    shift: f64,
}

impl<const D: usize> Task<'_, D> {
    /// Entries from `first` on stand in `values`, and with them all rows that these rows have columns of.
    fn factor(
        &self,
        rows: Range<usize>,
        first: usize,
        values: &mut [[[f32; D]; D]],
    ) -> Result<(), usize> {
        let (start, columns) = (&self.order.row_start, &self.order.columns);
        for i in rows {
            let diagonal = start[i + 1] - 1;
            for k in start[i]..=diagonal {
                let j = columns[k] as usize;
                // A_ij − Σ_m L_im L_jmᵀ over the columns m < j that both rows have
                let mut a = self.entry(k);
                if j == i {
                    for r in 0..D {
                        a[r][r] *= 1.0 + self.shift;
                    }
                }
                let (mut p, mut q) = (start[i], start[j]);
                let end_q = start[j + 1] - 1;
                while p < k && q < end_q {
                    let (cp, cq) = (columns[p], columns[q]);
                    if cp == cq {
                        let (lp, lq) = (widened(&values[p - first]), widened(&values[q - first]));
                        small::subtract_product_transposed(&mut a, &lp, &lq);
                    }
                    p += usize::from(cp <= cq);
                    q += usize::from(cq <= cp);
                }
                let l = if j == i {
                    small::lower_inverse(&small::cholesky(&a).ok_or(i)?)
                } else {
                    times_transposed(&a, &widened(&values[end_q - first]))
                };
                values[k - first] = l.map(|row| row.map(|v| v as f32));
            }
        }
        Ok(())
    }

    fn entry(&self, k: usize) -> [[f64; D]; D] {
        let Source { block, transposed } = self.order.sources[k];
        let a = &self.matrix.values()[block];
        from_fn(|r| from_fn(|c| self.scale * if transposed { a[c][r] } else { a[r][c] }))
    }
}

fn widened<const D: usize>(block: &[[f32; D]; D]) -> [[f64; D]; D] {
    block.map(|row| row.map(f64::from))
}

/// `A Bᵀ`, `B` lower triangular.
fn times_transposed<const D: usize>(a: &[[f64; D]; D], b: &[[f64; D]; D]) -> [[f64; D]; D] {
    from_fn(|r| from_fn(|c| (0..=c).map(|m| a[r][m] * b[c][m]).sum()))
}
