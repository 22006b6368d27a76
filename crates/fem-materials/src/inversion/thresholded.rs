//! The threshold on the singular values of document 000, section 5.5.

use crate::inversion::positive_threshold;
use crate::material::{Evaluation, Material, Symmetry};
use crate::registry::ParameterError;
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4, signed_svd};

/// The least singular value of F that a material gets to see; above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold(f64);

impl Threshold {
    /// PhysBAM's `failure_threshold` is 0.25.
    ///
    /// # Errors
    /// If the value is not finite and greater than 0.
    pub fn new(value: f64) -> Result<Self, ParameterError> {
        positive_threshold(value)?;
        Ok(Self(value))
    }

    /// The value.
    pub fn value(self) -> f64 {
        self.0
    }

    /// U max(F̂, threshold) Vᵀ of F = U F̂ Vᵀ; F itself, bit by bit, where nothing is below.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn lifted<T: Real, const D: usize>(self, F: &Mat<T, D>) -> Mat<T, D> {
        let svd = signed_svd(F);
        let least = T::from_f64(self.0);
        let low = svd.sigma[D - 1].lt(least);
        if !T::any(low) {
            return *F;
        }
        let lifted = svd.compose(svd.sigma.map(|s| T::select(s.lt(least), least, s)));
        // Elements above the threshold keep the bits of F.
        Mat::from_fn(|i, j| T::select(low, lifted.0[i][j], F.0[i][j]))
    }
}

/// ψ, P and dP/dF at U max(F̂, threshold) Vᵀ instead of at F = U F̂ Vᵀ.
///
/// **P is not the gradient of ψ** below the threshold: ψ is constant there while P stays as it
/// is at the threshold and pushes back. Use it with a Newton loop on forces alone; for a line
/// search on the energy take [`continued`](super::continued()). Works for fibers too, which are
/// turned by V (document 000, 5.4).
// ERRATUM: document 000 thresholds at 0, where J^(−2/3), F⁻¹ and ln J do not exist; PhysBAM uses
// 0.25.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholded<M> {
    inner: M,
    threshold: Threshold,
}

impl<M> Thresholded<M> {
    /// `threshold` is the smallest singular value that `inner` gets to see; PhysBAM's
    /// `failure_threshold` is 0.25.
    ///
    /// # Errors
    /// If the threshold is not finite and greater than 0.
    pub fn new(inner: M, threshold: f64) -> Result<Self, ParameterError> {
        let threshold = Threshold::new(threshold)?;
        Ok(Self { inner, threshold })
    }

    /// U max(F̂, threshold) Vᵀ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn lifted<T: Real, const D: usize>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.threshold.lifted(F)
    }
}

impl<const D: usize, M: Material<D>> Material<D> for Thresholded<M> {
    const SYMMETRY: Symmetry = M::SYMMETRY;
    const DECOMPOSES: bool = true;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.inner.energy(&self.lifted(F))
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.inner.stress(&self.lifted(F))
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        self.inner.stress_differential(&self.lifted(F), dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        self.inner.stress_derivative(&self.lifted(F))
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        self.inner.projected_derivative(&self.lifted(F), projection)
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        self.inner.energy_and_stress(&self.lifted(F))
    }
    #[inline(always)]
    fn evaluate<T: Real>(&self, F: &Mat<T, D>, projection: HessianProjection) -> Evaluation<T, D> {
        self.inner.evaluate(&self.lifted(F), projection)
    }
}
