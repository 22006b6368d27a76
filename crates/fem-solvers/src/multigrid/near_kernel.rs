//! Vectors that a matrix nearly takes to zero.

use thiserror::Error;

/// Linearly independent vectors that a matrix takes to nearly zero wherever nothing holds: what its
/// coarse corrections must be able to move. The translations and rotations of a solid, the constants of
/// a conductor. Values that are held in place are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct NearKernel {
    vectors: Vec<Vec<f64>>,
}

/// Why vectors are no near kernel.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NearKernelError {
    /// Another number of vectors than the hierarchy was made for.
    #[error("{found} vectors of the near kernel, the coarse blocks are for {expected}")]
    Count {
        /// Vectors given.
        found: usize,
        /// Size of a coarse block.
        expected: usize,
    },
    /// A vector of the wrong length.
    #[error(
        "vector {vector} of the near kernel has length {found}, the matrix has {expected} rows"
    )]
    Length {
        /// Which vector.
        vector: usize,
        /// Its length.
        found: usize,
        /// Rows of the matrix.
        expected: usize,
    },
    /// A NaN or an infinity.
    #[error("vector {vector} of the near kernel is not finite at index {index}")]
    NonFinite {
        /// Which vector.
        vector: usize,
        /// First bad index.
        index: usize,
    },
}

impl NearKernel {
    /// Each vector has an entry for every scalar row of the matrix, in any unit.
    pub fn new(vectors: Vec<Vec<f64>>) -> Self {
        Self { vectors }
    }

    /// One constant for each of `D` components of `blocks` blocks: enough for `D` separate Laplacians.
    pub fn constants<const D: usize>(blocks: usize) -> Self {
        let unit = |c: usize| (0..D * blocks).map(move |k| f64::from(u8::from(k % D == c)));
        Self::new((0..D).map(|c| unit(c).collect()).collect())
    }

    /// How many vectors.
    pub fn count(&self) -> usize {
        self.vectors.len()
    }

    /// The vectors.
    pub fn vectors(&self) -> &[Vec<f64>] {
        &self.vectors
    }

    /// One D×K block for each block row.
    pub(super) fn blocks<const D: usize, const K: usize>(
        &self,
        rows: usize,
    ) -> Result<Vec<[[f64; K]; D]>, NearKernelError> {
        let (found, expected) = (self.count(), K);
        if found != expected {
            return Err(NearKernelError::Count { found, expected });
        }
        for (vector, values) in self.vectors.iter().enumerate() {
            let (found, expected) = (values.len(), D * rows);
            if found != expected {
                return Err(NearKernelError::Length {
                    vector,
                    found,
                    expected,
                });
            }
            if let Some(index) = crate::vector::first_non_finite(values) {
                return Err(NearKernelError::NonFinite { vector, index });
            }
        }
        let block =
            |i: usize| std::array::from_fn(|r| std::array::from_fn(|k| self.vectors[k][D * i + r]));
        Ok((0..rows).map(block).collect())
    }
}
