//! The product of some rows of the stored half with a vector.

use super::BlockSymmetric;
use crate::small::numbers;
use fem_kinematics::{Quad, QuadKernel, dispatch_quads};
use std::ops::Range;

/// What the rows are, and where products go.
pub(super) struct RowsProduct<'a, const D: usize> {
    pub matrix: &'a BlockSymmetric<D>,
    pub rows: Range<usize>,
    /// The smallest column in these rows.
    pub first_column: usize,
    pub x: &'a [[f64; D]],
    /// What falls on these rows; overwritten.
    pub own: &'a mut [[f64; D]],
}

impl<const D: usize> RowsProduct<'_, D> {
    /// Returns what falls on earlier rows, from `first_column` on.
    pub fn run(self) -> Vec<[f64; D]> {
        let before = self.rows.start.saturating_sub(self.first_column);
        let mut before = vec![[0.0; D]; before];
        self.own.fill([0.0; D]);
        if D == 3 {
            dispatch_quads(OfThree {
                rows: self.rows,
                first_column: self.first_column,
                start: self.matrix.pattern().row_start(),
                columns: self.matrix.pattern().columns(),
                values: self.matrix.values().as_flattened().as_flattened(),
                x: self.x.as_flattened(),
                own: self.own.as_flattened_mut().as_chunks_mut().0,
                before: before.as_flattened_mut().as_chunks_mut().0,
            });
        } else {
            self.one_by_one(&mut before);
        }
        before
    }

    fn one_by_one(self, before: &mut [[f64; D]]) {
        let (pattern, begin) = (self.matrix.pattern(), self.rows.start);
        for i in self.rows {
            let stored = pattern.row_start()[i]..pattern.diagonal(i);
            let xi = self.x[i];
            let mut yi = [0.0; D];
            for k in stored {
                let (j, a) = (pattern.columns()[k] as usize, &self.matrix.values()[k]);
                let xj = self.x[j];
                let target = if j >= begin {
                    &mut self.own[j - begin]
                } else {
                    &mut before[j - self.first_column]
                };
                for r in 0..D {
                    for c in 0..D {
                        yi[r] += a[r][c] * xj[c];
                        target[c] += a[r][c] * xi[r];
                    }
                }
            }
            let a = self.matrix.diagonal_block(i);
            for r in 0..D {
                for c in 0..D {
                    yi[r] += a[r][c] * xi[c];
                }
                self.own[i - begin][r] += yi[r];
            }
        }
    }
}

/// Blocks of solids, their rows in registers: what stands behind three numbers is read and never used.
struct OfThree<'a> {
    rows: Range<usize>,
    first_column: usize,
    start: &'a [usize],
    columns: &'a [u32],
    values: &'a [f64],
    x: &'a [f64],
    own: &'a mut [[f64; 3]],
    before: &'a mut [[f64; 3]],
}

impl QuadKernel<f64> for OfThree<'_> {
    type Output = ();

    #[inline(always)]
    fn run<Q: Quad<f64>>(self) {
        let begin = self.rows.start;
        for i in self.rows {
            let diagonal = self.start[i + 1] - 1;
            let xi: [f64; 3] = *numbers(self.x, 3 * i);
            let all: [Q; 3] = [Q::splat(xi[0]), Q::splat(xi[1]), Q::splat(xi[2])];
            let mut sums = [Q::splat(0.0); 3];
            for k in self.start[i]..diagonal {
                let j = self.columns[k] as usize;
                // Behind what is not on the diagonal there is another block, and another row.
                let (a, xj) = (&self.values[9 * k..][..10], Q::load(numbers(self.x, 3 * j)));
                let (a0, a1, a2) = (
                    Q::load(numbers(a, 0)),
                    Q::load(numbers(a, 3)),
                    Q::load(numbers(a, 6)),
                );
                sums = [sums[0] + a0 * xj, sums[1] + a1 * xj, sums[2] + a2 * xj];
                let yj = a0 * all[0] + a1 * all[1] + a2 * all[2];
                let target = if j >= begin {
                    &mut self.own[j - begin]
                } else {
                    &mut self.before[j - self.first_column]
                };
                (Q::load_three(target) + yj).store_three(target);
            }
            let (a, x) = (&self.values[9 * diagonal..][..9], Q::load_three(&xi));
            for r in 0..3 {
                sums[r] = sums[r] + Q::load_three(numbers(a, 3 * r)) * x;
            }
            let [x, y, z, _] = Q::transposed([sums[0], sums[1], sums[2], Q::splat(0.0)]);
            let own = &mut self.own[i - begin];
            (Q::load_three(own) + (x + y + z)).store_three(own);
        }
    }
}
