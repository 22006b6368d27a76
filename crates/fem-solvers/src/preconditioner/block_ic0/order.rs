//! The order of the block rows: from both ends towards the middle, for two threads.

use crate::block_matrix::BlockPattern;
use std::ops::Range;

/// Block rows below which a second thread does not pay.
const WORTH_TWO: usize = 4_096;
/// The part of all rows that may wait for both ends, 1 / this.
const WAITING: usize = 8;

/// The first half of the rows, the second half backwards, and last the rows of it that have an entry in
/// the first: neither half waits for the other, and still a sweep leads from end to end and back. (In
/// more runs than two, all forwards, a bar of 98,000 tetrahedra takes 422 iterations in place of 304.)
///
/// Where too many rows would have to wait, they all stay where they are. The order depends on the pattern
/// alone, so that results have the same bits for any number of threads.
#[derive(Clone, Debug, Default)]
pub(super) struct Order {
    /// The row of the matrix that stands here, and where each of its rows stands.
    pub rows: Vec<u32>,
    places: Vec<u32>,
    pub parts: Vec<Part>,
    pub row_start: Vec<usize>,
    /// Columns of each row, ascending, the row itself last.
    pub columns: Vec<u32>,
    pub sources: Vec<Source>,
}

/// Rows that no entry joins to those of the other part.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Here.
    pub rows: Range<usize>,
    /// In the matrix, those that wait included.
    pub of_matrix: Range<usize>,
}

/// The stored block of the matrix that is taken for an entry, or its transpose.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Source {
    pub block: usize,
    pub transposed: bool,
}

impl Order {
    pub fn new(pattern: &BlockPattern) -> Self {
        let n = pattern.blocks();
        let middle = pattern
            .row_start()
            .partition_point(|&s| s < pattern.stored() / 2);
        let waits = |i: &usize| (pattern.row(*i)[0] as usize) < middle;
        let (waiting, second): (Vec<usize>, Vec<usize>) = (middle..n).partition(waits);
        if n < WORTH_TWO || WAITING * waiting.len() > n {
            return Self::of(pattern, (0..n).collect(), &[(n, n)]);
        }
        let (first, end) = (middle, middle + second.len());
        let rows = (0..middle).chain(second.into_iter().rev()).chain(waiting);
        Self::of(pattern, rows.collect(), &[(first, middle), (end, n)])
    }

    /// `ends` of the parts, here and in the matrix.
    fn of(pattern: &BlockPattern, rows: Vec<usize>, ends: &[(usize, usize)]) -> Self {
        let mut places = vec![0; rows.len()];
        for (here, &row) in rows.iter().enumerate() {
            places[row] = here as u32;
        }
        let mut parts: Vec<Part> = Vec::with_capacity(ends.len());
        for &(here, in_matrix) in ends {
            let begin = parts
                .last()
                .map_or((0, 0), |p| (p.rows.end, p.of_matrix.end));
            parts.push(Part {
                rows: begin.0..here,
                of_matrix: begin.1..in_matrix,
            });
        }
        let mut made = Self {
            rows: rows.into_iter().map(|row| row as u32).collect(),
            places,
            parts,
            ..Self::default()
        };
        made.place_entries(pattern);
        made
    }

    /// The rows behind all parts.
    pub fn waiting(&self) -> Range<usize> {
        self.parts.last().map_or(0, |p| p.rows.end)..self.rows.len()
    }

    /// Where a row of the matrix stands.
    pub fn place(&self, row: usize) -> usize {
        self.places[row] as usize
    }

    /// What belongs to the rows of each part, `length` of it, and what to those that wait.
    pub fn cut<'a, T>(
        &self,
        mut values: &'a mut [T],
        length: impl Fn(&Range<usize>) -> usize,
    ) -> (Vec<(&Part, &'a mut [T])>, &'a mut [T]) {
        let mut parts = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let (own, rest) = values.split_at_mut(length(&part.rows));
            parts.push((part, own));
            values = rest;
        }
        (parts, values)
    }

    /// The number of entries of consecutive rows.
    pub fn entries(&self, rows: &Range<usize>) -> usize {
        self.row_start[rows.end] - self.row_start[rows.start]
    }

    /// Sorts the stored blocks into rows of this order.
    fn place_entries(&mut self, pattern: &BlockPattern) {
        let n = pattern.blocks();
        let mut rows: Vec<Vec<(u32, Source)>> = vec![Vec::new(); n];
        for i in 0..n {
            for block in pattern.row_start()[i]..pattern.row_start()[i + 1] {
                let (p, q) = (
                    self.places[i],
                    self.places[pattern.columns()[block] as usize],
                );
                let transposed = q > p;
                rows[p.max(q) as usize].push((p.min(q), Source { block, transposed }));
            }
        }
        self.row_start.push(0);
        for row in &mut rows {
            row.sort_unstable_by_key(|(column, _)| *column);
            self.columns.extend(row.iter().map(|(column, _)| column));
            self.sources.extend(row.iter().map(|(_, source)| source));
            self.row_start.push(self.columns.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Order;
    use crate::block_matrix::BlockPattern;

    /// Layers of a grid, each row joined to what lies in its own layer and the next.
    fn layers(width: usize, count: usize) -> BlockPattern {
        let n = width * count;
        let across = (1..n).filter(move |i| i % width > 0).map(|i| (i - 1, i));
        let along = (width..n).map(move |i| (i - width, i));
        BlockPattern::from_adjacency(n, across.chain(along)).unwrap()
    }

    fn stands(order: &Order, blocks: usize) {
        let mut rows: Vec<u32> = order.rows.clone();
        assert!((0..blocks).all(|row| rows[order.place(row)] as usize == row));
        rows.sort_unstable();
        assert!(rows.iter().enumerate().all(|(i, &row)| i == row as usize));
    }

    #[test]
    fn both_halves_lead_to_the_middle_and_nothing_joins_them() {
        let pattern = layers(50, 100);
        let order = Order::new(&pattern);
        stands(&order, 5_000);
        let [first, second] = &order.parts[..] else {
            panic!("two parts")
        };
        assert_eq!(order.waiting().len(), 50);
        assert!(first.rows.len().abs_diff(second.rows.len()) < 100);
        assert_eq!((order.rows[0], order.rows[second.rows.start]), (0, 4_999));
        for row in second.rows.clone() {
            let entries = order.row_start[row]..order.row_start[row + 1];
            let columns = &order.columns[entries];
            assert!(columns.iter().all(|&c| second.rows.contains(&(c as usize))));
            assert!(columns.is_sorted() && columns.last() == Some(&(row as u32)));
        }
    }

    #[test]
    fn few_rows_and_rows_that_all_wait_stay_where_they_are() {
        for pattern in [layers(10, 10), layers(2_000, 3)] {
            let order = Order::new(&pattern);
            stands(&order, pattern.blocks());
            assert_eq!((order.parts.len(), order.waiting().len()), (1, 0));
            assert!(order.rows.is_sorted());
            assert_eq!(order.columns, pattern.columns());
        }
    }
}
