//! A product for several right-hand sides, the matrix read once for all of them.

use crate::block_matrix::BlockSymmetric;
use crate::multigrid::rows::Rows;
use crate::parallel::map;
use fem_kinematics::{Kernel, dispatch};
use std::ops::Range;

/// `Y = A X`, the numbers of `B` right-hand sides side by side in each place; `rows` are those of the
/// matrix. Each row has one owner, so that no sum crosses a task.
pub fn product<const D: usize, const B: usize>(
    rows: &Rows,
    matrix: &BlockSymmetric<D>,
    x: &[[f64; B]],
    y: &mut [[f64; B]],
) {
    let (x, _) = x.as_chunks::<D>();
    let (y, _) = y.as_chunks_mut::<D>();
    let _: Vec<()> = map(rows.cut::<D, _>(y, Range::len), |(own, y)| {
        dispatch(Product {
            rows,
            stored: matrix.values(),
            own,
            x,
            y,
        });
    });
}

struct Product<'a, const D: usize, const B: usize> {
    rows: &'a Rows,
    stored: &'a [[[f64; D]; D]],
    own: Range<usize>,
    x: &'a [[[f64; B]; D]],
    y: &'a mut [[[f64; B]; D]],
}

impl<const D: usize, const B: usize> Kernel for Product<'_, D, B> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (row, y) in self.own.zip(self.y) {
            let mut sum = [[0.0; B]; D];
            for entry in self.rows.entries_of(row) {
                let a = self.rows.block(self.stored, row, entry);
                let x = &self.x[self.rows.column(entry)];
                for r in 0..D {
                    for c in 0..D {
                        for k in 0..B {
                            sum[r][k] += a[r][c] * x[c][k];
                        }
                    }
                }
            }
            *y = sum;
        }
    }
}
