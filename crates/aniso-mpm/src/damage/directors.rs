//! Structural directors and the tensor they make (document 001, alg. 1 and 2).

use crate::error::MpmError;
use fem_kinematics::{Mat, Real, polar};

/// A structural direction with its weight α.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Director<const D: usize> {
    /// Unit vector a in the frame that F maps from.
    pub direction: [f64; D],
    /// α ∈ [−1, ∞): −1 hides tension along `direction` from the driving force, so that cracks run
    /// along it; 0 is isotropic; larger values make cracks across it easier.
    pub weight: f64,
}

/// How many directors a material has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Directors<const D: usize> {
    /// None: A = I.
    Isotropic,
    /// One.
    TransverselyIsotropic(Director<D>),
    /// Two.
    Orthotropic(Director<D>, Director<D>),
}

impl<const D: usize> Directors<D> {
    /// Fibers along e₁ of the fiber frame with weight α.
    pub fn fiber(weight: f64) -> Self {
        let mut direction = [0.0; D];
        direction[0] = 1.0;
        Self::TransverselyIsotropic(Director { direction, weight })
    }

    fn as_array(&self) -> [Option<Director<D>>; 2] {
        match *self {
            Self::Isotropic => [None, None],
            Self::TransverselyIsotropic(a) => [Some(a), None],
            Self::Orthotropic(a, b) => [Some(a), Some(b)],
        }
    }

    /// A bound of the largest eigenvalue of A: 1 + Σ max(α, 0).
    #[inline(always)]
    pub(crate) fn largest_eigenvalue(&self) -> f64 {
        let weights = self
            .as_array()
            .map(|d| d.map_or(0.0, |d| d.weight.max(0.0)));
        1.0 + weights[0] + weights[1]
    }

    /// # Errors
    /// A weight below −1 or a direction that is not a unit vector.
    pub fn check(&self) -> Result<(), MpmError> {
        for director in self.as_array().into_iter().flatten() {
            if !(director.weight >= -1.0 && director.weight.is_finite()) {
                return Err(MpmError::Parameter {
                    what: "weight of a director",
                    value: director.weight,
                    need: "finite and at least -1",
                });
            }
            let length = director.direction.iter().map(|a| a * a).sum::<f64>().sqrt();
            if !((length - 1.0).abs() < 1e-6) {
                return Err(MpmError::Parameter {
                    what: "length of a director",
                    value: length,
                    need: "1",
                });
            }
        }
        Ok(())
    }

    /// A = I + Σ α_i (R a_i)(R a_i)ᵀ with the rotation R of F = R S (alg. 2).
    ///
    /// R is a rotation for every F, inverted and collapsed ones included.
    #[inline(always)]
    pub fn structural_tensor<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let mut A = Mat::identity();
        if matches!(self, Self::Isotropic) {
            return A;
        }
        let R = polar(F).R;
        for director in self.as_array().into_iter().flatten() {
            let Ra = R.mul_vec(director.direction.map(T::from_f64));
            A += Mat::outer(Ra, Ra).scale(T::from_f64(director.weight));
        }
        A
    }
}
