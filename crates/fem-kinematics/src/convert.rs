//! Conversions to and from nalgebra's fixed-size matrices.

use crate::mat::Mat;
use nalgebra::SMatrix;

impl<const D: usize> From<SMatrix<f64, D, D>> for Mat<f64, D> {
    fn from(m: SMatrix<f64, D, D>) -> Self {
        Self::from_fn(|i, j| m[(i, j)])
    }
}

impl<const D: usize> From<Mat<f64, D>> for SMatrix<f64, D, D> {
    fn from(m: Mat<f64, D>) -> Self {
        Self::from_fn(|i, j| m.0[i][j])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        let m = Mat([[1.0, 2.0], [3.0, 4.0]]);
        let n = SMatrix::<f64, 2, 2>::from(m);
        assert_eq!(n[(0, 1)], 2.0);
        assert_eq!(Mat::from(n), m);
    }
}
