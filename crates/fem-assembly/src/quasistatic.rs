//! Equilibrium f(x^C, x^U, θ_a) = 0 as a problem for Newton's method (document 000, eq. 3).

use crate::assembly::Assembly;
use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::free_parts::FreePart;
use crate::rigid_motions::rigid_motions;
use fem_materials::HessianProjection;
use fem_solvers::{BlockPattern, BlockSymmetric, Merit, NearKernel, NonlinearProblem};
use std::borrow::Cow;
use std::sync::Arc;

/// The free nodes of an assembly, looking for the positions at which all forces on them vanish
/// while the prescribed nodes and the controls stay as given.
///
/// ```
/// use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
/// use fem_materials::NeoHookean;
/// use fem_solvers::{Newton, NewtonParams};
///
/// // A cube, its left face fixed, its right face pulled by a fifth.
/// let mesh = fem_assembly::mesh::kuhn_grid(3, 3, 3, [1.0; 3])?;
/// let is_prescribed = |p: &[f64; 3]| p[0] == 0.0 || p[0] == 1.0;
/// let prescribed: Vec<usize> = (0..64).filter(|&n| is_prescribed(&mesh.nodes()[n])).collect();
/// let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed)?;
/// let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
/// let assembly = AssemblyBuilder::new(&mesh, dofs)?.material(flesh)?.build()?;
///
/// let pulled: Vec<[f64; 3]> = mesh.nodes().iter().map(|p| [1.2 * p[0], p[1], p[2]]).collect();
/// let problem = Quasistatic::held(&assembly, pulled, vec![])?;
/// let mut x = problem.unknowns();
/// let info = Newton::new(&problem).solve(&problem, &mut x, &NewtonParams::default())?;
/// assert!(info.iterations < 10);
/// let shape = problem.positions(&x)?;
/// assert!(assembly.volume_ratios(assembly.positions(&shape)?)?.iter().all(|&j| j > 0.9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Quasistatic<'a, const D: usize> {
    assembly: &'a Assembly<D>,
    positions: Cow<'a, [[f64; D]]>,
    controls: Cow<'a, [f64]>,
    merit: Merit,
}

impl<'a, const D: usize> Quasistatic<'a, D> {
    /// `positions` holds the prescribed nodes' places and a first guess for the free ones, meters.
    ///
    /// # Errors
    /// When a list has the wrong length or a number is not finite.
    pub fn new(
        assembly: &'a Assembly<D>,
        positions: Vec<[f64; D]>,
        controls: Vec<f64>,
    ) -> Result<Self, AssemblyError> {
        assembly.configuration(&positions, &controls)?;
        Ok(Self::trusted(assembly, positions, controls))
    }

    /// The same for a body that is held: what can move with nothing to stop it is named before any solve.
    ///
    /// A body that nothing holds has an equilibrium only where all that pushes it cancels, at rest
    /// without loads for one; [`Quasistatic::new`] takes it, and a solve that fails then says what is
    /// free ([`NewtonError::undetermined`](fem_solvers::NewtonError::undetermined)).
    ///
    /// # Errors
    /// As [`Quasistatic::new`], and [`AssemblyError::Free`] where [`Assembly::free_motions`] finds any at
    /// rest. What is not touched at rest holds nothing there: [`Quasistatic::new`] is for a body that
    /// falls on a plate.
    pub fn held(
        assembly: &'a Assembly<D>,
        positions: Vec<[f64; D]>,
        controls: Vec<f64>,
    ) -> Result<Self, AssemblyError> {
        let problem = Self::new(assembly, positions, controls)?;
        match problem.free() {
            Some(free) => Err(free),
            None => Ok(problem),
        }
    }

    /// What is free at rest.
    fn free(&self) -> Option<AssemblyError> {
        let at = Configuration::trusted(self.assembly.rest(), &self.controls);
        named(&self.assembly.free_motions(at))
    }

    /// The same with lists that were checked before.
    pub(crate) fn trusted(
        assembly: &'a Assembly<D>,
        positions: impl Into<Cow<'a, [[f64; D]]>>,
        controls: impl Into<Cow<'a, [f64]>>,
    ) -> Self {
        Self {
            assembly,
            positions: positions.into(),
            controls: controls.into(),
            merit: assembly.merit,
        }
    }

    /// The same with another measure of progress: [`Merit::ResidualNorm`] for a stress that is no
    /// energy's gradient, such as [`Thresholded`](fem_materials::inversion::Thresholded). Materials of
    /// [`AssemblyBuilder::thresholded`](crate::AssemblyBuilder::thresholded) have it already.
    #[must_use]
    pub fn with_merit(self, merit: Merit) -> Self {
        Self { merit, ..self }
    }

    /// The first guess for the unknowns.
    pub fn unknowns(&self) -> Vec<f64> {
        self.assembly.dofs().trusted_gather(&self.positions)
    }

    /// All positions for given unknowns, meters.
    ///
    /// # Errors
    /// When there are not [`Dofs::vector_len`](crate::Dofs::vector_len) of them.
    pub fn positions(&self, unknowns: &[f64]) -> Result<Vec<[f64; D]>, AssemblyError> {
        let mut all = self.positions.to_vec();
        self.assembly.dofs().scatter(unknowns, &mut all)?;
        Ok(all)
    }

