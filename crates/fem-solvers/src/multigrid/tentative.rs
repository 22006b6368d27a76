//! The near kernel, orthonormal on each aggregate.

use super::aggregation::{ALONE, Aggregates};
use crate::parallel::map;

/// Part of a vector below which it depends on those before it.
const DEPENDENT: f64 = 1e-9;

/// The prolongator before smoothing, `B = P̂ R`: its block in each row (one a row, in the column of
/// the row's aggregate), and the near kernel `R` of the coarse matrix.
#[derive(Clone, Debug)]
pub(super) struct Tentative<const D: usize, const K: usize> {
    pub blocks: Vec<[[f64; K]; D]>,
    /// Upper triangles. A zero on the diagonal means that the aggregate is too small for this vector:
    /// the column is zero and the coarse unknown stands for nothing.
    pub coarse: Vec<[[f64; K]; K]>,
}

impl<const D: usize, const K: usize> Tentative<D, K> {
    pub fn new(aggregates: &Aggregates, kernel: &[[[f64; K]; D]]) -> Self {
        let mut blocks = kernel.to_vec();
        for (block, _) in blocks
            .iter_mut()
            .zip(&aggregates.of_row)
            .filter(|(_, a)| **a == ALONE)
        {
            *block = [[0.0; K]; D];
        }
        let tasks = aggregates.members.chunks(256).collect();
        type Done<const D: usize, const K: usize> = Vec<(Vec<[[f64; K]; D]>, [[f64; K]; K])>;
        let done: Vec<Done<D, K>> = map(tasks, |groups: &[Vec<u32>]| {
            let own = |group: &Vec<u32>| group.iter().map(|&i| kernel[i as usize]).collect();
            groups.iter().map(|group| orthonormal(own(group))).collect()
        });
        let mut coarse = Vec::with_capacity(aggregates.count());
        for (group, (own, r)) in aggregates.members.iter().zip(done.into_iter().flatten()) {
            for (&i, block) in group.iter().zip(own) {
                blocks[i as usize] = block;
            }
            coarse.push(r);
        }
        Self { blocks, coarse }
    }
}

/// Gram and Schmidt, each vector twice.
fn orthonormal<const D: usize, const K: usize>(
    mut q: Vec<[[f64; K]; D]>,
) -> (Vec<[[f64; K]; D]>, [[f64; K]; K]) {
    let product = |q: &[[[f64; K]; D]], a: usize, b: usize| -> f64 {
        q.iter().flatten().map(|row| row[a] * row[b]).sum()
    };
    let mut r = [[0.0; K]; K];
    for k in 0..K {
        let size = product(&q, k, k).sqrt();
        for _ in 0..2 {
            for before in 0..k {
                let along = product(&q, before, k);
                r[before][k] += along;
                for row in q.iter_mut().flatten() {
                    row[k] -= along * row[before];
                }
            }
        }
        let left = product(&q, k, k).sqrt();
        let independent = left > DEPENDENT * size;
        let scale = if independent { 1.0 / left } else { 0.0 };
        r[k][k] = if independent { left } else { 0.0 };
        q.iter_mut().flatten().for_each(|row| row[k] *= scale);
    }
    (q, r)
}
