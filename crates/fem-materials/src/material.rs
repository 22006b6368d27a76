//! The one trait that every constitutive model implements.

use fem_kinematics::{Mat, Real, Tensor4};

/// A hyperelastic model in D dimensions: an energy density ψ(F) with its exact derivatives.
///
/// The scalar is a parameter of the methods, so that one source serves `f64`, `f32`, SIMD lanes
/// and dual numbers. Outside a model's domain (a neo-Hookean element with det F ≤ 0, say) the
/// energy is +∞; the stress there is unspecified, but assembly never uses it.
pub trait Material<const D: usize>: Copy + Send + Sync {
    /// ψ(F), joules per cubic metre of rest volume (per square metre in 2D).
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T;

    /// First Piola-Kirchhoff stress P = ∂ψ/∂F, pascals.
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D>;

    /// dP = ∂P/∂F : dF.
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D>;

    /// ∂P/∂F, pascals.
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        Tensor4::from_linear_map(|dF| self.stress_differential(F, dF))
    }
}
