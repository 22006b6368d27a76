//! From coarse unknowns to fine ones: `P = (I − ω D⁻¹A) P̂`.

use super::aggregation::{ALONE, Aggregates};
use super::entry::Entry;
use super::precision::LevelScalar;
use super::rows::{Rows, cut};
use super::tentative::Tentative;
use crate::block_matrix::BlockSymmetric;
use crate::parallel::map;
use crate::small;
use fem_kinematics::{Kernel, dispatch};
use std::ops::Range;

/// D×K blocks by rows, and for each coarse row the blocks in its column.
#[derive(Clone, Debug)]
pub(super) struct Prolongator<T, const D: usize, const K: usize> {
    pub start: Vec<usize>,
    pub columns: Vec<u32>,
    /// `values[e][r][k]`
    pub values: Vec<[[T; K]; D]>,
    pub coarse_start: Vec<usize>,
    /// Fine row and entry of each block of a coarse column, rows ascending.
    pub of_coarse: Vec<(u32, u32)>,
}

impl<T: LevelScalar, const D: usize, const K: usize> Prolongator<T, D, K> {
    /// The places of the blocks: a row reaches the aggregates of all rows that it is coupled to.
    pub fn new(rows: &Rows, aggregates: &Aggregates) -> Self {
        let (mut start, mut columns) = (vec![0], Vec::new());
        let mut reached = Vec::new();
        let mut coarse_start = vec![0; aggregates.count() + 1];
        for i in 0..rows.len() {
            reached.clear();
            let groups = rows.columns_of(i).iter();
            reached.extend(groups.map(|&j| aggregates.of_row[j as usize]));
            reached.retain(|&group| group != ALONE);
            reached.sort_unstable();
            reached.dedup();
            reached
                .iter()
                .for_each(|&group| coarse_start[group as usize + 1] += 1);
            columns.extend_from_slice(&reached);
            start.push(columns.len());
        }
        for group in 0..aggregates.count() {
            coarse_start[group + 1] += coarse_start[group];
        }
        let mut next = coarse_start.clone();
        let mut of_coarse = vec![(0, 0); columns.len()];
        for i in 0..rows.len() {
            for entry in start[i]..start[i + 1] {
                let place = &mut next[columns[entry] as usize];
                of_coarse[*place] = (i as u32, entry as u32);
                *place += 1;
            }
        }
        let values = vec![[[T::default(); K]; D]; columns.len()];
        Self {
            start,
            columns,
            values,
            coarse_start,
            of_coarse,
        }
    }

    pub fn coarse_rows(&self) -> usize {
        self.coarse_start.len() - 1
    }

    /// The values, for `ω = damping / λ`, `λ` the largest eigenvalue of `D⁻¹A`. Diagonal blocks are
    /// known to be positive definite.
    pub fn smooth(
        &mut self,
        rows: &Rows,
        matrix: &BlockSymmetric<D>,
        aggregates: &Aggregates,
        tentative: &Tentative<D, K>,
        omega: f64,
    ) {
        let Self {
            start,
            columns,
            values,
            ..
        } = self;
        let tasks = cut::<D, _>(rows.len(), values, |rows| {
            start[rows.end] - start[rows.start]
        });
        let _: Vec<()> = map(tasks, |(own, values)| {
            let begin = start[own.start];
            let mut sums = Vec::new();
            for i in own {
                let reached = &columns[start[i]..start[i + 1]];
                sums.clear();
                sums.resize(reached.len(), [[0.0; K]; D]);
                for entry in rows.entries_of(i) {
                    let j = rows.column(entry);
                    let Ok(place) = reached.binary_search(&aggregates.of_row[j]) else {
                        continue;
                    };
                    let a = rows.block(matrix.values(), i, entry);
                    add_product(&mut sums[place], &a, &tentative.blocks[j]);
                }
                let inverse = small::inverse_positive_definite(matrix.diagonal_block(i))
                    .unwrap_or([[0.0; D]; D]);
                for (k, (sum, group)) in sums.iter().zip(reached).enumerate() {
                    let mut step = [[0.0; K]; D];
                    add_product(&mut step, &inverse, sum);
                    let own = *group == aggregates.of_row[i];
                    values[start[i] - begin + k] = std::array::from_fn(|r| {
                        std::array::from_fn(|c| {
                            let before = if own { tentative.blocks[i][r][c] } else { 0.0 };
                            T::narrow(before - omega * step[r][c])
                        })
                    });
                }
            }
        });
    }

    /// `x = P e`
    pub fn prolong<V: Entry<T>>(&self, e: &[[V; K]], x: &mut [[V; D]]) {
        let tasks = cut::<D, _>(x.len(), x, Range::len);
        let _: Vec<()> = map(tasks, |(rows, x)| {
            dispatch(Prolong {
                p: self,
                e,
                rows,
                x,
            });
        });
    }

    /// `e = Pᵀ r`
    pub fn restrict<V: Entry<T>>(&self, r: &[[V; D]], e: &mut [[V; K]]) {
        let tasks = cut::<K, _>(self.coarse_rows(), e, Range::len);
        let _: Vec<()> = map(tasks, |(rows, e)| {
            dispatch(Restrict {
                p: self,
                r,
                rows,
                e,
            });
        });
    }
}

struct Prolong<'a, T, V, const D: usize, const K: usize> {
    p: &'a Prolongator<T, D, K>,
    e: &'a [[V; K]],
    rows: Range<usize>,
    x: &'a mut [[V; D]],
}

impl<T: LevelScalar, V: Entry<T>, const D: usize, const K: usize> Kernel
    for Prolong<'_, T, V, D, K>
{
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { p, e, rows, x } = self;
        for (i, x) in rows.zip(x) {
            // Products first, their sum over k last: whole registers as long as possible.
            let mut products = [[V::default(); K]; D];
            let own = p.start[i]..p.start[i + 1];
            for (block, &j) in p.values[own.clone()].iter().zip(&p.columns[own]) {
                let e = &e[j as usize];
                for r in 0..D {
                    for k in 0..K {
                        products[r][k] += e[k] * block[r][k];
                    }
                }
            }
            for r in 0..D {
                let mut sum = V::default();
                for k in 0..K {
                    sum += products[r][k];
                }
                x[r] = sum;
            }
        }
    }
}

struct Restrict<'a, T, V, const D: usize, const K: usize> {
    p: &'a Prolongator<T, D, K>,
    r: &'a [[V; D]],
    rows: Range<usize>,
    e: &'a mut [[V; K]],
}

impl<T: LevelScalar, V: Entry<T>, const D: usize, const K: usize> Kernel
    for Restrict<'_, T, V, D, K>
{
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { p, r, rows, e } = self;
        for (i, e) in rows.zip(e) {
            let mut sum = [V::default(); K];
            for &(row, entry) in &p.of_coarse[p.coarse_start[i]..p.coarse_start[i + 1]] {
                let (block, r) = (&p.values[entry as usize], &r[row as usize]);
                for d in 0..D {
                    for k in 0..K {
                        sum[k] += r[d] * block[d][k];
                    }
                }
            }
            *e = sum;
        }
    }
}

/// `out += A B`
#[inline(always)]
pub(super) fn add_product<const D: usize, const K: usize>(
    out: &mut [[f64; K]; D],
    a: &[[f64; D]; D],
    b: &[[f64; K]; D],
) {
    for r in 0..D {
        for m in 0..D {
            for k in 0..K {
                out[r][k] += a[r][m] * b[m][k];
            }
        }
    }
}
