//! Matrices of every kind, and a small random generator with a seed that can be printed.
#![allow(dead_code)]

use fem_kinematics::{Mat, signed_svd};

/// A linear congruential generator (Knuth's MMIX constants), good enough to scatter test points.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [−1, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn matrix<const D: usize>(&mut self) -> Mat<f64, D> {
        Mat::from_fn(|_, _| self.unit())
    }
    pub fn rotation<const D: usize>(&mut self) -> Mat<f64, D> {
        signed_svd(&self.matrix()).U
    }
    /// A rotation times a stretch near 1: det > 0 and well conditioned.
    pub fn tame<const D: usize>(&mut self) -> Mat<f64, D> {
        let stretch = std::array::from_fn(|i| 1.0 + 0.3 * i as f64 + 0.1 * self.unit());
        let (u, v) = (self.rotation::<D>(), self.rotation::<D>());
        (u * Mat::from_diagonal(stretch)).mul_tr(&v)
    }
}

pub fn largest<const D: usize>(M: &Mat<f64, D>) -> f64 {
    M.0.iter().flatten().fold(0.0, |m, x| x.abs().max(m))
}

/// Identity, rotations, repeated and nearly repeated values, every rank, inverted, tiny and huge.
pub fn matrices<const D: usize>() -> Vec<Mat<f64, D>> {
    let mut random = Random(11);
    let mut all = vec![Mat::identity(), Mat::zeros(), -Mat::<f64, D>::identity()];
    let diagonals: [[f64; 3]; 12] = [
        [1.0, 1.0, 1.0],
        [2.0, 2.0, 1.0],
        [2.0, 1.0, 1.0],
        [3.0, 1e-3, 1e-6],
        [1.0, 1.0, -1.0],
        [1.0, 0.5, -0.5],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0 + 1e-12, 1.0 - 1e-12],
        [1.0, 1e-8, -1e-8],
        [20.0, 0.1, 1e-10],
        [1.0, 1e-14, 1e-15],
    ];
    for d in diagonals {
        let diagonal = Mat::from_diagonal(std::array::from_fn(|i| d[i]));
        all.push(diagonal);
        for _ in 0..6 {
            all.push((random.rotation::<D>() * diagonal).mul_tr(&random.rotation::<D>()));
        }
    }
    // Exactly repeated values and exact ranks: small integers.
    for code in 0..60_u32 {
        all.push(Mat::from_fn(|i, j| {
            f64::from((code * 7 + (i * D + j) as u32 * code * code) % 5) - 2.0
        }));
        let permutation = Mat::from_fn(|i, j| {
            let sign = if (code >> i) & 1 == 1 { -1.0 } else { 1.0 };
            if (i + code as usize) % D == j {
                2.0 * sign
            } else {
                0.0
            }
        });
        all.push(permutation);
    }
    for _ in 0..200 {
        all.push(random.matrix());
        all.push(random.rotation());
        all.push(Mat::identity() + random.matrix().scale(1e-9));
        all.push(Mat::outer(
            std::array::from_fn(|_| random.unit()),
            std::array::from_fn(|_| random.unit()),
        ));
    }
    for scale in [1e6, 1e-6, 1e150, 1e-150, 1e300, 1e-290] {
        for _ in 0..10 {
            all.push(random.matrix().scale(scale));
        }
    }
    all
}
