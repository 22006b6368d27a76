//! Elements of one material: energies, nodal gradient, Hessian and its products, eight at a time.

mod each;

use crate::configuration::Configuration;
use crate::element::{ElementBatch, LANES};
use crate::evaluations::{StencilCost, StencilKind};
use crate::rest::RestElements;
use crate::shape::ElementShape;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::stiffness::element_stiffness;
use crate::term::{Stencils, Term};
#[cfg(not(test))]
use fem_kinematics::dispatch_packed;
// Debug builds have one way, of those that a test compares.
#[cfg(test)]
use fem_kinematics::dispatch_registers as dispatch_packed;
use fem_kinematics::{F64x8, Mat, Pack, PackedKernel};
use fem_materials::HessianProjection;
use fem_materials::field::{LocalParameters, MAX_LOCAL_NUMBERS, MaterialField};
use fem_materials::inversion::Threshold;
use std::ops::Range;

/// One entry of a list (its index there) and the element that it belongs to: of each element of a
/// region, of each fiber of a field.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub index: u32,
    pub element: u32,
}

/// Elements of one material, each with its local parameters; the stencils are sorted by their first
/// row.
pub(crate) struct ElementGroup<const D: usize, S: ElementShape<D>, M> {
    material: M,
    batches: Vec<ElementBatch<D, S>>,
    elements: Vec<u32>,
    /// The local numbers of each batch.
    locals: Vec<F64x8>,
    /// Which control sets the number that the material names; empty where none does.
    control: Vec<[u32; LANES]>,
    /// How many controls an evaluation needs.
    controls: usize,
    /// Has an element no energy while its control is 0?
    vanishes: bool,
    /// The least stretch that the material gets to see, if any.
    threshold: Option<Threshold>,
}

impl<const D: usize, S: ElementShape<D>, M: MaterialField<D>> ElementGroup<D, S, M> {
    const NUMBERS: usize = <M::Local<f64> as LocalParameters<f64>>::COUNT;

    /// Packs sorted entries, eight to a batch. `local` gives the parameters of an entry.
    pub fn pack(
        material: M,
        entries: &[Entry],
        elements: &RestElements<D>,
        local: impl Fn(Entry) -> M::Local<f64>,
    ) -> Self {
        let ids: Vec<u32> = entries.iter().map(|entry| entry.element).collect();
        let mut locals = vec![F64x8::default(); Self::NUMBERS * entries.len().div_ceil(LANES)];
        let mut numbers = [0.0; MAX_LOCAL_NUMBERS];
        for (chunk, batch) in entries.chunks(LANES).enumerate() {
            let of_batch = &mut locals[chunk * Self::NUMBERS..(chunk + 1) * Self::NUMBERS];
            for lane in 0..LANES {
                local(batch[lane.min(batch.len() - 1)]).write(&mut numbers);
                for (lanes, number) in of_batch.iter_mut().zip(numbers) {
                    lanes.0[lane] = number;
                }
            }
        }
        Self {
            vanishes: false,
            material,
            batches: ids
                .chunks(LANES)
                .map(|chosen| ElementBatch::pack(chosen, elements))
                .collect(),
            elements: ids,
            locals,
            control: Vec::new(),
            controls: 0,
            threshold: None,
        }
    }

    /// Lets the material see no stretch below a threshold.
    pub fn lifted(self, threshold: Option<Threshold>) -> Self {
        Self { threshold, ..self }
    }

    /// Lets a control of each entry set the number that the material names.
    pub fn controlled(
        self,
        entries: &[Entry],
        controls: usize,
        control: impl Fn(Entry) -> usize,
    ) -> Self {
        let of_batch = |batch: &[Entry]| {
            std::array::from_fn(|lane| control(batch[lane.min(batch.len() - 1)]) as u32)
        };
        Self {
            control: entries.chunks(LANES).map(of_batch).collect(),
            controls,
            vanishes: self.material.vanishes_at_zero(),
            ..self
        }
    }

    /// The batches of a run of stencils.
    #[inline(always)]
    fn batches(&self, stencils: &Range<usize>) -> Range<usize> {
        stencils.start / LANES..stencils.end.div_ceil(LANES)
    }

    /// Do all elements of a batch have no energy, whatever their shape?
    #[inline(always)]
    fn idle(&self, batch: usize, controls: &[f64]) -> bool {
        let relaxed = |&control: &u32| controls[control as usize] == 0.0;
        M::CONTROL.is_some() && self.vanishes && self.control[batch].iter().all(relaxed)
    }

