//! Both halves of a symmetric matrix, row by row, so that each row of a product has one owner.

use super::precision::LevelScalar;
use crate::block_matrix::BlockPattern;
use crate::parallel::map;
use std::ops::Range;

/// Fewest scalar rows in one task, and the most tasks; the cut does not touch the bits.
const ROWS_PER_TASK: usize = 3_000;
const MAX_TASKS: usize = 16;

/// Where the blocks of each whole row are, and which stored block each of them comes from.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    start: Vec<usize>,
    columns: Vec<u32>,
    /// Stored block of the lower half; of the transposed one where the column is right of the row.
    source: Vec<u32>,
}

impl Rows {
    pub fn new(pattern: &BlockPattern) -> Self {
        let n = pattern.blocks();
        let mut start = vec![0; n + 1];
        for i in 0..n {
            for &j in pattern.row(i) {
                start[i + 1] += 1;
                if (j as usize) != i {
                    start[j as usize + 1] += 1;
                }
            }
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let (mut columns, mut source) = (vec![0; start[n]], vec![0; start[n]]);
        let mut put = |row: usize, column: u32, from: usize| {
            columns[next[row]] = column;
            source[next[row]] = from as u32;
            next[row] += 1;
        };
        // Rows come in ascending order, so that the columns of each row do as well.
        for i in 0..n {
            for k in pattern.row_start()[i]..pattern.row_start()[i + 1] {
                let j = pattern.columns()[k];
                put(i, j, k);
                if (j as usize) != i {
                    put(j as usize, i as u32, k);
                }
            }
        }
        Self {
            start,
            columns,
            source,
        }
    }

    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Blocks of both halves.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    #[inline(always)]
    pub fn entries_of(&self, row: usize) -> Range<usize> {
        self.start[row]..self.start[row + 1]
    }

    #[inline(always)]
    pub fn columns_of(&self, row: usize) -> &[u32] {
        &self.columns[self.entries_of(row)]
    }

    #[inline(always)]
    pub fn column(&self, entry: usize) -> usize {
        self.columns[entry] as usize
    }

    #[inline(always)]
    pub fn source(&self, entry: usize) -> usize {
        self.source[entry] as usize
    }

    /// Block of a row, from the stored half.
    #[inline(always)]
    pub fn block<const D: usize>(
        &self,
        stored: &[[[f64; D]; D]],
        row: usize,
        entry: usize,
    ) -> [[f64; D]; D] {
        let block = stored[self.source(entry)];
        if self.column(entry) <= row {
            block
        } else {
            let mut transposed = [[0.0; D]; D];
            for r in 0..D {
                for c in 0..D {
                    transposed[r][c] = block[c][r];
                }
            }
            transposed
        }
    }

    /// All blocks by columns, `out[e][c][r]`, times `scale`, so that a product adds whole columns.
    pub fn gather<T: LevelScalar, const D: usize>(
        &self,
        stored: &[[[f64; D]; D]],
        scale: f64,
        out: &mut [[[T; D]; D]],
    ) {
        let tasks = self.cut::<D, _>(out, |rows| self.start[rows.end] - self.start[rows.start]);
        let _: Vec<()> = map(tasks, |(rows, out)| {
            let begin = self.start[rows.start];
            for row in rows {
                for entry in self.entries_of(row) {
                    let block = self.block(stored, row, entry);
                    out[entry - begin] = std::array::from_fn(|c| {
                        std::array::from_fn(|r| T::narrow(scale * block[r][c]))
                    });
                }
            }
        });
    }

    /// Runs of rows, and the part of `slice` that belongs to each.
    pub fn cut<'a, const D: usize, V>(
        &self,
        slice: &'a mut [V],
        length: impl Fn(&Range<usize>) -> usize,
    ) -> Vec<(Range<usize>, &'a mut [V])> {
        cut::<D, V>(self.len(), slice, length)
    }
}

/// Runs of `n` rows of `D` scalars each, and the part of `slice` that belongs to each run.
pub(super) fn cut<const D: usize, V>(
    n: usize,
    mut slice: &mut [V],
    length: impl Fn(&Range<usize>) -> usize,
) -> Vec<(Range<usize>, &mut [V])> {
    let tasks = (n * D / ROWS_PER_TASK).clamp(1, MAX_TASKS);
    let mut cut = Vec::with_capacity(tasks);
    for k in 0..tasks {
        let rows = n * k / tasks..n * (k + 1) / tasks;
        let (own, rest) = slice.split_at_mut(length(&rows));
        slice = rest;
        cut.push((rows, own));
    }
    cut
}
