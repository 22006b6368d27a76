//! Elastic elements: ∫ Ψ(F) dV of one material.

use crate::builder::AssemblyBuilder;
use crate::element_group::ElementGroup;
use crate::error::AssemblyError;
use crate::law::Law;
use fem_kinematics::{Mat, Pack, Tensor4};
use fem_materials::{HessianProjection, Material};

impl<const D: usize> AssemblyBuilder<D> {
    /// One material for the whole mesh. Materials given to the same element add up.
    ///
    /// # Errors
    /// None today; the signature matches [`AssemblyBuilder::region`].
    pub fn material<M: Material<D> + 'static>(self, material: M) -> Result<Self, AssemblyError> {
        let all: Vec<usize> = (0..self.elements().len()).collect();
        self.region(&all, material)
    }

    /// One material for some elements. Materials given to the same element add up.
    ///
    /// # Errors
    /// When an element does not exist.
    pub fn region<M: Material<D> + 'static>(
        self,
        elements: &[usize],
        material: M,
    ) -> Result<Self, AssemblyError> {
        let entries = self.entries(elements)?;
        let group = ElementGroup::pack(Uniform(material), &entries, self.elements());
        self.term(group)
    }
}

/// One material for every element of the group.
#[derive(Clone, Copy)]
struct Uniform<M>(M);

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