    /// The local parameters in a batch, from a lane on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn local<V: Pack>(&self, batch: usize, first: usize, controls: &[f64]) -> M::Local<V> {
        let mut numbers = [V::zero(); MAX_LOCAL_NUMBERS];
        for n in 0..Self::NUMBERS {
            numbers[n] = V::load(&self.locals[batch * Self::NUMBERS + n].0, first);
        }
        if let (Some(n), false) = (M::CONTROL, self.control.is_empty()) {
            let mut values = [0.0; LANES];
            for lane in first..first + V::WIDTH {
                values[lane] = controls[self.control[batch][lane] as usize];
            }
            numbers[n] = V::load(&values, first);
        }
        M::Local::<V>::from_numbers(&numbers)
    }
}

/// Adds the forces of a batch. Compiled once for each shape of elements, as [`add_stiffness`] and
/// [`ElementBatch::edges`].
#[inline(never)]
fn add_forces<S: ElementShape<D>, const D: usize>(
    sink: &mut GradientSink<D>,
    stencil: usize,
    forces: &S::Nodes<[F64x8; D]>,
) {
    sink.add_lanes(stencil, &forces.as_ref()[..S::NODES]);
}

/// Adds the stiffness of a batch.
#[inline(never)]
fn add_stiffness<S: ElementShape<D>, const D: usize>(
    sink: &mut HessianSink<D>,
    stencil: usize,
    used: usize,
    pairs: &S::Pairs<[[[f64; LANES]; D]; D]>,
) {
    sink.add_lanes(stencil, used, S::NODES, pairs.as_ref());
}

/// What [`ElementBatch::edges`] gives.
type Edges<S, const D: usize> = <S as ElementShape<D>>::Rows<[F64x8; D]>;

/// How many `V` the lanes of a batch take.
#[inline(always)]
const fn parts<V: Pack>() -> usize {
    LANES / V::WIDTH
}

struct EnergyPass<'a, 'b, const D: usize, S: ElementShape<D>, M> {
    group: &'a ElementGroup<D, S, M>,
    at: Configuration<'a, D>,
    batches: Range<usize>,
    sink: &'a mut EnergySink<'b>,
}
impl<const D: usize, S, M> PackedKernel for EnergyPass<'_, '_, D, S, M>
where
    S: ElementShape<D>,
    M: MaterialField<D>,
{
    type Output = ();
    const WAITS: bool = M::DECOMPOSES;
    #[inline(always)]
    fn run<V: Pack>(self) {
        let group = self.group;
        for k in self.batches {
            if group.idle(k, self.at.controls()) {
                continue;
            }
            let batch = &group.batches[k];
            let edges = batch.edges(self.at.positions());
            let mut energy = [0.0; LANES];
            for part in 0..parts::<V>() {
                let first = part * V::WIDTH;
                let local = group.local::<V>(k, first, self.at.controls());
                for point in batch.points.as_ref() {
                    let F = point.deformation_gradient::<V>(&edges, first);
                    let psi = group.material.energy(&local, &F);
                    add_energy(psi, first, &point.weight, &mut energy);
                }
            }
            for lane in 0..batch.used {
                self.sink.energy(k * LANES + lane, energy[lane]);
            }
        }
    }
}

struct GradientPass<'a, 'b, const D: usize, S: ElementShape<D>, M> {
    group: &'a ElementGroup<D, S, M>,
    at: Configuration<'a, D>,
    batches: Range<usize>,
    sink: &'a mut GradientSink<'b, D>,
}
impl<const D: usize, S, M> PackedKernel for GradientPass<'_, '_, D, S, M>
where
    S: ElementShape<D>,
    M: MaterialField<D>,
{
    type Output = ();
    const WAITS: bool = M::DECOMPOSES;
    #[inline(always)]
    fn run<V: Pack>(self) {
        let group = self.group;
        for k in self.batches {
            if group.idle(k, self.at.controls()) {
                continue;
            }
            let batch = &group.batches[k];
            let edges = batch.edges(self.at.positions());
            let mut energy = [0.0; LANES];
            let mut forces = S::nodes([F64x8::default(); D]);
            for part in 0..parts::<V>() {
                let first = part * V::WIDTH;
                let local = group.local::<V>(k, first, self.at.controls());
                let mut nodal = S::nodes([V::zero(); D]);
                for point in batch.points.as_ref() {
                    let F = point.deformation_gradient::<V>(&edges, first);
                    let (psi, P) = group.material.energy_and_stress(&local, &F);
                    add_energy(psi, first, &point.weight, &mut energy);
                    point.add_nodal_gradient(&P, first, &mut nodal);
                }
                store::<V, S, D>(&nodal, first, &mut forces);
            }
            for lane in 0..batch.used {
                self.sink.energy(k * LANES + lane, energy[lane]);
            }
            add_forces::<S, D>(self.sink, k * LANES, &forces);
        }
    }
    fn without_registers(self) {
        self.group
            .gradient_of_each(self.at, self.batches, self.sink);
    }
}

