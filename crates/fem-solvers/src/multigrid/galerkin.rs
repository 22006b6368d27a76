//! The coarse matrix `Pᵀ A P`, summed in `f64` in a fixed order.

use super::precision::LevelScalar;
use super::prolongator::{Prolongator, add_product};
use super::rows::{Rows, cut};
use super::tentative::Tentative;
use crate::block_matrix::{BlockPattern, BlockSymmetric, PatternError};
use crate::parallel::map;
use fem_kinematics::{Kernel, dispatch};
use std::ops::Range;
use std::sync::Arc;

/// The places of the blocks of `A P` and of `Pᵀ A P`.
#[derive(Clone, Debug)]
pub(super) struct Galerkin {
    start: Vec<usize>,
    columns: Vec<u32>,
    pub coarse: Arc<BlockPattern>,
}

const NOWHERE: u32 = u32::MAX;

impl Galerkin {
    pub fn new<T: LevelScalar, const D: usize, const K: usize>(
        rows: &Rows,
        p: &Prolongator<T, D, K>,
    ) -> Result<Self, PatternError> {
        let (mut start, mut columns) = (vec![0], Vec::new());
        let mut seen = vec![NOWHERE; p.coarse_rows()];
        for i in 0..rows.len() {
            let begin = columns.len();
            for &j in rows.columns_of(i) {
                let j = j as usize;
                for &group in &p.columns[p.start[j]..p.start[j + 1]] {
                    if seen[group as usize] != i as u32 {
                        seen[group as usize] = i as u32;
                        columns.push(group);
                    }
                }
            }
            columns[begin..].sort_unstable();
            start.push(columns.len());
        }
        seen.fill(NOWHERE);
        let (mut coarse_start, mut coarse) = (vec![0], Vec::new());
        for i in 0..p.coarse_rows() {
            let begin = coarse.len();
            for &(row, _) in &p.of_coarse[p.coarse_start[i]..p.coarse_start[i + 1]] {
                let row = row as usize;
                for &j in &columns[start[row]..start[row + 1]] {
                    if j as usize <= i && seen[j as usize] != i as u32 {
                        seen[j as usize] = i as u32;
                        coarse.push(j);
                    }
                }
            }
            coarse[begin..].sort_unstable();
            coarse_start.push(coarse.len());
        }
        let coarse = Arc::new(BlockPattern::from_rows(coarse_start, coarse)?);
        Ok(Self {
            start,
            columns,
            coarse,
        })
    }

    /// Overwrites `out`. Unknowns that stand for nothing get a diagonal entry of the size of the others.
    pub fn multiply<T: LevelScalar, const D: usize, const K: usize>(
        &self,
        rows: &Rows,
        matrix: &BlockSymmetric<D>,
        p: &Prolongator<T, D, K>,
        tentative: &Tentative<D, K>,
        out: &mut BlockSymmetric<K>,
    ) {
        let mut ap = vec![[[0.0; K]; D]; self.columns.len()];
        let tasks = cut::<D, _>(rows.len(), &mut ap, |rows| {
            self.start[rows.end] - self.start[rows.start]
        });
        let _: Vec<()> = map(tasks, |(own, out)| {
            dispatch(FineProducts {
                plan: self,
                rows,
                matrix,
                p,
                own,
                out,
            });
        });
        let first = self.coarse.row_start();
        let tasks = cut::<K, _>(self.coarse.blocks(), out.values_mut(), |rows| {
            first[rows.end] - first[rows.start]
        });
        let _: Vec<()> = map(tasks, |(own, out)| {
            dispatch(CoarseProducts {
                plan: self,
                p,
                ap: &ap,
                tentative,
                own,
                out,
            });
        });
    }
}

/// Some rows of `A P`.
struct FineProducts<'a, T, const D: usize, const K: usize> {
    plan: &'a Galerkin,
    rows: &'a Rows,
    matrix: &'a BlockSymmetric<D>,
    p: &'a Prolongator<T, D, K>,
    own: Range<usize>,
    out: &'a mut [[[f64; K]; D]],
}

