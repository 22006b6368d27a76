//! How the lower half of a symmetric matrix is stored.

use std::ops::Range;

/// Columns of a strip.
pub(super) const STRIP: usize = 256;

/// The lower half of a symmetric matrix with so many rows: strips of columns, one after the other, each
/// with the rows from its first column on, column-major. What is stored above the diagonal is never read.
#[derive(Clone, Copy)]
pub(super) struct Half {
    pub rows: usize,
}

impl Half {
    /// Numbers stored.
    pub fn len(self) -> usize {
        let last = self.rows % STRIP;
        self.before(self.rows / STRIP) + last * last
    }

    /// Numbers in so many whole strips.
    fn before(self, strips: usize) -> usize {
        // Each strip is STRIP rows shorter than the one before it.
        let missing = STRIP * STRIP * (strips * strips.saturating_sub(1) / 2);
        strips * STRIP * self.rows - missing
    }

    /// Where a diagonal entry is; the rest of its column follows.
    pub fn diagonal(self, column: usize) -> usize {
        let (strip, inside) = (column / STRIP, column % STRIP);
        self.before(strip) + inside * (self.rows - strip * STRIP + 1)
    }

    /// The columns of every strip.
    pub fn strips(self) -> impl Iterator<Item = Range<usize>> {
        let rows = self.rows;
        (0..rows)
            .step_by(STRIP)
            .map(move |first| first..rows.min(first + STRIP))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_of_the_lower_half_has_a_place_of_its_own() {
        for rows in [0, 1, 7, STRIP - 1, STRIP, STRIP + 1, 2 * STRIP + 5] {
            let half = Half { rows };
            let mut taken = vec![false; half.len()];
            for column in 0..rows {
                for below in 0..rows - column {
                    let place = &mut taken[half.diagonal(column) + below];
                    assert!(!std::mem::replace(place, true), "{column} {below}");
                }
            }
            let mut begin = 0;
            for strip in half.strips() {
                assert_eq!(half.diagonal(strip.start), begin);
                begin += strip.len() * (rows - strip.start);
            }
            assert_eq!(begin, half.len());
        }
    }
}