/// Adds a density times the weight of its point.
#[inline(always)]
fn add_energy<V: Pack>(density: V, first: usize, weight: &F64x8, energy: &mut [f64; LANES]) {
    let mut lanes = [0.0; LANES];
    density.store(&mut lanes, first);
    for lane in first..first + V::WIDTH {
        energy[lane] += lanes[lane] * weight.0[lane];
    }
}

/// Puts vectors at the nodes into their lanes.
#[cfg_attr(not(debug_assertions), inline(always))]
fn store<V: Pack, S: ElementShape<D>, const D: usize>(
    nodal: &S::Nodes<[V; D]>,
    first: usize,
    lanes: &mut S::Nodes<[F64x8; D]>,
) {
    let (out, nodal) = (lanes.as_mut(), nodal.as_ref());
    for a in 0..S::NODES {
        for i in 0..D {
            nodal[a][i].store(&mut out[a][i].0, first);
        }
    }
}

struct HessianPass<'a, 'b, const D: usize, S: ElementShape<D>, M> {
    group: &'a ElementGroup<D, S, M>,
    at: Configuration<'a, D>,
    batches: Range<usize>,
    sink: &'a mut HessianSink<'b, D>,
}
impl<const D: usize, S, M> PackedKernel for HessianPass<'_, '_, D, S, M>
where
    S: ElementShape<D>,
    M: MaterialField<D>,
{
    type Output = ();
    // WAITS is false: what a Hessian keeps at once is more than a decomposition waits.
    #[inline(always)]
    fn run<V: Pack>(self) {
        let group = self.group;
        let mut pairs = S::pairs([[[0.0; LANES]; D]; D]);
        for k in self.batches {
            if group.idle(k, self.at.controls()) {
                continue;
            }
            let batch = &group.batches[k];
            let edges = batch.edges(self.at.positions());
            for part in 0..parts::<V>() {
                let first = part * V::WIDTH;
                let local = group.local::<V>(k, first, self.at.controls());
                let mut stiffness = S::pairs(Mat::<V, D>::zeros());
                for point in batch.points.as_ref() {
                    let F = point.deformation_gradient::<V>(&edges, first);
                    let T = group.material.stress_derivative(&local, &F);
                    let weight = V::load(&point.weight.0, first);
                    let gradients = point.gradients::<V>(first);
                    element_stiffness::<V, S, D>(&T, &gradients, weight, &mut stiffness);
                }
                store_pairs::<V, S, D>(&stiffness, first, &mut pairs);
            }
            add_stiffness::<S, D>(self.sink, k * LANES, batch.used, &pairs);
        }
    }
    fn without_registers(self) {
        self.group
            .hessian_of_each(self.at, HessianProjection::None, self.batches, self.sink);
    }
}

/// Puts the blocks of an element's stiffness into their lanes.
#[cfg_attr(not(debug_assertions), inline(always))]
fn store_pairs<V: Pack, S: ElementShape<D>, const D: usize>(
    stiffness: &S::Pairs<Mat<V, D>>,
    first: usize,
    pairs: &mut S::Pairs<[[[f64; LANES]; D]; D]>,
) {
    let (lanes, stiffness) = (pairs.as_mut(), stiffness.as_ref());
    for p in 0..lanes.len() {
        for i in 0..D {
            for j in 0..D {
                stiffness[p].0[i][j].store(&mut lanes[p][i][j], first);
            }
        }
    }
}

struct ProductPass<'a, 'b, const D: usize, S: ElementShape<D>, M> {
    group: &'a ElementGroup<D, S, M>,
    at: Configuration<'a, D>,
    displacement: &'a [[f64; D]],
    batches: Range<usize>,
    sink: &'a mut GradientSink<'b, D>,
}
impl<const D: usize, S, M> PackedKernel for ProductPass<'_, '_, D, S, M>
where
    S: ElementShape<D>,
    M: MaterialField<D>,
{
    type Output = ();
    const WAITS: bool = M::DECOMPOSES;
    #[inline(always)]
    fn run<V: Pack>(self) {
        let group = self.group;
        for k in self.batches {
            if group.idle(k, self.at.controls()) {
                continue;
            }
            let batch = &group.batches[k];
            let edges = batch.edges(self.at.positions());
            let moved = batch.edges(self.displacement);
            let mut forces = S::nodes([F64x8::default(); D]);
            for part in 0..parts::<V>() {
                let first = part * V::WIDTH;
                let local = group.local::<V>(k, first, self.at.controls());
                let mut nodal = S::nodes([V::zero(); D]);
                for point in batch.points.as_ref() {
                    let F = point.deformation_gradient::<V>(&edges, first);
                    let dF = point.deformation_gradient::<V>(&moved, first);
                    let dP = group.material.stress_differential(&local, &F, &dF);
                    point.add_nodal_gradient(&dP, first, &mut nodal);
                }
                store::<V, S, D>(&nodal, first, &mut forces);
            }
            add_forces::<S, D>(self.sink, k * LANES, &forces);
        }
    }
}

