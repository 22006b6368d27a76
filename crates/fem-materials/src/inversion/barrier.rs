//! A barrier in J that acts late.

use crate::material::{Material, Symmetry};
use crate::near_rest::infinite_unless_positive;
use crate::registry::ParameterError;
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = −κ (1 − u)² ln u for u = J/J₀ < 1, 0 for u ≥ 1, +∞ for J ≤ 0: nothing until the volume has
/// shrunk to the share J₀, then a wall before the element turns inside out. Added to a model with a
/// finite energy there. Energy, stress and stiffness are continuous at J₀.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBarrier {
    threshold: f64,
    modulus: f64,
}

impl VolumeBarrier {
    /// J₀ = `threshold` and κ = `modulus`, Pa.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] for a threshold outside (0, 1), which would act at rest, and a
    /// modulus that is not positive.
    pub fn new(threshold: f64, modulus: f64) -> Result<Self, ParameterError> {
        let out = |name, value, range| Err(ParameterError::OutOfRange { name, value, range });
        if !(threshold > 0.0 && threshold < 1.0) {
            return out("threshold", threshold, "greater than 0 and less than 1");
        }
        if !(modulus > 0.0 && modulus.is_finite()) {
            return out("modulus", modulus, "finite and greater than 0");
        }
        Ok(Self { threshold, modulus })
    }

    /// u = J/J₀ where that is less than 1, or 1.
    #[inline(always)]
    fn share<T: Real>(&self, J: T) -> T {
        let u = J * T::from_f64(1.0 / self.threshold);
        T::select(u.lt(T::one()), u, T::one())
    }

    /// dψ/dJ = κ/J₀ (1 − u) (2 ln u − (1 − u)/u).
    #[inline(always)]
    fn pressure<T: Real>(&self, J: T) -> T {
        let u = self.share(J);
        let left = T::one() - u;
        let rise = left * (T::from_f64(2.0) * u.ln() - left / u);
        T::from_f64(self.modulus / self.threshold) * rise
    }

    /// d²ψ/dJ² = κ/J₀² (−2 ln u + 4 q + q²) with q = (1 − u)/u.
    #[inline(always)]
    fn stiffness<T: Real>(&self, J: T) -> T {
        let u = self.share(J);
        let q = (T::one() - u) / u;
        let curve = q * (T::from_f64(4.0) + q) - T::from_f64(2.0) * u.ln();
        T::from_f64(self.modulus / (self.threshold * self.threshold)) * curve
    }
}

impl<const D: usize> Material<D> for VolumeBarrier {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let J = F.determinant();
        let u = self.share(J);
        let left = T::one() - u;
        infinite_unless_positive(J, T::from_f64(-self.modulus) * left * left * u.ln())
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        F.cofactor().scale(self.pressure(F.determinant()))
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let (J, C) = (F.determinant(), F.cofactor());
        // d(cof F) = (cof F (cof F : dF) − cof F dFᵀ cof F) / J.
        let turned = C.scale(C.dot(dF)) - C * dF.tr_mul(&C);
        C.scale(self.stiffness(J) * C.dot(dF)) + turned.scale(self.pressure(J) / J)
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let (J, C) = (F.determinant(), F.cofactor());
        Terms::new()
            .outer(self.stiffness(J), &C, &C)
            .cofactor(self.pressure(J), F)
            .0
    }
}
