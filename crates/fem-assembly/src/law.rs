//! What a group of elements is made of.

use fem_kinematics::{Mat, Pack, Tensor4};
use fem_materials::HessianProjection;

/// A constitutive law with parameters that may differ from batch to batch and lane to lane.
///
/// A uniform material is one; muscle fibers with their own direction and control are another.
pub(crate) trait Law<const D: usize>: Send + Sync {
    fn energy<V: Pack>(&self, batch: usize, controls: &[f64], F: &Mat<V, D>) -> V;
    fn energy_and_stress<V: Pack>(
        &self,
        batch: usize,
        controls: &[f64],
        F: &Mat<V, D>,
    ) -> (V, Mat<V, D>);
    fn stress_differential<V: Pack>(
        &self,
        batch: usize,
        controls: &[f64],
        F: &Mat<V, D>,
        dF: &Mat<V, D>,
    ) -> Mat<V, D>;
    fn derivative<V: Pack>(&self, batch: usize, controls: &[f64], F: &Mat<V, D>) -> Tensor4<V, D>;
    /// The filtered derivative of the element at (batch, lane).
    fn filtered_derivative(
        &self,
        place: (usize, usize),
        controls: &[f64],
        F: &Mat<f64, D>,
        filter: HessianProjection,
    ) -> Tensor4<f64, D>;
    /// How many controls an evaluation needs.
    fn controls(&self) -> usize {
        0
    }
    /// Does any lane of the batch listen to this control?
    fn has_control(&self, _batch: usize, _control: usize) -> bool {
        false
    }
    /// ∂P/∂c of one control; zero in lanes that do not listen to it.
    fn stress_by_control<V: Pack>(
        &self,
        _batch: usize,
        _control: usize,
        _F: &Mat<V, D>,
    ) -> Mat<V, D> {
        Mat::zeros()
    }
}
