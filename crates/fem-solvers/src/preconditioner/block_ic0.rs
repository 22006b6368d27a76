//! Incomplete Cholesky without fill, in blocks.

use super::PreconditionerError;
use crate::block_matrix::{BlockPattern, BlockSymmetric};
use crate::operator::{MatrixPreconditioner, Preconditioner};
use crate::small;
use std::sync::Arc;

/// `L Lᵀ ≈ A + shift · diag(A)` with `L` on the pattern of the lower half of `A`.
///
/// The factorization need not exist for every positive definite matrix. When a pivot block is not
/// positive definite, it starts over with a larger shift (Manteuffel 1980). The default is for a matrix
/// without rows, to be [updated](MatrixPreconditioner::update) before use; an update keeps the memory,
/// and after one that failed the preconditioner is unusable until another succeeds.
#[derive(Clone, Debug, Default)]
pub struct BlockIc0<const D: usize> {
    pattern: Arc<BlockPattern>,
    /// Strictly lower blocks of `L`; at the diagonal, the inverse of the pivot block's factor.
    values: Vec<[[f64; D]; D]>,
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
    pub(super) fn memory(&self) -> *const [[f64; D]; D] {
        self.values.as_ptr()
    }

    /// The relative diagonal shift that was needed, 0 when none was.
    pub fn shift(&self) -> f64 {
        self.shift
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

/// Row by row, in place; `Err` is the block row whose pivot is not positive definite.
fn factor<const D: usize>(
    pattern: &BlockPattern,
    values: &mut [[[f64; D]; D]],
    shift: f64,
) -> Result<(), usize> {
    let start = pattern.row_start();
    let columns = pattern.columns();
    for i in 0..pattern.blocks() {
        let diagonal = pattern.diagonal(i);
        for r in 0..D {
            values[diagonal][r][r] *= 1.0 + shift;
        }
        for k in start[i]..=diagonal {
            let j = columns[k] as usize;
            // A_ij − Σ_m L_im L_jmᵀ over the columns m < j that both rows have
            let mut a = values[k];
            let (mut p, mut q) = (start[i], start[j]);
            let end_q = pattern.diagonal(j);
            while p < k && q < end_q {
                let (cp, cq) = (columns[p], columns[q]);
                if cp == cq {
                    small::subtract_product_transposed(&mut a, &values[p], &values[q]);
                    p += 1;
                    q += 1;
                } else if cp < cq {
                    p += 1;
                } else {
                    q += 1;
                }
            }
            if j == i {
                let l = small::cholesky(&a).ok_or(i)?;
                values[k] = small::lower_inverse(&l);
            } else {
                // L_ij = A_ij L_jj⁻ᵀ
                let inverse = values[end_q];
                let mut l = [[0.0; D]; D];
                for r in 0..D {
                    for c in 0..D {
                        l[r][c] = (0..=c).map(|m| a[r][m] * inverse[c][m]).sum();
                    }
                }
                values[k] = l;
            }
        }
    }
    Ok(())
}

impl<const D: usize> Preconditioner for BlockIc0<D> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        z.copy_from_slice(r);
        let (z, _) = z.as_chunks_mut::<D>();
        let start = self.pattern.row_start();
        let columns = self.pattern.columns();
        for i in 0..self.pattern.blocks() {
            let diagonal = self.pattern.diagonal(i);
            let mut sum = z[i];
            for k in start[i]..diagonal {
                let l = &self.values[k];
                let x = z[columns[k] as usize];
                for a in 0..D {
                    for b in 0..D {
                        sum[a] -= l[a][b] * x[b];
                    }
                }
            }
            let inverse = &self.values[diagonal];
            for a in 0..D {
                z[i][a] = (0..=a).map(|b| inverse[a][b] * sum[b]).sum();
            }
        }
        for i in (0..self.pattern.blocks()).rev() {
            let diagonal = self.pattern.diagonal(i);
            let inverse = &self.values[diagonal];
            let mut x = [0.0; D];
            for a in 0..D {
                x[a] = (a..D).map(|b| inverse[b][a] * z[i][b]).sum();
            }
            z[i] = x;
            for k in start[i]..diagonal {
                let l = &self.values[k];
                let target = &mut z[columns[k] as usize];
                for b in 0..D {
                    for a in 0..D {
                        target[b] -= l[a][b] * x[a];
                    }
                }
            }
        }
    }
}

impl<const D: usize> MatrixPreconditioner<D> for BlockIc0<D> {
    fn update(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        check(matrix)?;
        self.pattern.clone_from(matrix.pattern());
        self.values.clear();
        self.values.extend_from_slice(matrix.values());
        self.shift = 0.0;
        while let Err(block) = factor(&self.pattern, &mut self.values, self.shift) {
            if self.shift >= LAST_SHIFT {
                return Err(PreconditionerError::Breakdown {
                    block,
                    shift: self.shift,
                });
            }
            self.shift = (10.0 * self.shift).max(FIRST_SHIFT);
            self.values.copy_from_slice(matrix.values());
        }
        Ok(())
    }
}