    pub(crate) fn trusted_positions(&self, unknowns: &[f64]) -> Vec<[f64; D]> {
        let mut all = self.positions.to_vec();
        self.assembly.dofs().trusted_scatter(unknowns, &mut all);
        all
    }

    /// [`Assembly::covered_step`] of a step of the unknowns.
    pub(crate) fn covered_step(&self, x: &[f64], dx: &[f64]) -> f64 {
        let mut displacement = vec![[0.0; D]; self.positions.len()];
        self.assembly.dofs().trusted_scatter(dx, &mut displacement);
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        self.assembly.trusted_covered_step(at, &displacement)
    }

    /// The assembly that is in equilibrium.
    pub fn assembly(&self) -> &'a Assembly<D> {
        self.assembly
    }

    /// The values of the controls.
    pub fn controls(&self) -> &[f64] {
        &self.controls
    }
}

impl<const D: usize> NonlinearProblem<D> for Quasistatic<'_, D> {
    fn blocks(&self) -> usize {
        self.assembly.dofs().free_nodes()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.assembly.pattern().clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        self.assembly.free_energy(Configuration::trusted(
            &self.trusted_positions(x),
            &self.controls,
        ))
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.energy_and_gradient(x, g);
    }
    fn energy_and_gradient(&self, x: &[f64], g: &mut [f64]) -> f64 {
        self.assembly.trusted_gradient(
            Configuration::trusted(&self.trusted_positions(x), &self.controls),
            g,
        )
    }
    fn hessian(&self, x: &[f64], projection: HessianProjection, out: &mut BlockSymmetric<D>) {
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        self.assembly.hessian(at, projection, out);
    }
    fn is_one_sided(&self) -> bool {
        self.assembly.is_one_sided()
    }
    fn one_sided_hessian(
        &self,
        x: &[f64],
        projection: HessianProjection,
        share: f64,
        out: &mut BlockSymmetric<D>,
    ) {
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        self.assembly.one_sided_hessian(at, projection, share, out);
    }
    fn merit(&self) -> Merit {
        self.merit
    }
    fn largest_step(&self, x: &[f64], dx: &[f64]) -> f64 {
        let mut displacement = vec![[0.0; D]; self.positions.len()];
        self.assembly.dofs().trusted_scatter(dx, &mut displacement);
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        self.assembly.trusted_largest_step(at, &displacement)
    }
    /// [`Assembly::force_scales`] times how far the body is strained, the largest ratio of the forces
    /// that meet in a node to its scale, at most 1; never more than the largest of those forces, so
    /// that a stiff island in soft flesh is balanced by what the flesh can do to it. Small loads, and the pressures of nearly
    /// incompressible flesh, are thus balanced to the same share as large ones, a soft part as well as
    /// a stiff one.
    fn gradient_scales(&self, x: &[f64]) -> Option<Vec<f64>> {
        let scales = self.assembly.force_scales()?;
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        let forces = self.assembly.absolute_forces(at);
        let ratios = forces.iter().zip(scales).map(|(f, s)| f / s);
        let strain = ratios.fold(0.0_f64, f64::max).min(1.0);
        let largest = forces.iter().fold(0.0_f64, |m, f| m.max(*f));
        Some(scales.iter().map(|s| largest.min(strain * s)).collect())
    }
    /// [`Assembly::force_scales`]: a strain of one.
    fn largest_gradient_scales(&self) -> Option<Vec<f64>> {
        self.assembly.force_scales().map(<[f64]>::to_vec)
    }
    fn gradient_rounding(&self, x: &[f64]) -> Option<Vec<f64>> {
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        let mut floor = self.assembly.absolute_forces(at);
        floor.iter_mut().for_each(|f| *f *= 4.0 * f64::EPSILON);
        Some(floor)
    }
    /// The parts that nothing holds at `x` ([`Assembly::free_motions`]): what came to touch holds, what
    /// let go does not. Where a part is held at rest, that is said.
    fn undetermined(&self, x: &[f64]) -> Option<String> {
        let positions = self.trusted_positions(x);
        let at = Configuration::trusted(&positions, &self.controls);
        let parts = self.assembly.free_motions(at);
        let free = named(&parts)?;
        let at_rest = Configuration::trusted(self.assembly.rest(), &self.controls);
        let at_rest = self.assembly.free_motions(at_rest);
        let was_free = at_rest.iter().any(|p| p.first_node == parts[0].first_node);
        let before = if was_free { "" } else { "held at rest, but " };
        Some(format!("{before}where the solve ended, {free}"))
    }
    /// The translations and the infinitesimal rotations of the free nodes where they are now, 3 in the
    /// plane and 6 in space, zero at prescribed axes.
    fn near_kernel(&self, x: &[f64]) -> NearKernel {
        rigid_motions(self.assembly.dofs(), x)
    }
    fn coordinates(&self) -> Option<Vec<[f64; D]>> {
        let rest = self.assembly.rest();
        Some(
            self.assembly
                .dofs()
                .node_of_row()
                .iter()
                .map(|&n| rest[n as usize])
                .collect(),
        )
    }
}

fn named<const D: usize>(parts: &[FreePart<D>]) -> Option<AssemblyError> {
    Some(AssemblyError::Free {
        part: parts.first()?.to_string(),
        others: parts.len() - 1,
    })
}
