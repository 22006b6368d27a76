//! What is asked with lists beside a configuration: their lengths are compared before anything is computed.

use crate::assembly::Assembly;
use crate::configuration::{Configuration, Positions};
use crate::error::{AssemblyError, check_length};
use fem_kinematics::Mat;

impl<const D: usize> Assembly<D> {
    /// det F of every element at the given positions or configuration, the least of its quadrature
    /// points; no material is evaluated.
    ///
    /// # Errors
    /// When an assembly of another number of nodes made them.
    pub fn volume_ratios<'a>(
        &self,
        at: impl Into<Positions<'a, D>>,
    ) -> Result<Vec<f64>, AssemblyError> {
        let at = at.into();
        self.check_positions(at)?;
        let of = |e: usize| {
            self.gradients_of(e, at)
                .map(|F| F.determinant())
                .fold(f64::INFINITY, |least, J| if J >= least { least } else { J })
        };
        Ok((0..self.elements.len()).map(of).collect())
    }

    /// How deep flesh lies in other flesh or in a solid, beyond rest, meters; `None` where nothing
    /// touches anything. Of other flesh only what is near as the stencils know it is looked at.
    ///
    /// # Errors
    /// When an assembly of another number of nodes made the positions.
    pub fn deepest_contact<'a>(
        &self,
        at: impl Into<Positions<'a, D>>,
    ) -> Result<Option<f64>, AssemblyError> {
        let at = at.into();
        self.check_positions(at)?;
        let depths = self.summands.iter();
        let depths = depths.filter_map(|s| s.term.deepest_contact(at.as_slice()));
        Ok(depths.reduce(f64::max))
    }

    /// F = Σₐ xₐ ∇Nₐᵀ at each quadrature point of an element; D_s D_m⁻¹ at the one of a linear one.
    ///
    /// # Errors
    /// When there is no such element, or an assembly of another number of nodes made the positions.
    pub fn deformation_gradients<'a>(
        &'a self,
        element: usize,
        at: impl Into<Positions<'a, D>>,
    ) -> Result<impl ExactSizeIterator<Item = Mat<f64, D>>, AssemblyError> {
        let (at, count) = (at.into(), self.elements.len());
        self.check_positions(at)?;
        if element >= count {
            return Err(AssemblyError::NoSuchElement { element, count });
        }
        Ok(self.gradients_of(element, at))
    }

    fn gradients_of<'a>(
        &'a self,
        element: usize,
        at: Positions<'a, D>,
    ) -> impl ExactSizeIterator<Item = Mat<f64, D>> {
        let positions = at.as_slice();
        let of = move |point| {
            self.elements
                .deformation_gradient(element, point, positions)
        };
        (0..self.elements.points_each).map(of)
    }

    /// ∂E/∂x^U (minus the nodal forces, newtons); returns [`Assembly::free_energy`].
    ///
    /// # Errors
    /// When `gradient` is not of the length [`Dofs::vector_len`](crate::Dofs::vector_len), or `at` of another
    /// assembly's.
    pub fn gradient(
        &self,
        at: Configuration<D>,
        gradient: &mut [f64],
    ) -> Result<f64, AssemblyError> {
        self.check_configuration(at)?;
        self.check_unknowns("numbers of the gradient", gradient)?;
        Ok(self.trusted_gradient(at, gradient))
    }

    /// (∂²E/∂x²) δx at every node, prescribed ones included, newtons: the adjoint of a load needs
    /// the rows that [`Assembly::hessian_vector`] leaves out.
    ///
    /// # Errors
    /// When there is not one displacement for each node, or `at` is of another assembly's lengths.
    pub fn hessian_vector_everywhere(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<Vec<[f64; D]>, AssemblyError> {
        self.check_displacement(at, displacement)?;
        Ok(self.trusted_hessian_vector_everywhere(at, displacement))
    }

    /// (∂²E/∂x^U∂x) δx without a matrix, newtons; δx is given at every node, so that it serves both
    /// the operator of a conjugate-gradient solve (δx = 0 at prescribed nodes) and the right-hand
    /// side of document 000, eq. 9 (δx ≠ 0 only there).
    ///
    /// # Errors
    /// When there is not one displacement for each node, `product` is not of the length
    /// [`Dofs::vector_len`](crate::Dofs::vector_len), or `at` of another assembly's.
    pub fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        product: &mut [f64],
    ) -> Result<(), AssemblyError> {
        self.check_displacement(at, displacement)?;
        self.check_unknowns("numbers of the product", product)?;
        self.trusted_hessian_vector(at, displacement, product);
        Ok(())
    }

    /// ∂²E/∂x^U∂c of one control: minus the force that it causes at 1 (document 000, eq. 4, for
    /// the activation of a muscle). It does not depend on that control, but may on others: the force
    /// of an activation is proportional to the strength of its muscle. 0 for a control that no term reads.
    ///
    /// # Errors
    /// When `gradient` is not of the length [`Dofs::vector_len`](crate::Dofs::vector_len), or `at` of another
    /// assembly's.
    pub fn control_gradient(
        &self,
        at: Configuration<D>,
        control: usize,
        gradient: &mut [f64],
    ) -> Result<(), AssemblyError> {
        self.check_configuration(at)?;
        self.check_unknowns("numbers of the gradient", gradient)?;
        self.trusted_control_gradient(at, control, gradient);
        Ok(())
    }

    /// The largest t for which x + τ δx is in the domain of every term for 0 ≤ τ < t, as far as the
    /// terms know it; +∞ where none says anything.
    ///
    /// # Errors
    /// When there is not one displacement for each node, or `at` is of another assembly's lengths.
    pub fn largest_step(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<f64, AssemblyError> {
        self.check_displacement(at, displacement)?;
        Ok(self.trusted_largest_step(at, displacement))
    }

    /// The largest t for which the present stencils hold everything that has an energy at x + τ δx
    /// for 0 ≤ τ < t; +∞ where no term changes its stencils. See [`Assembly::renew`].
    ///
    /// # Errors
    /// As [`Assembly::largest_step`].
    pub fn covered_step(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<f64, AssemblyError> {
        self.check_displacement(at, displacement)?;
        Ok(self.trusted_covered_step(at, displacement))
    }

    fn check_positions(&self, at: Positions<D>) -> Result<(), AssemblyError> {
        check_length("positions", at.as_slice().len(), self.rest.len())
    }

    /// That `at` has this assembly's lengths, though another may have made it.
    pub(crate) fn check_configuration(&self, at: Configuration<D>) -> Result<(), AssemblyError> {
        self.check_positions(at.into())?;
        check_length("controls", at.controls().len(), self.controls)
    }

    pub(crate) fn check_displacement(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Result<(), AssemblyError> {
        self.check_configuration(at)?;
        check_length("displacements", displacement.len(), self.rest.len())
    }

    fn check_unknowns(&self, what: &'static str, list: &[f64]) -> Result<(), AssemblyError> {
        check_length(what, list.len(), self.dofs.vector_len())
    }
}
