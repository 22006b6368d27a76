//! What a group of elements is made of.

use fem_kinematics::{F64x8, Mat, Tensor4};
use fem_materials::{DefinitenessFilter, Material};

/// A constitutive law with parameters that may differ from block to block and lane to lane.
///
/// A uniform [`Material`] is one; muscle fibres with their own direction and activation are another.
pub(crate) trait Law<const D: usize>: Send + Sync {
    fn energy(&self, block: usize, activations: &[f64], F: &Mat<F64x8, D>) -> F64x8;
    fn energy_and_stress(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<F64x8, D>,
    ) -> (F64x8, Mat<F64x8, D>);
    fn stress_differential(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<F64x8, D>,
        dF: &Mat<F64x8, D>,
    ) -> Mat<F64x8, D>;
    fn derivative(
        &self,
        block: usize,
        activations: &[f64],
        F: &Mat<F64x8, D>,
        filter: DefinitenessFilter,
    ) -> Tensor4<F64x8, D>;
    /// Does any lane of the block listen to this activation channel?
    fn has_channel(&self, _block: usize, _channel: usize) -> bool {
        false
    }
    /// ∂P/∂α of one channel; zero in lanes that do not listen to it.
    fn stress_by_activation(
        &self,
        _block: usize,
        _channel: usize,
        _F: &Mat<F64x8, D>,
    ) -> Mat<F64x8, D> {
        Mat::zeros()
    }
}

/// One material for every element of the group.
#[derive(Clone, Copy)]
pub(crate) struct Uniform<M>(pub M);

impl<const D: usize, M: Material<D>> Law<D> for Uniform<M> {
    #[inline(always)]
    fn energy(&self, _: usize, _: &[f64], F: &Mat<F64x8, D>) -> F64x8 {
        self.0.energy(F)
    }
    #[inline(always)]
    fn energy_and_stress(&self, _: usize, _: &[f64], F: &Mat<F64x8, D>) -> (F64x8, Mat<F64x8, D>) {
        self.0.energy_and_stress(F)
    }
    #[inline(always)]
    fn stress_differential(
        &self,
        _: usize,
        _: &[f64],
        F: &Mat<F64x8, D>,
        dF: &Mat<F64x8, D>,
    ) -> Mat<F64x8, D> {
        self.0.stress_differential(F, dF)
    }
    #[inline(always)]
    fn derivative(
        &self,
        _: usize,
        _: &[f64],
        F: &Mat<F64x8, D>,
        filter: DefinitenessFilter,
    ) -> Tensor4<F64x8, D> {
        match filter {
            DefinitenessFilter::None => self.0.stress_derivative(F),
            _ => self.0.filtered_derivative(F, filter),
        }
    }
}
