//! Elastic elements: ∫ Ψ(F) dV of one material, its parameters uniform or of each element.

use crate::builder::AssemblyBuilder;
use crate::element_group::ElementGroup;
use crate::error::{AssemblyError, check_length};
use crate::shape::ElementShape;
use fem_materials::Material;
use fem_materials::field::{Local1, LocalParameters, MaterialField, ScaledMaterial};

impl<const D: usize, S: ElementShape<D>> AssemblyBuilder<D, S> {
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
        let group = ElementGroup::<D, S, M>::pack(material, &entries, self.elements(), |_| ())
            .lifted(self.threshold());
        self.term(group)
    }

    /// One material with local parameters, those of each listed element.
    ///
    /// # Errors
    /// When an element does not exist, the lists differ in length or a number is not finite.
    pub fn field<M: MaterialField<D> + 'static>(
        self,
        elements: &[usize],
        material: M,
        local: &[M::Local<f64>],
    ) -> Result<Self, AssemblyError> {
        check_length(
            "local parameters of a material",
            local.len(),
            elements.len(),
        )?;
        let mut numbers = vec![0.0; fem_materials::field::MAX_LOCAL_NUMBERS];
        for (index, parameters) in local.iter().enumerate() {
            parameters.write(&mut numbers);
            let count = <M::Local<f64> as LocalParameters<f64>>::COUNT;
            if !numbers[..count].iter().all(|number| number.is_finite()) {
                let what = "local parameters of a material, entry";
                return Err(AssemblyError::NotFinite { what, index });
            }
        }
        let entries = self.entries(elements)?;
        let of = |entry: crate::element_group::Entry| local[entry.index as usize];
        let group = ElementGroup::<D, S, M>::pack(material, &entries, self.elements(), of)
            .lifted(self.threshold());
        self.term(group)
    }

    /// One material for the whole mesh whose moduli are multiplied by a factor of each element. With
    /// the material at E = 1 Pa the factors are Young's moduli, as a mesh file may give them.
    ///
    /// ```
    /// use fem_assembly::{AssemblyBuilder, Dofs, mesh::kuhn_grid};
    /// use fem_materials::{Lame, NeoHookean, Space};
    ///
    /// let mesh = kuhn_grid(2, 1, 1, [2.0, 1.0, 1.0])?;
    /// let young: Vec<f64> = (0..12).map(|e| if e < 6 { 3e4 } else { 9e4 }).collect();
    /// let Lame { mu, lambda } = Lame::from_young_poisson(1.0, 0.45, Space::Solid)?;
    /// let dofs = Dofs::all_free(mesh.nodes())?;
    /// let flesh = NeoHookean { mu, lambda };
    /// let assembly = AssemblyBuilder::new(&mesh, dofs)?.scaled_material(flesh, &young)?.build()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// When there is not one factor for each element, or one is negative or not finite.
    pub fn scaled_material<M: Material<D> + 'static>(
        self,
        material: M,
        factors: &[f64],
    ) -> Result<Self, AssemblyError> {
        let all: Vec<usize> = (0..self.elements().len()).collect();
        if let Some((index, &factor)) = factors.iter().enumerate().find(|(_, f)| **f < 0.0) {
            return Err(AssemblyError::NegativeStiffness { index, factor });
        }
        let local: Vec<Local1<f64>> = factors.iter().map(|&factor| Local1(factor)).collect();
        self.field(&all, ScaledMaterial(material), &local)
    }
}
