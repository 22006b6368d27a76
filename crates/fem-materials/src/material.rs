//! The one trait that every constitutive model implements.

use crate::isotropic;
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4, signed_svd};

/// What a rotation of the rest shape does to a model's energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Nothing: ψ(F R) = ψ(F) for every rotation R, so dP/dF is block diagonal in the frame of
    /// the singular vectors.
    Isotropic,
    /// The energy depends on directions in the rest shape, such as fibers.
    Anisotropic,
}

/// ψ, P and dP/dF at one F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation<T, const D: usize> {
    /// ψ, joules per cubic meter of rest volume.
    pub energy: T,
    /// First Piola-Kirchhoff stress P, pascals.
    pub stress: Mat<T, D>,
    /// dP/dF, pascals, made definite as the caller asked.
    pub derivative: Tensor4<T, D>,
}

/// A hyperelastic model in D dimensions: an energy density ψ(F) with its exact derivatives.
///
/// The scalar is a parameter of the methods, so that one source serves `f64`, `f32`, SIMD lanes
/// and dual numbers. Outside a model's domain (a neo-Hookean element with det F ≤ 0, say) the
/// energy is +∞; the stress there is unspecified, but assembly never uses it.
///
/// Three methods make a material; the others have defaults, and a model overrides them where a
/// closed form or a shared decomposition is cheaper.
pub trait Material<const D: usize>: Copy + Send + Sync {
    /// Whether the rest shape has preferred directions.
    const SYMMETRY: Symmetry = Symmetry::Anisotropic;
    /// Whether every evaluation decomposes F into rotations and stretches; a projected derivative of an
    /// isotropic model does in any case.
    const DECOMPOSES: bool = false;

    /// ψ(F), joules per cubic meter of rest volume (per square meter in 2D).
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

    /// ∂P/∂F with its negative eigenvalues treated as `projection` says: block by block for an
    /// isotropic model, else through the whole D²×D² matrix.
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        let by_blocks = matches!(Self::SYMMETRY, Symmetry::Isotropic);
        let svd = (by_blocks && projection != HessianProjection::None).then(|| signed_svd(F));
        // Called in one place, for it is most of the code.
        let at = match &svd {
            Some(svd) => Mat::from_diagonal(svd.sigma),
            None => *F,
        };
        let derivative = self.stress_derivative(&at);
        match svd {
            Some(svd) => isotropic::reassembled(&derivative, &svd, projection),
            None => projection.apply(&derivative),
        }
    }

    /// ψ and P together.
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        (self.energy(F), self.stress(F))
    }

    /// ψ, P and the projected dP/dF together.
    #[inline(always)]
    fn evaluate<T: Real>(&self, F: &Mat<T, D>, projection: HessianProjection) -> Evaluation<T, D> {
        let (energy, stress) = self.energy_and_stress(F);
        Evaluation {
            energy,
            stress,
            derivative: self.projected_derivative(F, projection),
        }
    }
}
