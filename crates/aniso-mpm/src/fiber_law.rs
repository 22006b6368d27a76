//! The anisotropic energy of document 001, sections 3.1 and 3.6, as a law whose damage is a per-particle
//! number in the particle's own scalar.
//!
//! The closed form is [`QrTerm`]: no QR decomposition is needed, because r₁₁ = |F e₁|,
//! √(r₁₂² + r₂₂²) = |F e₂|, Π r_ii = det F and Σ r_ij² = |F|².

use crate::law::Law;
use fem_kinematics::{Mat, Real};
use fem_materials::qr::QrTerm;
use fem_materials::{Lame, LameError, Space, degradation};

/// Fibers along e₁ (and in 3D e₂) of the fiber frame in a matrix that can tear; the fibers cannot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiberReinforced {
    /// μ of the model, Pa.
    pub mu: f64,
    /// λ of the model, Pa: Lamé's λ plus μ.
    pub lambda: f64,
    /// Fiber stiffness along e₁, Pa.
    pub kx: f64,
    /// Fiber stiffness along e₂, Pa; 3D only.
    pub ky: f64,
    /// What is left of the stiffness at d = 1, 0 to 1.
    pub residual: f64,
}

impl FiberReinforced {
    /// From Young's modulus (Pa) and Poisson's ratio of the matrix in 3D (plane strain in 2D).
    ///
    /// # Errors
    /// Unless E > 0 and −1 < ν < 1/2.
    pub fn from_young_poisson(
        young: f64,
        poisson: f64,
        kx: f64,
        ky: f64,
    ) -> Result<Self, LameError> {
        let Lame { mu, lambda } = Lame::from_young_poisson(young, poisson, Space::Solid)?;
        // ERRATUM: the model's λ is Lamé's plus μ (section 3.1 reads as if they were the same).
        Ok(Self {
            mu,
            lambda: lambda + mu,
            kx,
            ky,
            residual: 1e-3,
        })
    }

    /// The coefficients at damage d: g(d) = (1 − r)(1 − d)² + r on the μ terms always, on the λ
    /// term for J ≥ 1, on the fibers never (section 3.6).
    #[inline(always)]
    fn term<T: Real, const D: usize>(&self, F: &Mat<T, D>, d: T) -> QrTerm<T> {
        let g = degradation(d, T::from_f64(self.residual));
        QrTerm {
            mu: T::from_f64(self.mu),
            lambda: T::from_f64(self.lambda),
            kx: T::from_f64(self.kx),
            ky: T::from_f64(self.ky),
        }
        .degraded(g, F)
    }
}

impl<const D: usize> Law<D> for FiberReinforced {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>, d: T) -> T {
        self.term(F, d).energy(F)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>, d: T) -> Mat<T, D> {
        self.term(F, d).stress(F)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>, d: T) -> Mat<T, D> {
        self.term(F, d).stress_differential(F, dF)
    }
}
