//! Which rows go together.

use super::rows::Rows;
use crate::block_matrix::BlockSymmetric;

/// Aggregates of block rows, numbered in the order of their first member.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Aggregates {
    /// The aggregate of each row, [`ALONE`] for a row that is coupled to nothing.
    pub of_row: Vec<u32>,
    /// The rows of each aggregate, ascending.
    pub members: Vec<Vec<u32>>,
}

/// A row without a strong coupling: the smoother alone solves it.
pub(super) const ALONE: u32 = u32::MAX;

/// Groups each row with all its strong neighbors where these are free, then gives the rows left over
/// to the group that they are coupled to most; each of them has one, for a neighbor that was not free
/// belongs to it. The order is that of the rows, on one thread.
///
/// A coupling is strong if `‖A_ij‖² > threshold² ‖A_ii‖ ‖A_jj‖` (Frobenius norms).
pub(super) fn aggregate<const D: usize>(
    rows: &Rows,
    matrix: &BlockSymmetric<D>,
    threshold: f64,
) -> Aggregates {
    let strength = Strength::new(rows, matrix, threshold);
    let n = rows.len();
    let mut of_row = vec![ALONE; n];
    let mut count = 0;
    for i in 0..n {
        let mut strong = strength.neighbors(i).peekable();
        if of_row[i] == ALONE && strong.peek().is_some() && strong.all(|(j, _)| of_row[j] == ALONE)
        {
            of_row[i] = count;
            strength.neighbors(i).for_each(|(j, _)| of_row[j] = count);
            count += 1;
        }
    }
    let first = of_row.clone();
    for i in (0..n).filter(|&i| first[i] == ALONE) {
        let mut best = (0.0, ALONE);
        for (j, strength) in strength.neighbors(i).filter(|(j, _)| first[*j] != ALONE) {
            if strength > best.0 {
                best = (strength, first[j]);
            }
        }
        of_row[i] = best.1;
    }
    Aggregates::numbered(of_row, count as usize)
}

impl Aggregates {
    fn numbered(mut of_row: Vec<u32>, count: usize) -> Self {
        let mut number = vec![ALONE; count];
        let mut members: Vec<Vec<u32>> = Vec::with_capacity(count);
        for (i, own) in of_row.iter_mut().enumerate() {
            if *own == ALONE {
                continue;
            }
            let number = &mut number[*own as usize];
            if *number == ALONE {
                *number = members.len() as u32;
                members.push(Vec::new());
            }
            *own = *number;
            members[*own as usize].push(i as u32);
        }
        Self { of_row, members }
    }

    pub fn count(&self) -> usize {
        self.members.len()
    }
}

/// Squared norms of the blocks and the smallest that counts.
struct Strength<'a> {
    rows: &'a Rows,
    squared: Vec<f64>,
    diagonal: Vec<f64>,
    threshold: f64,
}

impl<'a> Strength<'a> {
    fn new<const D: usize>(rows: &'a Rows, matrix: &BlockSymmetric<D>, threshold: f64) -> Self {
        let square = |b: &[[f64; D]; D]| b.iter().flatten().map(|v| v * v).sum::<f64>();
        let squared: Vec<f64> = matrix.values().iter().map(square).collect();
        let pattern = matrix.pattern();
        let diagonal = (0..pattern.blocks())
            .map(|i| squared[pattern.diagonal(i)].sqrt())
            .collect();
        Self {
            rows,
            squared,
            diagonal,
            threshold: threshold * threshold,
        }
    }

    /// Rows that `i` is strongly coupled to, with the square of the coupling over their own sizes.
    fn neighbors(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        self.rows.entries_of(i).filter_map(move |entry| {
            let j = self.rows.column(entry);
            let size = self.diagonal[i] * self.diagonal[j];
            let coupling = self.squared[self.rows.source(entry)];
            (j != i && coupling > self.threshold * size).then(|| (j, coupling / size))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{ALONE, aggregate};
    use crate::block_matrix::{BlockPattern, BlockSymmetric};
    use crate::multigrid::rows::Rows;
    use std::sync::Arc;

    /// Two pairs, a row between them that is coupled to both, and one that is coupled to nothing.
    #[test]
    fn a_row_left_over_goes_to_the_group_that_it_is_coupled_to_most() {
        let pairs = [(0, 1), (2, 3), (1, 4), (3, 4)];
        let pattern = Arc::new(BlockPattern::from_adjacency(6, pairs).unwrap());
        let rows = Rows::new(&pattern);
        let of_row = |to_first: f64, to_second: f64| {
            let mut matrix = BlockSymmetric::<1>::zeros(pattern.clone());
            let couplings = [-0.9, -0.9, to_first, to_second];
            for ((i, j), coupling) in pairs.into_iter().zip(couplings) {
                let place = pattern.find(j, i).unwrap();
                matrix.values_mut()[place] = [[coupling]];
            }
            (0..6).for_each(|i| matrix.values_mut()[pattern.diagonal(i)] = [[2.0]]);
            aggregate(&rows, &matrix, 0.02).of_row
        };
        assert_eq!(of_row(-0.5, 0.4), [0, 0, 1, 1, 0, ALONE]);
        assert_eq!(of_row(0.4, -0.5), [0, 0, 1, 1, 1, ALONE]);
        // Below 0.02 of its own size a coupling is none.
        assert_eq!(of_row(-0.05, 0.03), [0, 0, 1, 1, 0, ALONE]);
        assert_eq!(of_row(-0.03, 0.03), [0, 0, 1, 1, ALONE, ALONE]);
    }
}
