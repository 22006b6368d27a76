//! Collects mesh, constraints and terms into an [`Assembly`].

use crate::active::Remembered;
use crate::assembly::Assembly;
use crate::dofs::Dofs;
use crate::element_group::Entry;
use crate::error::{AssemblyError, check_length};
use crate::evaluations::Counter;
use crate::mesh::{QuadraticMesh, SimplexMesh};
use crate::plan::{self, Chunk, Summand};
use crate::rest::RestElements;
use crate::shape::{ElementShape, Linear, Quadratic};
use crate::term::Term;
use crate::terms::Scaled;
use fem_materials::inversion::Threshold;
use fem_solvers::{Merit, parallel};
use std::marker::PhantomData;
use std::sync::Arc;

/// Builds an [`Assembly`].
///
/// ```
/// use fem_assembly::{AssemblyBuilder, Dofs};
/// use fem_materials::NeoHookean;
///
/// let mesh = fem_assembly::mesh::kuhn_grid(2, 2, 2, [1.0; 3])?;
/// let prescribed: Vec<usize> = (0..9).collect();
/// let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed)?;
/// let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
/// let assembly = AssemblyBuilder::new(&mesh, dofs)?.material(flesh)?.build()?;
/// let at_rest = assembly.configuration(mesh.nodes(), &[])?;
/// assert!(assembly.energy(at_rest).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct AssemblyBuilder<const D: usize, S = Linear> {
    dofs: Dofs<D>,
    rest: Vec<[f64; D]>,
    elements: RestElements<D>,
    shape: PhantomData<S>,
    summands: Vec<Summand<D>>,
    /// Stencils of all terms.
    stencils: usize,
    controls: usize,
    /// The control that terms are changed by, if any.
    change: Option<usize>,
    /// The least stretch that materials get to see, if any.
    threshold: Option<Threshold>,
    merit: Merit,
}

impl<const D: usize> AssemblyBuilder<D> {
    /// Takes the rest shape and the split into prescribed and free coordinates.
    ///
    /// # Errors
    /// When the constraints are those of another mesh, or an element is too thin to invert D_m.
    pub fn new(mesh: &SimplexMesh<D>, dofs: Dofs<D>) -> Result<Self, AssemblyError> {
        same_nodes(mesh.nodes().len(), &dofs)?;
        let elements = RestElements::linear(mesh.elements(), mesh.nodes(), dofs.rank())?;
        Ok(Self::of(mesh.nodes(), dofs, elements))
    }
}

impl<const D: usize> AssemblyBuilder<D, Quadratic>
where
    Quadratic: ElementShape<D>,
{
    /// The same for quadratic triangles (3 quadrature points) or tetrahedra (4 points).
    ///
    /// ```
    /// use fem_assembly::mesh::{QuadraticMesh, kuhn_grid};
    /// use fem_assembly::{AssemblyBuilder, Dofs};
    /// use fem_materials::NeoHookean;
    ///
    /// let mesh = QuadraticMesh::from_linear(&kuhn_grid(2, 2, 2, [1.0; 3])?)?;
    /// let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
    /// let dofs = Dofs::all_free(mesh.nodes())?;
    /// let assembly = AssemblyBuilder::quadratic(&mesh, dofs)?.material(flesh)?.build()?;
    /// assert!((assembly.volumes().sum::<f64>() - 1.0).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`AssemblyBuilder::new`].
    pub fn quadratic(mesh: &QuadraticMesh<D>, dofs: Dofs<D>) -> Result<Self, AssemblyError> {
        same_nodes(mesh.nodes().len(), &dofs)?;
        let edges = QuadraticMesh::<D>::edges_of_an_element();
        let (rest, rank) = (mesh.nodes(), dofs.rank());
        let elements = RestElements::quadratic::<Quadratic>(mesh.elements(), edges, rest, rank)?;
        Ok(Self::of(rest, dofs, elements))
    }
}

fn same_nodes<const D: usize>(expected: usize, dofs: &Dofs<D>) -> Result<(), AssemblyError> {
    check_length("nodes of the constraints", dofs.nodes(), expected)
}

impl<const D: usize, S: ElementShape<D>> AssemblyBuilder<D, S> {
    fn of(rest: &[[f64; D]], dofs: Dofs<D>, elements: RestElements<D>) -> Self {
        Self {
            dofs,
            rest: rest.to_vec(),
            elements,
            shape: PhantomData,
            summands: Vec::new(),
            stencils: 0,
            controls: 0,
            change: None,
            threshold: None,
            merit: Merit::Energy,
        }
    }

    /// Adds a kind of energy; all that are given add up.
    ///
    /// # Errors
    /// When a stencil names a node that does not exist, or one twice; when there are more than 2³²
    /// stencils.
    pub fn term(self, term: impl Term<D> + 'static) -> Result<Self, AssemblyError> {
        self.boxed(Box::new(term))
    }

    fn boxed(self, term: Box<dyn Term<D>>) -> Result<Self, AssemblyError> {
        match self.change {
            Some(control) => self.summand(Box::new(Scaled::changed_by(term, control)?)),
            None => self.summand(term),
        }
    }

