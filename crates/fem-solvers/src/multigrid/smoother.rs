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

#[cfg(test)]
mod tests {
    use super::Smoother;
    use crate::block_matrix::{BlockPattern, BlockSymmetric};
    use crate::multigrid::matrix::LevelMatrix;
    use crate::multigrid::rows::Rows;
    use std::sync::Arc;

    /// Of each eigenvector the part W_k(1 − 2 λ/λ_max)/(2 k + 1) is left,
    /// W_k(cos θ) = sin((k + ½) θ)/sin(θ/2).
    #[test]
    fn what_a_polynomial_leaves_of_an_eigenvector_is_its_closed_form() {
        let pattern = Arc::new(BlockPattern::from_adjacency(2, [(0, 1)]).unwrap());
        let mut matrix = BlockSymmetric::<1>::zeros(pattern.clone());
        matrix
            .values_mut()
            .copy_from_slice(&[[[2.0]], [[-1.2]], [[2.0]]]);
        let mut level = LevelMatrix::<f64, 1>::new(Rows::new(&pattern));
        level.update(&matrix, 1.0).unwrap();
        // Of D⁻¹A.
        for (vector, eigenvalue) in [([[1.0], [1.0]], 0.4), ([[1.0], [-1.0]], 1.6)] {
            for degree in 1..6 {
                let largest = 1.9;
                let smoother = Smoother { degree, largest };
                let mut r = vector.map(|v: [f64; 1]| [2.0 * eigenvalue * v[0]]).to_vec();
                let mut x = vec![[0.0]; 2];
                let (mut z, mut spare) = (x.clone(), x.clone());
                smoother.smooth(&level, &mut r, &mut x, &mut z, &mut spare);
                let angle = (1.0 - 2.0 * eigenvalue / largest).acos();
                let odd = (2 * degree + 1) as f64;
                let left = (0.5 * odd * angle).sin() / ((0.5 * angle).sin() * odd);
                for (x, v) in x.iter().zip(&vector) {
                    assert!(
                        (v[0] - x[0] - left * v[0]).abs() < 1e-14,
                        "{degree} {eigenvalue}"
                    );
                }
            }
        }
    }
}
