//! What an energy must tell so that it can be one of the terms of a sum.

use crate::configuration::{Configuration, Positions};
use crate::evaluations::StencilCost;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use fem_materials::HessianProjection;
use std::ops::Range;

/// One kind of energy: a sum over stencils, each a function of the positions of a few nodes.
///
/// E = Σₛ eₛ(x of the stencil's nodes, controls), joules. The methods are given a run of stencils
/// and write what they find into a sink, which keeps the rows that its owner sums and drops the
/// others; every stencil of the run must be written, in ascending order, and the same stencil must
/// always give the same numbers. `crates/fem-assembly/examples/own_term.rs` is a complete one.
///
/// A method may rely on the lengths of positions, displacements (one for each node) and controls, which
/// the assembly has checked; the positions may be any numbers.
/// Where eₛ is undefined it is +∞ (NaN counts as +∞ in the sum).
pub trait Term<const D: usize>: Send + Sync {
    /// The nodes of every stencil; asked for once, and again whenever [`Term::renew`] says so.
    fn stencils(&self) -> Stencils;

    /// Writes the energy of each stencil, joules.
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink);

    /// Writes ∂eₛ/∂x at each vertex, newtons, and the energy of each stencil, joules.
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>);

    /// Writes ∂²eₛ/∂xₐ∂x_b for each pair of vertices once (either order) and for a = b, newtons
    /// per meter; each stencil's matrix is projected as asked.
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    );

    /// Writes Σ_b (∂²eₛ/∂xₐ∂x_b) δx_b at each vertex, newtons, δx given at every node, meters.
    /// Without a method of its own, [`Term::hessian`] is multiplied.
    fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        let mut product = sink.product_with(displacement);
        self.hessian(at, HessianProjection::None, stencils, &mut product);
    }

    /// The stencils that may have an energy at these positions, whatever the controls, ascending; `None` where all
    /// may. The others have neither energy nor forces nor stiffness there, and are not evaluated. Asked once for
    /// each place: for terms of which most stencils are silent, as pairs are that are near but do not touch. Not asked of stencils that are evaluated
    /// in batches ([`Stencils::in_batches_of`]).
    fn active(&self, _at: Positions<D>) -> Option<Vec<usize>> {
        None
    }

    /// How many nodes an assembly needs for it, where its stencils may come to name others than they
    /// do now; those that they name are known.
    fn nodes(&self) -> usize {
        0
    }

    /// How many controls an evaluation needs: one more than the largest index read.
    fn controls(&self) -> usize {
        0
    }

    /// Writes ∂²eₛ/∂x∂c at each vertex for one control c. The energy is affine in each control while
    /// the others stand still, so this does not depend on c itself.
    fn control_gradient(
        &self,
        _at: Configuration<D>,
        _control: usize,
        _stencils: Range<usize>,
        _sink: &mut GradientSink<D>,
    ) {
    }

    /// The largest t for which x + τ δx is in the domain of these stencils for all 0 ≤ τ < t.
    fn largest_step(
        &self,
        _at: Configuration<D>,
        _displacement: &[[f64; D]],
        _stencils: Range<usize>,
    ) -> f64 {
        f64::INFINITY
    }

    /// Makes the stencils those that `at` and its neighborhood need, for a term that couples what
    /// is near; true when they changed. [`Assembly::renew`](crate::Assembly::renew) asks.
    fn renew(&mut self, _at: Configuration<D>) -> bool {
        false
    }

    /// The same for everywhere that a step by `displacement` leads, before the step is taken: what
    /// has an energy at `at` keeps it. Left out, what [`Term::renew`] finds where the step starts,
    /// and [`Term::covered_step`] says how far that reaches.
    fn renew_along(&mut self, at: Configuration<D>, _displacement: &[[f64; D]]) -> bool {
        self.renew(at)
    }

    /// [`Term::renew`] and [`Term::renew_along`] one after the other, for a term that can find both with one look.
    fn renew_for_step(&mut self, at: Configuration<D>, displacement: &[[f64; D]]) -> bool {
        let here = self.renew(at);
        self.renew_along(at, displacement) || here
    }

    /// Does the term push on one side alone, as contact does? Its curvature then holds for a part of a
    /// step only, and far from a solution steps are better without the negative part of it.
    fn one_sided(&self) -> bool {
        false
    }

    /// [`Term::renew`] where an equilibrium was found with the present stencils. When it calls for
    /// others, and theirs for these again, a term can settle the dispute.
    fn renew_at_equilibrium(&mut self, at: Configuration<D>) -> bool {
        self.renew(at)
    }

    /// Told that the next [`Term::renew`] or [`Term::renew_along`] must not depend on earlier ones.
    fn forget(&mut self) {}

    /// May [`Term::renew`] ever change the stencils?
    fn changes(&self) -> bool {
        false
    }

    /// The largest t for which the stencils of the last [`Term::renew`] hold everything that has an
    /// energy at x + τ δx for all 0 ≤ τ < t.
    fn covered_step(&self, _at: Configuration<D>, _displacement: &[[f64; D]]) -> f64 {
        f64::INFINITY
    }

    /// What one evaluation of a stencil is, for the counts of a report.
    fn cost(&self) -> StencilCost {
        StencilCost::default()
    }

    /// The control without which a stencil has no energy anywhere: where it is 0, the stencil is neither
    /// evaluated nor counted, as a relaxed fiber without passive tension.
    fn idle_without(&self, _stencil: usize) -> Option<usize> {
        None
    }

    /// How deep flesh lies in what the term keeps it out of, meters, 0 where nowhere; `None` of a term
    /// that keeps nothing out.
    fn deepest_contact(&self, _positions: &[[f64; D]]) -> Option<f64> {
        None
    }

    /// The mesh element that a stencil belongs to, if any: errors name it.
    fn element(&self, _stencil: usize) -> Option<usize> {
        None
    }
}

/// In the place of a node, at the end of a stencil that couples fewer than others.
pub(crate) const NOBODY: usize = usize::MAX;

/// The nodes that each stencil of a term couples.
#[derive(Clone, Debug, PartialEq)]
pub struct Stencils {
    pub(crate) nodes: Vec<usize>,
    pub(crate) vertices: usize,
    pub(crate) batch: usize,
}

impl Stencils {
    /// Stencil s couples the nodes of the s-th item; they must differ.
    pub fn new<const V: usize>(nodes: impl IntoIterator<Item = [usize; V]>) -> Self {
        Self {
            nodes: nodes.into_iter().flatten().collect(),
            vertices: V.max(1),
            batch: 1,
        }
    }

    /// Stencil s couples the nodes of the s-th item, one of them at least; they must differ. Every
    /// stencil takes the room of the largest.
    pub fn of_sizes<'a>(nodes: impl IntoIterator<Item = &'a [usize]> + Clone) -> Self {
        let sizes = nodes.clone().into_iter().map(<[usize]>::len);
        let vertices = sizes.max().unwrap_or(1).max(1);
        let mut all = Vec::new();
        for (stencil, own) in nodes.into_iter().enumerate() {
            all.extend_from_slice(own);
            all.resize((stencil + 1) * vertices, NOBODY);
        }
        Self {
            nodes: all,
            vertices,
            batch: 1,
        }
    }

    /// Runs start at multiples of `batch` and end at one or at the last stencil: for terms that
    /// evaluate several stencils side by side.
    #[must_use]
    pub fn in_batches_of(self, batch: usize) -> Self {
        let batch = batch.max(1);
        Self { batch, ..self }
    }

    /// Number of stencils.
    pub fn count(&self) -> usize {
        self.nodes.len() / self.vertices
    }
}
