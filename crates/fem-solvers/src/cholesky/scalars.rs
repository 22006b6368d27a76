//! Which scalars of the blocks are unknowns, in the order of the factor.

use crate::block_matrix::BlockPattern;
use crate::ordering::Permutation;

/// The scalars of the block rows, those that are absent left out.
pub(super) struct Scalars {
    /// Place of each scalar of the factor in a vector of blocks.
    pub places: Vec<usize>,
    /// First scalar of each block row in the order of the factor; the last entry is their number.
    first: Vec<usize>,
}

impl Scalars {
    pub fn new(pattern: &BlockPattern, permutation: &Permutation, block_size: usize) -> Self {
        let mut places = Vec::with_capacity(pattern.unknowns(block_size));
        let mut first = Vec::with_capacity(pattern.blocks() + 1);
        for &old in permutation.order() {
            first.push(places.len());
            let old = old as usize;
            let present = (0..block_size).filter(|&k| !pattern.is_absent(old, k));
            places.extend(present.map(|k| block_size * old + k));
        }
        first.push(places.len());
        Self { places, first }
    }

    /// The scalars of some consecutive block rows.
    pub fn of(&self, rows: std::ops::Range<usize>) -> std::ops::Range<usize> {
        self.first[rows.start]..self.first[rows.end]
    }

    /// The places of the scalars of one block row.
    pub fn places_of(&self, row: usize) -> &[usize] {
        &self.places[self.of(row..row + 1)]
    }
}