struct ControlPass<'a, 'b, const D: usize, S: ElementShape<D>, M> {
    group: &'a ElementGroup<D, S, M>,
    at: Configuration<'a, D>,
    control: u32,
    batches: Range<usize>,
    sink: &'a mut GradientSink<'b, D>,
}
impl<const D: usize, S, M> PackedKernel for ControlPass<'_, '_, D, S, M>
where
    S: ElementShape<D>,
    M: MaterialField<D>,
{
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let group = self.group;
        for k in self.batches {
            let control = &group.control[k];
            if !control.contains(&self.control) {
                continue;
            }
            let mut listens = [0.0; LANES];
            for lane in 0..LANES {
                listens[lane] = f64::from(u8::from(control[lane] == self.control));
            }
            let batch = &group.batches[k];
            let edges = batch.edges(self.at.positions());
            let mut forces = S::nodes([F64x8::default(); D]);
            for part in 0..parts::<V>() {
                let first = part * V::WIDTH;
                let local = group.local::<V>(k, first, self.at.controls());
                let listens = V::load(&listens, first);
                let mut nodal = S::nodes([V::zero(); D]);
                for point in batch.points.as_ref() {
                    let F = point.deformation_gradient::<V>(&edges, first);
                    let P = group.material.stress_by_control(&local, &F);
                    point.add_nodal_gradient(&P.scale(listens), first, &mut nodal);
                }
                store::<V, S, D>(&nodal, first, &mut forces);
            }
            add_forces::<S, D>(self.sink, k * LANES, &forces);
            for lane in (0..batch.used).filter(|&lane| control[lane] == self.control) {
                self.sink.evaluated(k * LANES + lane);
            }
        }
    }
}

impl<const D: usize, S: ElementShape<D>, M: MaterialField<D>> Term<D> for ElementGroup<D, S, M> {
    fn stencils(&self) -> Stencils {
        let mut nodes = Vec::with_capacity(S::NODES * self.elements.len());
        for batch in &self.batches {
            for lane in 0..batch.used {
                let of_lane = batch.nodes.as_ref()[..S::NODES].iter();
                nodes.extend(of_lane.map(|lanes| lanes[lane] as usize));
            }
        }
        Stencils {
            nodes,
            vertices: S::NODES,
            batch: LANES,
        }
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        if self.threshold.is_some() {
            return self.energy_of_each(at, self.batches(&stencils), sink);
        }
        dispatch_packed(EnergyPass {
            group: self,
            at,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        if self.threshold.is_some() {
            return self.gradient_of_each(at, self.batches(&stencils), sink);
        }
        dispatch_packed(GradientPass {
            group: self,
            at,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        let batches = self.batches(&stencils);
        match projection {
            HessianProjection::None if self.threshold.is_none() => dispatch_packed(HessianPass {
                group: self,
                at,
                batches,
                sink,
            }),
            _ => self.hessian_of_each(at, projection, batches, sink),
        }
    }
    fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        if self.threshold.is_some() {
            return self.product_of_each(at, displacement, self.batches(&stencils), sink);
        }
        dispatch_packed(ProductPass {
            group: self,
            at,
            displacement,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn controls(&self) -> usize {
        self.controls
    }
    fn control_gradient(
        &self,
        at: Configuration<D>,
        control: usize,
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        // A constant of its own: the kernels below are then not compiled for a material without controls.
        if const { M::CONTROL.is_none() } {
            return;
        }
        if self.control.is_empty() || !self.material.listens() {
            return;
        }
        if self.threshold.is_some() {
            return self.control_of_each(at, control as u32, self.batches(&stencils), sink);
        }
        dispatch_packed(ControlPass {
            group: self,
            at,
            control: control as u32,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn cost(&self) -> StencilCost {
        let points = self.batches.first();
        let points = points.map_or(0, |batch| batch.points.as_ref().len() as u64);
        StencilCost {
            kind: match M::CONTROL {
                Some(_) => StencilKind::Fiber,
                None => StencilKind::Element,
            },
            decompositions: points * u64::from(M::DECOMPOSES || self.threshold.is_some()),
            projection_decompositions: points * u64::from(M::PROJECTION_DECOMPOSES),
        }
    }
    fn idle_without(&self, stencil: usize) -> Option<usize> {
        let control = || self.control[stencil / LANES][stencil % LANES] as usize;
        self.vanishes.then(control)
    }
    fn element(&self, stencil: usize) -> Option<usize> {
        Some(self.elements[stencil] as usize)
    }
}
