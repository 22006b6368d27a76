//! How large a quantity is, and how much one rounding of F moves it: the measure of every error.

use crate::Material;
use fem_kinematics::{Mat, Tensor4};

pub(super) fn norm<const D: usize>(m: &Mat<f64, D>) -> f64 {
    m.norm_squared().sqrt()
}

/// Scales for errors in ψ, P and ∂P/∂F at one deformation.
///
/// A relative change ε of F moves ψ by up to ε|P||F| and P by up to ε|∂P/∂F||F|, which no code
/// can avoid; where ψ or P is a small difference of large terms the next derivative is what
/// shows their size.
pub(super) struct Sizes {
    pub(super) energy: f64,
    pub(super) stress: f64,
    pub(super) derivative: f64,
}

impl Sizes {
    pub(super) fn at<const D: usize, M: Material<D>>(material: &M, F: &Mat<f64, D>) -> Self {
        let (length, P) = (norm(F), norm(&material.stress(F)));
        let tensor = material.stress_derivative(F);
        let derivative = tensor.norm();
        // ∂P/∂F moves by its own derivative, sampled here along a fixed skewed direction.
        let nudge = 1e-6;
        let moved = Mat::from_fn(|i, j| {
            let sign = if (i + 2 * j) % 3 == 1 { -1.0 } else { 1.0 };
            F[(i, j)] * (1.0 + nudge * sign)
        });
        let shift = (material.stress_derivative(&moved) + tensor.scale(-1.0)).norm() / nudge;
        let shift = if shift.is_finite() { shift } else { 0.0 };
        let floor = f64::MIN_POSITIVE;
        Self {
            energy: material.energy(F).abs() + P * length + derivative * length * length + floor,
            stress: P + derivative * length + floor,
            derivative: derivative + shift + floor,
        }
    }
}

pub(super) trait Norm {
    fn norm(&self) -> f64;
}

impl<const D: usize> Norm for Tensor4<f64, D> {
    fn norm(&self) -> f64 {
        self.0
            .iter()
            .flatten()
            .map(Mat::norm_squared)
            .sum::<f64>()
            .sqrt()
    }
}
