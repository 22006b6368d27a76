//! `L` and `Lᵀ` solved for, row after row.

use super::order::Order;
use crate::small::numbers;
use fem_kinematics::{Quad, QuadKernel, dispatch_quads};
use std::array::from_fn;
use std::ops::Range;

/// Consecutive rows of the factor, whose columns are rows `first` and later.
///
/// Vectors hold `W` numbers for a block row: `D`, or 4 for the blocks of solids, so that a row of a block
/// and what it meets are one register each. What stands beyond `D` is never used.
pub(super) struct Sweep<'a, const D: usize> {
    pub order: &'a Order,
    /// The blocks of all rows, and some numbers behind the last, for rows of them are read `W` wide.
    pub blocks: &'a [[[f32; D]; D]],
    pub rows: Range<usize>,
    pub first: usize,
}

impl<const D: usize> Sweep<'_, D> {
    /// `z ← L⁻¹ z`.
    pub fn forward<const W: usize>(self, z: &mut [[f32; W]]) {
        if let (3, Some(z)) = (D, quads(z)) {
            return dispatch_quads(Forward(self, z));
        }
        let (start, columns) = (&self.order.row_start, &self.order.columns);
        for i in self.rows {
            let diagonal = start[i + 1] - 1;
            let mut rest = z[i - self.first];
            for k in start[i]..diagonal {
                let (l, x) = (&self.blocks[k], z[columns[k] as usize - self.first]);
                for r in 0..D {
                    for c in 0..D {
                        rest[r] -= l[r][c] * x[c];
                    }
                }
            }
            let inverse = &self.blocks[diagonal];
            for r in 0..D {
                z[i - self.first][r] = (0..=r).map(|c| inverse[r][c] * rest[c]).sum();
            }
        }
    }

    /// `z ← L⁻ᵀ z`.
    pub fn backward<const W: usize>(self, z: &mut [[f32; W]]) {
        if let (3, Some(z)) = (D, quads(z)) {
            return dispatch_quads(Backward(self, z));
        }
        let (start, columns) = (&self.order.row_start, &self.order.columns);
        for i in self.rows.rev() {
            let diagonal = start[i + 1] - 1;
            let (inverse, row) = (&self.blocks[diagonal], &mut z[i - self.first]);
            let x: [f32; D] = from_fn(|c| (c..D).map(|r| inverse[r][c] * row[r]).sum());
            row[..D].copy_from_slice(&x);
            for k in start[i]..diagonal {
                let (l, target) = (&self.blocks[k], &mut z[columns[k] as usize - self.first]);
                for r in 0..D {
                    for c in 0..D {
                        target[c] -= l[r][c] * x[r];
                    }
                }
            }
        }
    }

    /// The rows of one block of three.
    #[inline(always)]
    fn registers<Q: Quad<f32>>(&self, values: &[f32], entry: usize) -> [Q; 3] {
        let block = &values[9 * entry..][..10];
        [
            Q::load(numbers(block, 0)),
            Q::load(numbers(block, 3)),
            Q::load(numbers(block, 6)),
        ]
    }
}

/// A vector of four numbers for each row, if it is one.
fn quads<const W: usize>(z: &mut [[f32; W]]) -> Option<&mut [[f32; 4]]> {
    (W == 4).then_some(z.as_flattened_mut().as_chunks_mut().0)
}

struct Forward<'a, const D: usize>(Sweep<'a, D>, &'a mut [[f32; 4]]);

impl<const D: usize> QuadKernel<f32> for Forward<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<Q: Quad<f32>>(self) {
        let Self(sweep, z) = self;
        let (start, columns) = (&sweep.order.row_start[..], &sweep.order.columns[..]);
        let values = sweep.blocks.as_flattened().as_flattened();
        for i in sweep.rows.clone() {
            let diagonal = start[i + 1] - 1;
            let mut sums = [Q::splat(0.0); 3];
            for k in start[i]..diagonal {
                let l: [Q; 3] = sweep.registers(values, k);
                let x = Q::load(&z[columns[k] as usize - sweep.first]);
                sums = [sums[0] + l[0] * x, sums[1] + l[1] * x, sums[2] + l[2] * x];
            }
            let inverse: [Q; 3] = sweep.registers(values, diagonal);
            let zero = Q::splat(0.0);
            let [x, y, w, _] = Q::transposed([sums[0], sums[1], sums[2], zero]);
            let row = &mut z[i - sweep.first];
            let rest = Q::load(row) - (x + y + w);
            let products = inverse.map(|row| row * rest);
            let [x, y, w, _] = Q::transposed([products[0], products[1], products[2], zero]);
            (x + y + w).store(row);
        }
    }
}

struct Backward<'a, const D: usize>(Sweep<'a, D>, &'a mut [[f32; 4]]);

impl<const D: usize> QuadKernel<f32> for Backward<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<Q: Quad<f32>>(self) {
        let Self(sweep, z) = self;
        let (start, columns) = (&sweep.order.row_start[..], &sweep.order.columns[..]);
        let values = sweep.blocks.as_flattened().as_flattened();
        for i in sweep.rows.clone().rev() {
            let diagonal = start[i + 1] - 1;
            let inverse: [Q; 3] = sweep.registers(values, diagonal);
            let row = &mut z[i - sweep.first];
            let [a, b, c] = [row[0], row[1], row[2]];
            let x = inverse[0] * Q::splat(a) + inverse[1] * Q::splat(b) + inverse[2] * Q::splat(c);
            x.store(row);
            let [a, b, c] = [Q::splat(row[0]), Q::splat(row[1]), Q::splat(row[2])];
            for k in start[i]..diagonal {
                let l: [Q; 3] = sweep.registers(values, k);
                let target = &mut z[columns[k] as usize - sweep.first];
                let product = l[0] * a + l[1] * b + l[2] * c;
                (Q::load(target) - product).store(target);
            }
        }
    }
}
