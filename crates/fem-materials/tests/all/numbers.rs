//! Random deformations and norms that the tests share.

use fem_kinematics::{Dual, Mat, Tensor4};

/// A small deterministic generator; the conformance suite draws fresh numbers each run.
pub struct Numbers(pub u64);

impl Numbers {
    /// Uniform in [−1, 1).
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn matrix<const D: usize>(&mut self) -> Mat<f64, D> {
        Mat::from_fn(|_, _| self.next())
    }
    pub fn rotation<const D: usize>(&mut self) -> Mat<f64, D> {
        fem_kinematics::signed_qr(&self.matrix::<D>()).Q
    }
}

pub fn dual<const D: usize>(F: &Mat<f64, D>, dF: &Mat<f64, D>) -> Mat<Dual<f64>, D> {
    Mat::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]))
}

pub fn norm<const D: usize>(m: &Mat<f64, D>) -> f64 {
    m.norm_squared().sqrt()
}

pub fn tensor_norm<const D: usize>(t: &Tensor4<f64, D>) -> f64 {
    let mut sum = 0.0;
    for row in &t.0 {
        for block in row {
            sum += block.norm_squared();
        }
    }
    sum.sqrt()
}

/// |a − b|/|b| of two tensors.
pub fn tensor_error<const D: usize>(a: &Tensor4<f64, D>, b: &Tensor4<f64, D>) -> f64 {
    tensor_norm(&(*a + b.scale(-1.0))) / tensor_norm(b)
}

/// |a − b|/|b|.
pub fn error<const D: usize>(a: &Mat<f64, D>, b: &Mat<f64, D>) -> f64 {
    norm(&(*a - *b)) / norm(b)
}