impl<T: LevelScalar, const D: usize, const K: usize> Kernel for FineProducts<'_, T, D, K> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { plan, rows, p, .. } = self;
        let begin = plan.start[self.own.start];
        let mut place = vec![NOWHERE; p.coarse_rows()];
        for i in self.own {
            for k in plan.start[i]..plan.start[i + 1] {
                place[plan.columns[k] as usize] = (k - begin) as u32;
                // Fresh memory that is read before it is written costs two page faults, and one of them
                // stops the other threads.
                self.out[k - begin] = [[0.0; K]; D];
            }
            for entry in rows.entries_of(i) {
                let j = rows.column(entry);
                let a = rows.block(self.matrix.values(), i, entry);
                for k in p.start[j]..p.start[j + 1] {
                    let target = place[p.columns[k] as usize] as usize;
                    add_product(&mut self.out[target], &a, &widened(&p.values[k]));
                }
            }
        }
    }
}

/// Some rows of `Pᵀ (A P)`.
struct CoarseProducts<'a, T, const D: usize, const K: usize> {
    plan: &'a Galerkin,
    p: &'a Prolongator<T, D, K>,
    ap: &'a [[[f64; K]; D]],
    tentative: &'a Tentative<D, K>,
    own: Range<usize>,
    out: &'a mut [[[f64; K]; K]],
}

impl<T: LevelScalar, const D: usize, const K: usize> Kernel for CoarseProducts<'_, T, D, K> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { plan, p, out, .. } = self;
        let (pattern, first) = (&*plan.coarse, plan.coarse.row_start());
        let begin = first[self.own.start];
        out.fill([[0.0; K]; K]);
        let mut place = vec![NOWHERE; pattern.blocks()];
        for i in self.own {
            let values = &mut out[first[i] - begin..first[i + 1] - begin];
            for (k, &j) in pattern.row(i).iter().enumerate() {
                place[j as usize] = k as u32;
            }
            for &(fine, entry) in &p.of_coarse[p.coarse_start[i]..p.coarse_start[i + 1]] {
                let fine = fine as usize;
                let left = widened(&p.values[entry as usize]);
                for k in plan.start[fine]..plan.start[fine + 1] {
                    let j = plan.columns[k] as usize;
                    if j > i {
                        break;
                    }
                    add_transposed_product(&mut values[place[j] as usize], &left, &self.ap[k]);
                }
            }
            if let Some(diagonal) = values.last_mut() {
                fill_diagonal(diagonal, &self.tentative.coarse[i]);
            }
        }
    }
}

#[inline(always)]
fn widened<T: LevelScalar, const D: usize, const K: usize>(block: &[[T; K]; D]) -> [[f64; K]; D] {
    let mut wide = [[0.0; K]; D];
    for d in 0..D {
        for k in 0..K {
            wide[d][k] = block[d][k].widen();
        }
    }
    wide
}

/// `out += Aᵀ B`
#[inline(always)]
fn add_transposed_product<const D: usize, const K: usize>(
    out: &mut [[f64; K]; K],
    a: &[[f64; K]; D],
    b: &[[f64; K]; D],
) {
    for d in 0..D {
        for r in 0..K {
            for c in 0..K {
                out[r][c] += a[d][r] * b[d][c];
            }
        }
    }
}

fn fill_diagonal<const K: usize>(block: &mut [[f64; K]; K], kernel: &[[f64; K]; K]) {
    let known = (0..K).filter(|&k| kernel[k][k] != 0.0);
    let (sum, count) = known.fold((0.0, 0), |(s, n), k| (s + block[k][k], n + 1));
    let size = if count > 0 {
        sum / f64::from(count)
    } else {
        1.0
    };
    for k in (0..K).filter(|&k| kernel[k][k] == 0.0) {
        block[k][k] = size;
    }
}
