//! Energy, forces and Hessian of a whole mesh.

use crate::active::{Active, Remembered};
use crate::configuration::{Configuration, Positions};
use crate::dofs::Dofs;
use crate::error::AssemblyError;
use crate::evaluations::{Counter, Evaluations, Pass};
use crate::plan::{self, Chunk, Piece, Summand, Work};
use crate::rest::RestElements;
use crate::sink::{EnergySink, GradientSink, HessianSink, NONE, Summed, Target, pair};
use fem_materials::HessianProjection;
use fem_solvers::parallel::map;
use fem_solvers::{BlockPattern, BlockSymmetric, Merit};
use std::sync::{Arc, OnceLock};

/// A mesh with the terms of its energy, ready to be evaluated in any configuration.
///
/// Positions and displacements are given for every node of the mesh, in its own numbering;
/// results are given for the free nodes (x^U), in the numbering of [`Dofs`], 0 at prescribed axes. All sums have a fixed
/// order: the same bits for any number of threads.
///
/// A [`Configuration`] is made by [`Assembly::configuration`], which checks its lengths once; lists beside it are
/// refused where they have another length than the assembly asks for.
///
/// # Panics
/// The methods that return no error may panic in a [`Configuration`] that an assembly of fewer nodes or controls made,
/// or with a matrix on another pattern than [`Assembly::pattern`].
pub struct Assembly<const D: usize> {
    pub(crate) dofs: Dofs<D>,
    pub(crate) rest: Vec<[f64; D]>,
    pub(crate) elements: RestElements<D>,
    pub(crate) pattern: Arc<BlockPattern>,
    pub(crate) summands: Vec<Summand<D>>,
    pub(crate) chunks: Vec<Chunk>,
    /// Of each stencil of each term: is it felt by a free node?
    pub(crate) free: Vec<bool>,
    pub(crate) free_pieces: Vec<Piece>,
    pub(crate) prescribed_pieces: Vec<Piece>,
    pub(crate) controls: usize,
    pub(crate) merit: Merit,
    pub(crate) force_scales: OnceLock<Option<Vec<f64>>>,
    pub(crate) counter: Counter,
    pub(crate) active: Remembered<D>,
    /// Must the next look find the pattern anew?
    pub(crate) forgets: bool,
}

impl<const D: usize> std::fmt::Debug for Assembly<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Assembly")
            .field("nodes", &self.rest.len())
            .field("elements", &self.elements.len())
            .field("free_nodes", &self.dofs.free_nodes())
            .field("terms", &self.summands.len())
            .field("controls", &self.controls)
            .finish_non_exhaustive()
    }
}

