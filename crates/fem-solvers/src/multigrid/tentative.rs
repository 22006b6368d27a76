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

#[cfg(test)]
mod tests {
    use super::{ALONE, Aggregates, Tentative};

    /// Rigid motions of scattered points in space.
    fn motions(n: usize) -> Vec<[[f64; 6]; 3]> {
        let motion = |p: [f64; 3]| {
            [
                [1.0, 0.0, 0.0, 0.0, p[2], -p[1]],
                [0.0, 1.0, 0.0, -p[2], 0.0, p[0]],
                [0.0, 0.0, 1.0, p[1], -p[0], 0.0],
            ]
        };
        let point = |i: usize| {
            [
                3.0 + (i as f64).sin(),
                (1.7 * i as f64).cos(),
                0.1 * i as f64,
            ]
        };
        (0..n).map(|i| motion(point(i))).collect()
    }

    #[test]
    fn the_near_kernel_is_reproduced_and_columns_are_orthonormal() {
        // Groups of five, two (no turn about their line), one (no turn at all), and a row alone.
        let of_row = vec![0, 1, 0, 0, 2, 0, ALONE, 1, 0];
        let members = vec![vec![0, 2, 3, 5, 8], vec![1, 7], vec![4]];
        let aggregates = Aggregates { of_row, members };
        let kernel = motions(9);
        let made = Tentative::new(&aggregates, &kernel);
        for (group, r) in aggregates.members.iter().zip(&made.coarse) {
            let independent = (0..6).filter(|&k| r[k][k] != 0.0).count();
            assert_eq!(independent, [0, 3, 5, 6][group.len().min(3)]);
            for &i in group {
                let (q, b) = (&made.blocks[i as usize], &kernel[i as usize]);
                for d in 0..3 {
                    for k in 0..6 {
                        let product: f64 = (0..6).map(|m| q[d][m] * r[m][k]).sum();
                        assert!((product - b[d][k]).abs() < 1e-13, "{product} {}", b[d][k]);
                    }
                }
            }
            for a in 0..6 {
                for b in 0..6 {
                    let rows = group.iter().flat_map(|&i| made.blocks[i as usize]);
                    let product: f64 = rows.map(|row| row[a] * row[b]).sum();
                    let expected = f64::from(u8::from(a == b && r[a][a] != 0.0));
                    assert!((product - expected).abs() < 1e-13, "{a} {b}: {product}");
                }
            }
        }
        assert_eq!(made.blocks[6], [[0.0; 6]; 3]);
    }
    /// Far away turns are translations but for their last digits, and small numbers are no zeros.
    #[test]
    fn columns_are_orthonormal_far_away_and_in_every_unit() {
        let members = vec![(0..5).collect()];
        let aggregates = Aggregates {
            of_row: vec![0; 5],
            members,
        };
        for (away, unit) in [(1e5, 1.0), (0.0, 1e-30), (0.0, 1e30)] {
            let mut kernel = motions(5);
            for row in kernel.iter_mut().flatten() {
                let [x, y, z] = [row[0], row[1], row[2]];
                // A translation by (away, away, away) moves where it turns about.
                row[3] += away * (y - z);
                row[4] += away * (z - x);
                row[5] += away * (x - y);
                row.iter_mut().for_each(|v| *v *= unit);
            }
            let made = Tentative::new(&aggregates, &kernel);
            for a in 0..6 {
                for b in 0..6 {
                    let rows = made.blocks.iter().flatten();
                    let product: f64 = rows.map(|row| row[a] * row[b]).sum();
                    let expected = f64::from(u8::from(a == b));
                    assert!(
                        (product - expected).abs() < 1e-13,
                        "{away} {unit}: {a} {b}: {product}"
                    );
                }
            }
        }
    }
}
