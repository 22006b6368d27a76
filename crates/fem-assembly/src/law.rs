//! What a group of elements is made of.

use fem_kinematics::{Mat, Pack, Tensor4};
use fem_materials::{HessianProjection, Material};

/// A constitutive law with parameters that may differ from block to block and lane to lane.
///
/// A uniform [`Material`] is one; muscle fibers with their own direction and activation are another.
pub(crate) trait Law<const D: usize>: Send + Sync {
    fn energy<V: Pack>(&self, block: usize, activations: &[f64], F: &Mat<V, D>) -> V;
    fn energy_and_stress<V: Pack>(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<V, D>,
    ) -> (V, Mat<V, D>);
    fn stress_differential<V: Pack>(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<V, D>,
        dF: &Mat<V, D>,
    ) -> Mat<V, D>;
    fn derivative<V: Pack>(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<V, D>,
    ) -> Tensor4<V, D>;
    /// The filtered derivative of the element at (block, lane).
    fn filtered_derivative(
        &self,
        place: (usize, usize),
        activations: &[f64],
        F: &Mat<f64, D>,
        filter: HessianProjection,
    ) -> Tensor4<f64, D>;
    /// Does any lane of the block listen to this activation channel?
    fn has_channel(&self, _block: usize, _channel: usize) -> bool {
        false
    }
    /// ∂P/∂α of one channel; zero in lanes that do not listen to it.
    fn stress_by_activation<V: Pack>(
        &self,
        _block: usize,
        _channel: usize,
        _F: &Mat<V, D>,
    ) -> Mat<V, D> {
        Mat::zeros()
    }
}

/// One material for every element of the group.
#[derive(Clone, Copy)]
pub(crate) struct Uniform<M>(pub M);

impl<const D: usize, M: Material<D>> Law<D> for Uniform<M> {
    #[inline(always)]
    fn energy<V: Pack>(&self, _: usize, _: &[f64], F: &Mat<V, D>) -> V {
        self.0.energy(F)
    }
    #[inline(always)]
    fn energy_and_stress<V: Pack>(&self, _: usize, _: &[f64], F: &Mat<V, D>) -> (V, Mat<V, D>) {
        self.0.energy_and_stress(F)
    }
    #[inline(always)]
    fn stress_differential<V: Pack>(
        &self,
        _: usize,
        _: &[f64],
        F: &Mat<V, D>,
        dF: &Mat<V, D>,
    ) -> Mat<V, D> {
        self.0.stress_differential(F, dF)
    }
    #[inline(always)]
    fn derivative<V: Pack>(&self, _: usize, _: &[f64], F: &Mat<V, D>) -> Tensor4<V, D> {
        self.0.stress_derivative(F)
    }
    #[inline(never)]
    fn filtered_derivative(
        &self,
        _: (usize, usize),
        _: &[f64],
        F: &Mat<f64, D>,
        filter: HessianProjection,
    ) -> Tensor4<f64, D> {
        self.0.filtered_derivative(F, filter)
    }
}