impl<const D: usize> Assembly<D> {
    /// Positions of all nodes (meters) and values of all controls, checked.
    ///
    /// # Errors
    /// When a list has the wrong length or a number is not finite.
    pub fn configuration<'a>(
        &self,
        positions: &'a [[f64; D]],
        controls: &'a [f64],
    ) -> Result<Configuration<'a, D>, AssemblyError> {
        Configuration::checked(positions, controls, (self.rest.len(), self.controls))
    }
    /// Positions of all nodes, meters, checked: for what no control has a part in.
    ///
    /// # Errors
    /// When the list has the wrong length or a number is not finite.
    pub fn positions<'a>(
        &self,
        positions: &'a [[f64; D]],
    ) -> Result<Positions<'a, D>, AssemblyError> {
        Positions::checked(positions, self.rest.len())
    }
    /// The split into prescribed and free coordinates.
    pub fn dofs(&self) -> &Dofs<D> {
        &self.dofs
    }
    /// Rest positions of all nodes, meters.
    pub fn rest(&self) -> &[[f64; D]] {
        &self.rest
    }
    /// Places of the Hessian's blocks, lower half; prescribed axes of partly free nodes are
    /// [absent](BlockPattern::with_absent), which makes them padding of their blocks and no unknowns.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }
    /// Number of controls.
    pub fn controls(&self) -> usize {
        self.controls
    }
    /// What has been evaluated so far.
    pub fn evaluations(&self) -> Evaluations {
        self.counter.read()
    }
    /// Rest volume of each element, m³ (m² in 2D).
    pub fn volumes(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        (0..self.elements.len()).map(|e| self.elements.volume(e))
    }

    /// The nodes of an element.
    pub fn nodes_of(&self, element: usize) -> &[u32] {
        self.elements.nodes_of(element)
    }

    /// Energy of everything, prescribed elements included, joules; +∞ outside a term's domain.
    pub fn energy(&self, at: Configuration<D>) -> f64 {
        let prescribed = self.energies(at, false);
        self.free_energy(at) + self.sum(&prescribed, false)
    }

    /// Energy of the stencils that free nodes feel, joules: what an equilibrium minimizes.
    pub fn free_energy(&self, at: Configuration<D>) -> f64 {
        self.sum(&self.energies(at, true), true)
    }

    /// The first element (in mesh order) whose energy is not finite.
    pub fn element_outside_domain(&self, at: Configuration<D>) -> Option<usize> {
        let free = self.outside(&self.energies(at, true));
        let prescribed = self.prescribed_element_outside_domain(at);
        free.into_iter().chain(prescribed).min()
    }

    /// The first element (in mesh order) without a free node whose energy is not finite: nothing that
    /// an equilibrium could find would mend it.
    pub fn prescribed_element_outside_domain(&self, at: Configuration<D>) -> Option<usize> {
        self.outside(&self.energies(at, false))
    }

    fn outside(&self, energies: &[f64]) -> Option<usize> {
        let outside = self.summands.iter().flat_map(|summand| {
            let energies = &energies[summand.first_energy..];
            (0..summand.stencils.count())
                .filter(|&s| !energies[s].is_finite())
                .filter_map(|s| summand.term.element(s))
        });
        outside.min()
    }

    /// [`Assembly::gradient`] of lists that were checked before.
    pub(crate) fn trusted_gradient(&self, at: Configuration<D>, gradient: &mut [f64]) -> f64 {
        self.count(Pass::Gradient, |summand| summand.felt(at.controls()));
        let energies = self.by_rows(
            at,
            gradient,
            Summed::AsTheyAre,
            |summand, stencils, sink| {
                summand.term.gradient(at, stencils, sink);
            },
        );
        self.clear_prescribed_axes(gradient);
        let mut by_stencil = vec![0.0; self.free.len()];
        for (stencil, energy) in energies.into_iter().flatten() {
            by_stencil[stencil as usize] = energy;
        }
        self.sum(&by_stencil, true)
    }

    /// Σₛ |∂eₛ/∂x| for each unknown, newtons: the forces whose sum [`Assembly::gradient`] is; its
    /// rounding is ε times a few of them.
    pub fn absolute_forces(&self, at: Configuration<D>) -> Vec<f64> {
        self.count(Pass::Gradient, |summand| summand.felt(at.controls()));
        let mut sums = vec![0.0; self.dofs.vector_len()];
        self.by_rows(
            at,
            &mut sums,
            Summed::Absolutely,
            |summand, stencils, sink| {
                summand.term.gradient(at, stencils, sink);
            },
        );
        self.clear_prescribed_axes(&mut sums);
        sums
    }

    /// Nodal forces f = −∂E/∂x at every node, prescribed ones included, newtons: at equilibrium the
    /// reaction that a prescribed node exerts on the body is −f.
    pub fn forces_everywhere(&self, at: Configuration<D>) -> Vec<[f64; D]> {
        self.count(Pass::Gradient, |summand| summand.all(at.controls()));
        let mut forces = self.everywhere(at, |summand, stencils, sink| {
            summand.term.gradient(at, stencils, sink);
        });
        let numbers = forces.as_flattened_mut();
        numbers.iter_mut().for_each(|f| *f = -*f);
        forces
    }

    /// [`Assembly::hessian_vector_everywhere`] of lists that were checked before.
    pub(crate) fn trusted_hessian_vector_everywhere(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> Vec<[f64; D]> {
        self.count(Pass::Product, |summand| summand.all(at.controls()));
        self.everywhere(at, |summand, stencils, sink| {
            summand
                .term
                .hessian_vector(at, displacement, stencils, sink);
        })
    }

    /// Does a term push on one side alone ([`Term::one_sided`](crate::Term::one_sided))?
    pub fn is_one_sided(&self) -> bool {
        self.summands.iter().any(|s| s.term.one_sided())
    }

    /// ∂²E/∂x^U∂x^U, symmetric, newtons per meter, on [`Assembly::pattern`]. Stencils are projected one by
    /// one as asked.
    pub fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        hessian: &mut BlockSymmetric<D>,
    ) {
        self.count(Pass::Hessian(projection), |summand| {
            summand.felt(at.controls())
        });
        self.hessian_by_term(at, |_| [(projection, 1.0), (projection, 0.0)], hessian);
    }

    /// The same where `share` (0 to 1) of the negative curvature of terms that push on one side alone is
    /// left out, whatever the others' projection.
    pub fn one_sided_hessian(
        &self,
        at: Configuration<D>,
        others: HessianProjection,
        share: f64,
        hessian: &mut BlockSymmetric<D>,
    ) {
        let (none, clamp) = (HessianProjection::None, HessianProjection::Clamp);
        let of = |summand: &Summand<D>| match summand.term.one_sided() {
            true => [(clamp, share), (none, 1.0 - share)],
            false => [(others, 1.0), (others, 0.0)],
        };
        let felt_by = |summand: &Summand<D>, one_sided: bool| match summand.term.one_sided() {
            own if own == one_sided => summand.felt(at.controls()),
            _ => 0,
        };
        self.count(Pass::Hessian(others), |summand| felt_by(summand, false));
        for (projection, weight) in [(clamp, share), (none, 1.0 - share)] {
            if weight != 0.0 {
                self.count(Pass::Hessian(projection), |summand| felt_by(summand, true));
            }
        }
        self.hessian_by_term(at, of, hessian);
    }

    /// Each term's Hessian as a sum of two, with their weights.
    fn hessian_by_term(
        &self,
        at: Configuration<D>,
        parts: impl Fn(&Summand<D>) -> [(HessianProjection, f64); 2] + Sync,
        hessian: &mut BlockSymmetric<D>,
    ) {
        let mut pieces = Vec::with_capacity(self.chunks.len());
        let mut rest = hessian.values_mut();
        let starts = self.pattern.row_start();
        for chunk in &self.chunks {
            let size = starts[chunk.rows.end] - starts[chunk.rows.start];
            let (piece, tail) = std::mem::take(&mut rest).split_at_mut(size);
            pieces.push((chunk, piece));
            rest = tail;
        }
        let active = self.active.at(&self.summands, at.into());
        map::<_, (), ()>(pieces, |(chunk, values)| {
            values.fill([[0.0; D]; D]);
            for (term, (summand, planned)) in self.summands.iter().zip(&chunk.works).enumerate() {
                let pattern = Some(&*self.pattern);
                let made = self.made(term, chunk, &active, pattern);
                let Some(work) = planned.as_ref().or(made.as_ref()) else {
                    continue;
                };
                let pairs = pair(summand.stencils.vertices, 0);
                // Runs are a chunk's own: one part of all of them, then the next, or the order of sums would be.
                let parts = parts(summand)
                    .into_iter()
                    .filter(|(_, scale)| *scale != 0.0);
                for ((projection, scale), run) in
                    parts.flat_map(|part| work.runs.iter().map(move |run| (part, run)))
                {
                    let target = Target::Matrix {
                        first: run.stencils.start,
                        pairs,
                        places: &work.places[run.start * pairs..],
                        values,
                    };
                    let mut sink = HessianSink { scale, target };
                    for stencils in active.runs(term, run.stencils.clone()) {
                        summand.term.hessian(at, projection, stencils, &mut sink);
                    }
                }
            }
        });
        hessian.fill_padding();
    }

    /// [`Assembly::hessian_vector`] of lists that were checked before.
    pub(crate) fn trusted_hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        product: &mut [f64],
    ) {
        self.count(Pass::Product, |summand| summand.felt(at.controls()));
        self.by_rows(at, product, Summed::AsTheyAre, |summand, stencils, sink| {
            summand
                .term
                .hessian_vector(at, displacement, stencils, sink);
        });
        self.clear_prescribed_axes(product);
    }

    /// [`Assembly::control_gradient`] of lists that were checked before.
    pub(crate) fn trusted_control_gradient(
        &self,
        at: Configuration<D>,
        control: usize,
        gradient: &mut [f64],
    ) {
        let evaluated = self.by_rows(
            at,
            gradient,
            Summed::AsTheyAre,
            |summand, stencils, sink| {
                if control < summand.term.controls() {
                    summand.term.control_gradient(at, control, stencils, sink);
                }
            },
        );
        let evaluated = || {
            evaluated
                .iter()
                .flatten()
                .map(|&(stencil, _)| stencil as usize)
        };
        self.count(Pass::ByControl, |summand| {
            let own = summand.first_energy..summand.first_energy + summand.stencils.count();
            evaluated().filter(|stencil| own.contains(stencil)).count() as u64
        });
        self.clear_prescribed_axes(gradient);
    }

    /// [`Assembly::largest_step`] of lists that were checked before.
    pub(crate) fn trusted_largest_step(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> f64 {
        let of = |summand: &Summand<D>| {
            let all = 0..summand.stencils.count();
            summand.term.largest_step(at, displacement, all)
        };
        self.summands.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// [`Assembly::covered_step`] of lists that were checked before.
    pub(crate) fn trusted_covered_step(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> f64 {
        let of = |summand: &Summand<D>| summand.term.covered_step(at, displacement);
        self.summands.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Runs `work` on every run of every chunk, as far as it is active, into the chunk's own zeroed rows;
    /// returns the energies of the stencils that each chunk owns.
    fn by_rows(
        &self,
        at: Configuration<D>,
        rows: &mut [f64],
        summed: Summed,
        work: impl Fn(&Summand<D>, std::ops::Range<usize>, &mut GradientSink<D>) + Sync,
    ) -> Vec<Vec<(u32, f64)>> {
        let mut pieces = Vec::with_capacity(self.chunks.len());
        let (mut rest, _) = rows.as_chunks_mut::<D>();
        for chunk in &self.chunks {
            let (piece, tail) = std::mem::take(&mut rest).split_at_mut(chunk.rows.len());
            pieces.push((chunk, piece));
            rest = tail;
        }
        let active = self.active.at(&self.summands, at.into());
        let of_chunk = |(chunk, rows): (&Chunk, &mut [[f64; D]])| {
            rows.fill([0.0; D]);
            let mut energies = Vec::new();
            for (term, (summand, planned)) in self.summands.iter().zip(&chunk.works).enumerate() {
                let made = self.made(term, chunk, &active, None);
                let Some(Work {
                    runs,
                    rows: places,
                    owned,
                    ..
                }) = planned.as_ref().or(made.as_ref())
                else {
                    continue;
                };
                let vertices = summand.stencils.vertices;
                for run in runs {
                    let mut sink = GradientSink {
                        first: run.stencils.start,
                        vertices,
                        scale: 1.0,
                        rows: &places[run.start * vertices..],
                        nodes: &summand.stencils.nodes,
                        sums: rows,
                        owned: &owned[run.start..],
                        first_energy: summand.first_energy,
                        energies: Some(&mut energies),
                        summed,
                    };
                    for stencils in active.runs(term, run.stencils.clone()) {
                        work(summand, stencils, &mut sink);
                    }
                }
            }
            energies
        };
        map(pieces, of_chunk)
    }

    /// What is active in a chunk of a term that changes; `None` for others, which are planned.
    fn made(
        &self,
        term: usize,
        chunk: &Chunk,
        active: &Active,
        pattern: Option<&BlockPattern>,
    ) -> Option<Work> {
        if chunk.works[term].is_some() {
            return None;
        }
        let stencils = &self.summands[term].stencils;
        let runs = active.runs(term, 0..stencils.count());
        let work = plan::work_on(stencils, runs, &chunk.rows, &self.dofs, pattern);
        Some(work)
    }

    /// Runs `work` on every active stencil; every node has a row.
    fn everywhere(
        &self,
        at: Configuration<D>,
        work: impl Fn(&Summand<D>, std::ops::Range<usize>, &mut GradientSink<D>),
    ) -> Vec<[f64; D]> {
        let mut sums = vec![[0.0; D]; self.rest.len()];
        let active = self.active.at(&self.summands, at.into());
        for (term, summand) in self.summands.iter().enumerate() {
            let runs = active.runs(term, 0..summand.stencils.count());
            add_everywhere(summand, runs, &work, &mut sums);
        }
        sums
    }

    /// Hessian times displacement and ∂E/∂x of one term at every node.
    pub(crate) fn everywhere_of(
        &self,
        summand: &Summand<D>,
        at: Configuration<D>,
        displacement: &[[f64; D]],
    ) -> (Vec<[f64; D]>, Vec<[f64; D]>) {
        let mut met = vec![[0.0; D]; self.rest.len()];
        let mut pulls = met.clone();
        let product = |summand: &Summand<D>, stencils, sink: &mut GradientSink<D>| {
            (summand.term).hessian_vector(at, displacement, stencils, sink);
        };
        let gradient = |summand: &Summand<D>, stencils, sink: &mut GradientSink<D>| {
            summand.term.gradient(at, stencils, sink);
        };
        let all = || std::iter::once(0..summand.stencils.count());
        add_everywhere(summand, all(), &product, &mut met);
        add_everywhere(summand, all(), &gradient, &mut pulls);
        (met, pulls)
    }

    pub(crate) fn count(&self, pass: Pass, stencils: impl Fn(&Summand<D>) -> u64) {
        for summand in &self.summands {
            self.counter.add(pass, summand.cost, stencils(summand));
        }
    }

    fn clear_prescribed_axes(&self, rows: &mut [f64]) {
        for &(row, axis) in self.dofs.prescribed_axes() {
            rows[D * row as usize + axis] = 0.0;
        }
    }

    /// Energy of each stencil that a free node feels, or of each of the others; what is not asked for
    /// may be 0.
    fn energies(&self, at: Configuration<D>, free: bool) -> Vec<f64> {
        let pieces = match free {
            true => &self.free_pieces,
            false => &self.prescribed_pieces,
        };
        self.count(Pass::Energy, |summand| match free {
            true => summand.felt(at.controls()),
            false => summand.prescribed(at.controls()),
        });
        let mut energies = vec![0.0; self.free.len()];
        let (mut rest, mut done) = (energies.as_mut_slice(), 0);
        let mut outputs = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let start = self.summands[piece.term].first_energy + piece.stencils.start;
            let (_, tail) = std::mem::take(&mut rest).split_at_mut(start - done);
            let (output, tail) = tail.split_at_mut(piece.stencils.len());
            outputs.push((piece, output));
            rest = tail;
            done = start + piece.stencils.len();
        }
        let active = self.active.at(&self.summands, at.into());
        map::<_, (), ()>(outputs, |(piece, energies): (&Piece, &mut [f64])| {
            let mut sink = EnergySink {
                first: piece.stencils.start,
                scale: 1.0,
                energies,
            };
            for stencils in active.runs(piece.term, piece.stencils.clone()) {
                let term = &self.summands[piece.term].term;
                term.energy(at, stencils, &mut sink);
            }
        });
        energies
    }

    /// Σ in the order (term, stencil) over the free stencils or the others, compensated: what a line
    /// search compares must not depend on the chunks and should not lose digits.
    fn sum(&self, energies: &[f64], free: bool) -> f64 {
        let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
        for (&energy, &of_free) in energies.iter().zip(&self.free) {
            if of_free != free {
                continue;
            }
            let next = sum + energy;
            lost += if sum.abs() >= energy.abs() {
                (sum - next) + energy
            } else {
                (energy - next) + sum
            };
            sum = next;
        }
        if sum.is_finite() {
            sum + lost
        } else {
            f64::INFINITY
        }
    }
}

/// Runs `work` on stencils of a term, adding at the nodes' own places.
fn add_everywhere<const D: usize>(
    summand: &Summand<D>,
    runs: impl Iterator<Item = std::ops::Range<usize>>,
    work: &impl Fn(&Summand<D>, std::ops::Range<usize>, &mut GradientSink<D>),
    sums: &mut [[f64; D]],
) {
    let nodes = &summand.stencils.nodes;
    let mut rows: Vec<u32> = nodes.iter().map(|&n| n as u32).collect();
    let whole = summand.stencils.batch * summand.stencils.vertices;
    rows.resize(rows.len().next_multiple_of(whole), NONE);
    let mut sink = GradientSink {
        first: 0,
        vertices: summand.stencils.vertices,
        scale: 1.0,
        rows: &rows,
        nodes,
        sums,
        owned: &[],
        first_energy: summand.first_energy,
        energies: None,
        summed: Summed::AsTheyAre,
    };
    for stencils in runs {
        work(summand, stencils, &mut sink);
    }
}
