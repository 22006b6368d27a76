//! Chebyshev iterations of the fourth kind on `D⁻¹A` (Lottes 2023): they need the largest eigenvalue
//! alone, and damp the upper part of the spectrum as evenly as a polynomial can.

use super::entry::Entry;
use super::matrix::LevelMatrix;
use super::precision::LevelScalar;

/// A polynomial in `D⁻¹A`, symmetric in the product of `A`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smoother {
    pub degree: usize,
    /// An upper bound of the spectrum of `D⁻¹A`.
    pub largest: f64,
}

impl Smoother {
    /// Adds corrections to `x`; `r = b − A x` on entry. On return `r` is the residual before the last
    /// correction, and that correction is returned in place of `z`, so that a caller who needs the
    /// residual takes `A z` from it.
    pub fn smooth<T: LevelScalar, V: Entry<T>, const D: usize>(
        self,
        matrix: &LevelMatrix<T, D>,
        r: &mut [[V; D]],
        x: &mut [[V; D]],
        z: &mut Vec<[V; D]>,
        spare: &mut Vec<[V; D]>,
    ) {
        let first = T::narrow(4.0 / (3.0 * self.largest));
        matrix.first_correction(first, r, z, x);
        for k in 1..self.degree {
            let k = k as f64;
            let keep = T::narrow((2.0 * k - 1.0) / (2.0 * k + 3.0));
            let factor = T::narrow((8.0 * k + 4.0) / ((2.0 * k + 3.0) * self.largest));
            matrix.correction((keep, factor), z, r, spare, x);
            std::mem::swap(z, spare);
        }
    }
}
