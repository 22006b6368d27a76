//! Where the blocks of a symmetric matrix are.

use thiserror::Error;

/// The places of the blocks of a symmetric matrix, lower half with the diagonal.
///
/// Row `i` holds the columns `columns()[row_start()[i]..row_start()[i + 1]]`, ascending, all `≤ i`;
/// the last one is the diagonal `i` itself, which is always there.
///
/// Single scalars of block rows may be [absent](Self::with_absent): no unknowns of the system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockPattern {
    row_start: Vec<usize>,
    columns: Vec<u32>,
    /// (block row, scalar of the row), ascending.
    absent: Vec<(usize, usize)>,
    pub(super) chunks: Vec<RowChunk>,
}

/// A run of rows that one task multiplies; the cut depends on the pattern alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct RowChunk {
    pub rows: std::ops::Range<usize>,
    /// The smallest column in these rows.
    pub first_column: usize,
}

/// Why a list of rows is not a [`BlockPattern`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PatternError {
    /// `row_start` does not begin with 0, does not ascend, or does not end at the number of columns.
    #[error(
        "row starts must ascend from 0 to the number of stored blocks; entry {index} is {value}"
    )]
    RowStart {
        /// Index into `row_start`.
        index: usize,
        /// What is there.
        value: usize,
    },
    /// A row is empty or its last column is not the diagonal.
    #[error("block row {row} must end with its diagonal block")]
    MissingDiagonal {
        /// The row.
        row: usize,
    },
    /// Columns of a row do not strictly ascend.
    #[error("block row {row}: column {column} is out of order, repeated or right of the diagonal")]
    Column {
        /// The row.
        row: usize,
        /// The offending column.
        column: usize,
    },
    /// A pair names a block outside the matrix.
    #[error("pair ({row}, {column}) lies outside a matrix of {blocks} block rows")]
    OutOfRange {
        /// First index.
        row: usize,
        /// Second index.
        column: usize,
        /// Number of block rows.
        blocks: usize,
    },
    /// A scalar is said to be absent from a block row outside the matrix.
    #[error("block row {row} lies outside a matrix of {blocks} block rows")]
    NoSuchRow {
        /// The row.
        row: usize,
        /// Number of block rows.
        blocks: usize,
    },
    /// More than `u32::MAX` block rows.
    #[error("{blocks} block rows do not fit 32-bit column indices")]
    TooLarge {
        /// Number of block rows.
        blocks: usize,
    },
}

/// Stored blocks per task of a product; at most [`MAX_CHUNKS`] tasks.
const BLOCKS_PER_CHUNK: usize = 16_384;
const MAX_CHUNKS: usize = 8;

/// The pattern without rows.
impl Default for BlockPattern {
    fn default() -> Self {
        Self {
            row_start: vec![0],
            columns: Vec::new(),
            absent: Vec::new(),
            chunks: Vec::new(),
        }
    }
}

impl BlockPattern {
    /// Checks and takes compressed rows.
    ///
    /// # Errors
    /// [`PatternError`] names the first row that breaks the layout described at the type.
    pub fn from_rows(row_start: Vec<usize>, columns: Vec<u32>) -> Result<Self, PatternError> {
        let row_start = if row_start.is_empty() {
            vec![0]
        } else {
            row_start
        };
        let blocks = row_start.len() - 1;
        if u32::try_from(blocks).is_err() {
            return Err(PatternError::TooLarge { blocks });
        }
        if row_start[0] != 0 {
            return Err(PatternError::RowStart {
                index: 0,
                value: row_start[0],
            });
        }
        for i in 0..blocks {
            if row_start[i + 1] < row_start[i] || row_start[i + 1] > columns.len() {
                return Err(PatternError::RowStart {
                    index: i + 1,
                    value: row_start[i + 1],
                });
            }
        }
        if row_start[blocks] != columns.len() {
            return Err(PatternError::RowStart {
                index: blocks,
                value: row_start[blocks],
            });
        }
        for i in 0..blocks {
            let row = &columns[row_start[i]..row_start[i + 1]];
            if let Some(w) = row.windows(2).find(|w| w[0] >= w[1]) {
                return Err(PatternError::Column {
                    row: i,
                    column: w[1] as usize,
                });
            }
            match row.last() {
                Some(&last) if last as usize == i => {}
                Some(&last) if last as usize > i => {
                    return Err(PatternError::Column {
                        row: i,
                        column: last as usize,
                    });
                }
                _ => return Err(PatternError::MissingDiagonal { row: i }),
            }
        }
        let chunks = cut_rows(&row_start, &columns);
        Ok(Self {
            row_start,
            columns,
            absent: Vec::new(),
            chunks,
        })
    }

