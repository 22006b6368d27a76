//! A barrier in J that acts late.

use crate::material::{Material, Symmetry};
use crate::registry::ParameterError;
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = κ φ(J/J₀) with φ(u) = −(1 − u)² ln u for u < 1 and 0 beyond: nothing until the volume has
/// shrunk to the share J₀, then a wall before the element turns inside out. Below u = 0.002 the wall goes
/// on as the parabola that meets it there with two derivatives: a first guess that is inside out has
/// an energy and a way back, and what presses an element flat has to overcome 1,000 κ/J₀. Added to a
/// model with a finite energy there. Energy, stress and stiffness are continuous.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeBarrier {
    threshold: f64,
    modulus: f64,
}

/// u = J/J₀ below which the barrier is a parabola.
const PARABOLA_BELOW: f64 = 0.002;

/// φ near the place where it becomes a parabola.
struct Wall<T> {
    below: T,
    height: T,
    slope: T,
    curvature: T,
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

    /// How far u is below where the parabola begins, 0 or less, and φ, φ', φ'' at the larger of both.
    #[inline(always)]
    fn wall<T: Real>(&self, J: T) -> Wall<T> {
        let (share, begin) = (self.share(J), T::from_f64(PARABOLA_BELOW));
        let u = T::select(begin.lt(share), share, begin);
        let (left, ln) = (T::one() - u, u.ln());
        let q = left / u;
        let two = T::from_f64(2.0);
        Wall {
            below: share - u,
            height: -(left * left * ln),
            slope: left * (two * ln - q),
            curvature: q * (T::from_f64(4.0) + q) - two * ln,
        }
    }

    /// dψ/dJ = κ/J₀ φ', where φ' = (1 − u) (2 ln u − (1 − u)/u) before the parabola.
    #[inline(always)]
    fn pressure<T: Real>(&self, J: T) -> T {
        let wall = self.wall(J);
        T::from_f64(self.modulus / self.threshold) * (wall.slope + wall.curvature * wall.below)
    }

    /// d²ψ/dJ² = κ/J₀² φ'', where φ'' = −2 ln u + 4 q + q² with q = (1 − u)/u before the parabola.
    #[inline(always)]
    fn stiffness<T: Real>(&self, J: T) -> T {
        T::from_f64(self.modulus / (self.threshold * self.threshold)) * self.wall(J).curvature
    }
}

impl<const D: usize> Material<D> for VolumeBarrier {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let wall = self.wall(F.determinant());
        let half = T::from_f64(0.5) * wall.curvature * wall.below;
        T::from_f64(self.modulus) * (wall.height + wall.below * (wall.slope + half))
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        F.cofactor().scale(self.pressure(F.determinant()))
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let (J, C) = (F.determinant(), F.cofactor());
        let turned = F.cofactor_differential(dF).scale(self.pressure(J));
        C.scale(self.stiffness(J) * C.dot(dF)) + turned
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
