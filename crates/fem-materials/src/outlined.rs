//! A material whose methods are compiled once each.

use crate::material::{Evaluation, Material, Symmetry};
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4};

/// The same material, with one compiled copy of each method and scalar type.
///
/// Kernels are inlined where they are called, as the vector dispatch needs; code that calls many
/// methods from many places, such as a test suite, compiles in a fraction of the time through
/// this wrapper. In an assembly loop it would be slow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outlined<M>(pub M);

impl<const D: usize, M: Material<D>> Material<D> for Outlined<M> {
    const SYMMETRY: Symmetry = M::SYMMETRY;
    const DECOMPOSES: bool = M::DECOMPOSES;

    #[inline(never)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        self.0.energy(F)
    }
    #[inline(never)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.0.stress(F)
    }
    #[inline(never)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        self.0.stress_differential(F, dF)
    }
    #[inline(never)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        self.0.stress_derivative(F)
    }
    #[inline(never)]
    fn projected_derivative<T: Real>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        self.0.projected_derivative(F, projection)
    }
    #[inline(never)]
    fn energy_and_stress<T: Real>(&self, F: &Mat<T, D>) -> (T, Mat<T, D>) {
        self.0.energy_and_stress(F)
    }
    #[inline(never)]
    fn evaluate<T: Real>(&self, F: &Mat<T, D>, projection: HessianProjection) -> Evaluation<T, D> {
        self.0.evaluate(F, projection)
    }
}