    /// The pattern that couples every given pair of blocks, in any order, repeated or not.
    ///
    /// The diagonal is added.
    ///
    /// # Errors
    /// [`PatternError::OutOfRange`] for a pair with an index `≥ blocks`.
    pub fn from_adjacency(
        blocks: usize,
        pairs: impl IntoIterator<Item = (usize, usize)>,
    ) -> Result<Self, PatternError> {
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); blocks];
        if u32::try_from(blocks).is_err() {
            return Err(PatternError::TooLarge { blocks });
        }
        for (a, b) in pairs {
            if a >= blocks || b >= blocks {
                return Err(PatternError::OutOfRange {
                    row: a,
                    column: b,
                    blocks,
                });
            }
            rows[a.max(b)].push(a.min(b) as u32);
        }
        let mut row_start = Vec::with_capacity(blocks + 1);
        let mut columns = Vec::new();
        row_start.push(0);
        for (i, row) in rows.iter_mut().enumerate() {
            row.push(i as u32);
            row.sort_unstable();
            row.dedup();
            columns.extend_from_slice(row);
            row_start.push(columns.len());
        }
        Self::from_rows(row_start, columns)
    }

    /// The same places for a system without the given scalars, (block row, row in its blocks), in any
    /// order, repeated or not; in place of those that were absent before.
    ///
    /// The blocks keep their size. An absent scalar is no unknown: a factor has neither row nor column
    /// for it, and a solution holds 0 there whatever the right-hand side does. What a matrix stores in
    /// its row and column is padding ([`BlockSymmetric::fill_padding`](crate::BlockSymmetric::fill_padding)).
    /// Scalars that the blocks of a matrix do not have are ignored.
    ///
    /// # Errors
    /// [`PatternError::NoSuchRow`] for a block row that is not there.
    pub fn with_absent(
        self,
        scalars: impl IntoIterator<Item = (usize, usize)>,
    ) -> Result<Self, PatternError> {
        let blocks = self.blocks();
        let mut absent: Vec<(usize, usize)> = scalars.into_iter().collect();
        if let Some(&(row, _)) = absent.iter().find(|(row, _)| *row >= blocks) {
            return Err(PatternError::NoSuchRow { row, blocks });
        }
        absent.sort_unstable();
        absent.dedup();
        Ok(Self { absent, ..self })
    }

    /// This pattern with places for more pairs of blocks, in any order, known or not.
    ///
    /// # Errors
    /// As [`from_adjacency`](Self::from_adjacency).
    pub fn extended(
        &self,
        pairs: impl IntoIterator<Item = (usize, usize)>,
    ) -> Result<Self, PatternError> {
        let known =
            (0..self.blocks()).flat_map(|i| self.row(i).iter().map(move |&j| (i, j as usize)));
        let extended = Self::from_adjacency(self.blocks(), known.chain(pairs))?;
        Ok(Self {
            absent: self.absent.clone(),
            ..extended
        })
    }

    /// The absent scalars as (block row, row in its blocks), ascending.
    pub fn absent(&self) -> &[(usize, usize)] {
        &self.absent
    }

    pub(crate) fn is_absent(&self, row: usize, scalar: usize) -> bool {
        self.absent.binary_search(&(row, scalar)).is_ok()
    }

    /// The absent scalars that blocks of this size have, as places in a vector of blocks, ascending.
    pub(crate) fn absent_places(&self, block_size: usize) -> impl Iterator<Item = usize> + '_ {
        let has = move |(_, k): &&(usize, usize)| *k < block_size;
        let place = move |(row, k): &(usize, usize)| block_size * row + k;
        self.absent.iter().filter(has).map(place)
    }

    /// The block rows without any unknown, ascending.
    pub(crate) fn empty_rows(&self, block_size: usize) -> Vec<usize> {
        let rows = self.absent.chunk_by(|a, b| a.0 == b.0);
        let is_empty = |row: &&[(usize, usize)]| {
            row.iter().filter(|(_, k)| *k < block_size).count() == block_size
        };
        rows.filter(is_empty).map(|row| row[0].0).collect()
    }

    /// Number of scalar unknowns of a system with blocks of this size.
    pub fn unknowns(&self, block_size: usize) -> usize {
        block_size * self.blocks() - self.absent_places(block_size).count()
    }

    /// Number of block rows.
    pub fn blocks(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Number of stored blocks (lower half with the diagonal).
    pub fn stored(&self) -> usize {
        self.columns.len()
    }

    /// Start of each row in [`columns`](Self::columns), `blocks + 1` entries.
    pub fn row_start(&self) -> &[usize] {
        &self.row_start
    }

    /// Column of every stored block.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// The columns of one row; the last is the row itself.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.columns[self.row_start[i]..self.row_start[i + 1]]
    }

    /// Index of the diagonal block of row `i` among the stored blocks.
    pub fn diagonal(&self, i: usize) -> usize {
        self.row_start[i + 1] - 1
    }

    /// Index of block `(i, j)` with `j ≤ i` among the stored blocks, `None` where it is zero.
    pub fn find(&self, i: usize, j: usize) -> Option<usize> {
        let column = u32::try_from(j).ok()?;
        self.row(i)
            .binary_search(&column)
            .ok()
            .map(|k| self.row_start[i] + k)
    }
}

fn cut_rows(row_start: &[usize], columns: &[u32]) -> Vec<RowChunk> {
    let blocks = row_start.len() - 1;
    let count = (columns.len() / BLOCKS_PER_CHUNK).clamp(1, MAX_CHUNKS);
    let mut chunks = Vec::with_capacity(count);
    let mut begin = 0;
    for k in 0..count {
        let target = columns.len() * (k + 1) / count;
        let end = if k + 1 == count {
            blocks
        } else {
            row_start
                .partition_point(|&s| s < target)
                .clamp(begin, blocks)
        };
        let first_column = (begin..end)
            .map(|i| columns[row_start[i]] as usize)
            .min()
            .unwrap_or(begin);
        chunks.push(RowChunk {
            rows: begin..end,
            first_column,
        });
        begin = end;
    }
    chunks
}