    fn summand(mut self, term: Box<dyn Term<D>>) -> Result<Self, AssemblyError> {
        let stencils = term.stencils();
        stencils.check(self.summands.len(), self.rest.len())?;
        if let (count, Some(node)) = (self.rest.len(), term.nodes().checked_sub(1))
            && node >= count
        {
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        let first_energy = self.stencils;
        self.stencils += stencils.count();
        if u32::try_from(self.stencils).is_err() {
            let count = self.stencils;
            return Err(AssemblyError::TooManyStencils { count });
        }
        self.controls = self.controls.max(term.controls());
        self.summands.push(Summand {
            cost: term.cost(),
            felt: 0,
            idle: Vec::new(),
            term,
            stencils,
            first_energy,
        });
        Ok(self)
    }

    /// Whatever `add` adds has its energy times 1 + c, c being the control with this index: the
    /// relative change of a region's stiffness or of a muscle's strength ([`Scaled::changed_by`]).
    ///
    /// ```
    /// use fem_assembly::{AssemblyBuilder, AssemblyError, Dofs};
    /// use fem_materials::NeoHookean;
    ///
    /// let mesh = fem_assembly::mesh::kuhn_grid(2, 1, 1, [2.0, 1.0, 1.0])?;
    /// let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
    /// let stretched: Vec<[f64; 3]> = mesh.nodes().iter().map(|p| p.map(|c| 1.1 * c)).collect();
    /// let body = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes())?)?
    ///     .changed_by(0, |builder| builder.region(&[0, 1, 2, 3, 4, 5], flesh))?
    ///     .build()?;
    /// let energy = |change: f64| {
    ///     Ok::<f64, AssemblyError>(body.energy(body.configuration(&stretched, &[change])?))
    /// };
    /// assert!((energy(0.5)? - 1.5 * energy(0.0)?).abs() < 1e-9 * energy(0.0)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of `add`, and when what it adds may read this control itself.
    pub fn changed_by<E>(
        mut self,
        control: usize,
        add: impl FnOnce(Self) -> Result<Self, E>,
    ) -> Result<Self, E> {
        let outer = self.change.replace(control);
        let mut added = add(self)?;
        added.change = outer;
        Ok(added)
    }

    /// The materials and fibers that `add` adds see U max(F̂, threshold) Vᵀ in place of F = U F̂ Vᵀ, as
    /// [`Thresholded`](fem_materials::inversion::Thresholded) does: what ln J or F⁻¹ forbids may turn
    /// inside out (document 000, 5.5). Below the threshold the forces are then no energy's gradient, and
    /// their Hessian is that at the threshold: [`Quasistatic`](crate::Quasistatic) makes progress by
    /// [`Merit::ResidualNorm`].
    ///
    /// ```
    /// use fem_assembly::{AssemblyBuilder, AssemblyError, Dofs};
    /// use fem_materials::NeoHookean;
    /// use fem_materials::inversion::Threshold;
    ///
    /// let mesh = fem_assembly::mesh::kuhn_grid(1, 1, 1, [1.0; 3])?;
    /// let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
    /// let mirrored: Vec<[f64; 3]> = mesh.nodes().iter().map(|p| [-p[0], p[1], p[2]]).collect();
    /// let body = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes())?)?
    ///     .thresholded(Threshold::new(0.25)?, |builder| builder.material(flesh))?
    ///     .build()?;
    /// assert!(body.energy(body.configuration(&mirrored, &[])?).is_finite());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of `add`.
    pub fn thresholded<E>(
        mut self,
        threshold: Threshold,
        add: impl FnOnce(Self) -> Result<Self, E>,
    ) -> Result<Self, E> {
        let outer = self.threshold.replace(threshold);
        let mut added = add(self)?;
        added.threshold = outer;
        added.merit = Merit::ResidualNorm;
        Ok(added)
    }

    /// An evaluation will be given at least so many controls.
    #[must_use]
    pub fn controls(mut self, count: usize) -> Self {
        self.controls = self.controls.max(count);
        self
    }

    pub(crate) fn rest(&self) -> &[[f64; D]] {
        &self.rest
    }
    /// Number of terms so far.
    pub(crate) fn terms(&self) -> usize {
        self.summands.len()
    }
    pub(crate) fn elements(&self) -> &RestElements<D> {
        &self.elements
    }
    pub(crate) fn threshold(&self) -> Option<Threshold> {
        self.threshold
    }

    /// An entry for each of these elements, by first row and then as given.
    pub(crate) fn entries(&self, elements: &[usize]) -> Result<Vec<Entry>, AssemblyError> {
        let count = self.elements.len();
        let check = |(index, &element): (usize, &usize)| {
            if element < count {
                let (index, element) = (index as u32, element as u32);
                Ok(Entry { index, element })
            } else {
                Err(AssemblyError::NoSuchElement { element, count })
            }
        };
        let entries: Result<Vec<Entry>, _> = elements.iter().enumerate().map(check).collect();
        let mut entries = entries?;
        entries.sort_by_key(|entry| self.elements.first_rows[entry.element as usize]);
        Ok(entries)
    }

    /// Finds who sums what.
    ///
    /// # Errors
    /// When the Hessian's blocks cannot be counted with 32 bits.
    pub fn build(self) -> Result<Assembly<D>, AssemblyError> {
        let Self {
            dofs,
            rest,
            elements,
            mut summands,
            controls,
            merit,
            ..
        } = self;
        let pattern = plan::pattern(&dofs, &summands)?;
        let chunks = parallel::map(plan::cut(&dofs, &summands), |rows| {
            let planned = |s: &Summand<D>| s.planned(&rows, &dofs, &pattern);
            let works = summands.iter().map(planned).collect();
            Chunk { rows, works }
        });
        let free = plan::free(&mut summands, &dofs);
        Ok(Assembly {
            free_pieces: plan::pieces(&summands, &free, true),
            prescribed_pieces: plan::pieces(&summands, &free, false),
            free,
            dofs,
            rest,
            elements,
            pattern: Arc::new(pattern),
            chunks,
            summands,
            controls,
            merit,
            force_scales: std::sync::OnceLock::new(),
            counter: Counter::default(),
            active: Remembered::nothing(),
            forgets: false,
        })
    }
}
