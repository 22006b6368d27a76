//! The sum of two models.

use crate::isotropic;
use crate::material::{Material, Symmetry};
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = ψ₁ + ψ₂.
///
/// Where both parts are isotropic the sum is projected as one; otherwise part by part, which
/// gives a (somewhat stiffer) definite derivative too.
///
/// ```
/// use fem_materials::{Material, MooneyRivlin, Sum, VolumetricLog};
/// let flesh = Sum(MooneyRivlin { A: 6e4, B: 2e4 }, VolumetricLog { K: 6e4 });
/// let rest = fem_kinematics::Mat::<f64, 3>::identity();
/// assert!(flesh.stress(&rest).norm_squared() < 1e-18);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum<M, N>(pub M, pub N);

impl<const D: usize, M: Material<D>, N: Material<D>> Material<D> for Sum<M, N> {
    const SYMMETRY: Symmetry = match (M::SYMMETRY, N::SYMMETRY) {
        (Symmetry::Isotropic, Symmetry::Isotropic) => Symmetry::Isotropic,
        _ => Symmetry::Anisotropic,
    };
    const DECOMPOSES: bool = M::DECOMPOSES || N::DECOMPOSES;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.0.energy(F) + self.1.energy(F)
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.0.stress(F) + self.1.stress(F)
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        self.0.stress_differential(F, dF) + self.1.stress_differential(F, dF)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        self.0.stress_derivative(F) + self.1.stress_derivative(F)
    }
    #[inline(always)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        match <Self as Material<D>>::SYMMETRY {
            Symmetry::Isotropic if projection != HessianProjection::None => {
                isotropic::projected(F, projection, |F_hat| self.stress_derivative(F_hat))
            }
            _ => {
                self.0.projected_derivative(F, projection)
                    + self.1.projected_derivative(F, projection)
            }
        }
    }
    #[inline(always)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        let (a, P) = self.0.energy_and_stress(F);
        let (b, Q) = self.1.energy_and_stress(F);
        (a + b, P + Q)
    }
}
