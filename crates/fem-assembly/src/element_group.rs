//! The elements of one law: energies, nodal gradient, Hessian and its products, eight at a time.

use crate::configuration::Configuration;
use crate::element::{ElementBatch, LANES, PAIRS, RestElement, VERTICES};
use crate::law::Law;
use crate::sink::{EnergySink, GradientSink, HessianSink, pair};
use crate::term::{Stencils, Term};
use fem_kinematics::{F64x8, Mat, Pack, PackedKernel, Real, Tensor4, dispatch_packed};
use fem_materials::HessianProjection;
use std::ops::Range;

/// One entry of a list (its index there) and the element that it belongs to: of each element of a
/// region, of each fiber of a field.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub index: u32,
    pub element: u32,
}

/// Elements of one law; the stencils are sorted by their first row.
pub(crate) struct ElementGroup<const D: usize, L> {
    law: L,
    batches: Vec<ElementBatch<D>>,
    elements: Vec<u32>,
}

impl<const D: usize, L: Law<D>> ElementGroup<D, L> {
    /// Packs sorted entries, eight to a batch.
    pub fn pack(law: L, entries: &[Entry], elements: &[RestElement<D>]) -> Self {
        let rest: Vec<RestElement<D>> = entries
            .iter()
            .map(|entry| elements[entry.element as usize])
            .collect();
        Self {
            law,
            batches: rest.chunks(LANES).map(ElementBatch::pack).collect(),
            elements: entries.iter().map(|entry| entry.element).collect(),
        }
    }

    /// The batches of a run of stencils.
    #[inline(always)]
    fn batches(&self, stencils: &Range<usize>) -> Range<usize> {
        stencils.start / LANES..stencils.end.div_ceil(LANES)
    }
}

struct EnergyPass<'a, 'b, const D: usize, L> {
    group: &'a ElementGroup<D, L>,
    at: Configuration<'a, D>,
    batches: Range<usize>,
    sink: &'a mut EnergySink<'b>,
}
impl<const D: usize, L: Law<D>> PackedKernel for EnergyPass<'_, '_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let start = self.batches.start;
        for (offset, batch) in self.group.batches[self.batches].iter().enumerate() {
            let k = start + offset;
            let F = batch.deformation_gradient::<V>(self.at.positions());
            let density = self.group.law.energy(k, self.at.controls(), &F).to_lanes();
            for lane in 0..batch.used {
                self.sink
                    .energy(k * LANES + lane, density.0[lane] * batch.volume.0[lane]);
            }
        }
    }
}

struct GradientPass<'a, 'b, const D: usize, L> {
    group: &'a ElementGroup<D, L>,
    at: Configuration<'a, D>,
    batches: Range<usize>,
    sink: &'a mut GradientSink<'b, D>,
}
impl<const D: usize, L: Law<D>> PackedKernel for GradientPass<'_, '_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let start = self.batches.start;
        for (offset, batch) in self.group.batches[self.batches].iter().enumerate() {
            let k = start + offset;
            let F = batch.deformation_gradient::<V>(self.at.positions());
            let (psi, P) = self.group.law.energy_and_stress(k, self.at.controls(), &F);
            let density = psi.to_lanes();
            for lane in 0..batch.used {
                self.sink
                    .energy(k * LANES + lane, density.0[lane] * batch.volume.0[lane]);
            }
            let nodal = batch.nodal_gradient(&P);
            self.sink.add_lanes(k * LANES, &nodal[..=D]);
        }
    }
}

struct HessianPass<'a, 'b, const D: usize, L> {
    group: &'a ElementGroup<D, L>,
    at: Configuration<'a, D>,
    batches: Range<usize>,
    sink: &'a mut HessianSink<'b, D>,
}
impl<const D: usize, L: Law<D>> PackedKernel for HessianPass<'_, '_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let mut pairs = [[[[0.0; LANES]; VERTICES]; VERTICES]; PAIRS];
        let start = self.batches.start;
        for (offset, batch) in self.group.batches[self.batches].iter().enumerate() {
            let k = start + offset;
            let F = batch.deformation_gradient::<V>(self.at.positions());
            let T = self.group.law.derivative(k, self.at.controls(), &F);
            let volume = V::from_lanes(batch.volume);
            let stiffness = element_stiffness(&T, &batch.inverse_shape::<V>(), volume);
            for (pair, lanes) in stiffness.iter().zip(&mut pairs) {
                for i in 0..D {
                    for j in 0..D {
                        lanes[i][j] = pair.0[i][j].to_lanes().0;
                    }
                }
            }
            self.sink.add_lanes(k * LANES, batch.used, &pairs);
        }
    }
}

/// The Hessian of projected elements, one at a time: the projections decompose F, which in registers
/// for three instruction sets would multiply the size of the program for a path that few steps take.
fn projected_hessian<const D: usize, L: Law<D>>(
    group: &ElementGroup<D, L>,
    at: Configuration<D>,
    projection: HessianProjection,
    batches: Range<usize>,
    sink: &mut HessianSink<D>,
) {
    let mut pairs = [[[[0.0; LANES]; VERTICES]; VERTICES]; PAIRS];
    for k in batches {
        let batch = &group.batches[k];
        let F = batch.deformation_gradient::<F64x8>(at.positions());
        for lane in 0..batch.used {
            let of_lane = |m: &Mat<F64x8, D>| Mat::<f64, D>::from_fn(|i, j| m.0[i][j].0[lane]);
            let place = (k, lane);
            let T = group
                .law
                .filtered_derivative(place, at.controls(), &of_lane(&F), projection);
            let gradients = of_lane(&batch.inverse_shape);
            let stiffness = element_stiffness(&T, &gradients, batch.volume.0[lane]);
            for (pair, lanes) in stiffness.iter().zip(&mut pairs) {
                for i in 0..D {
                    for j in 0..D {
                        lanes[i][j][lane] = pair.0[i][j];
                    }
                }
            }
        }
        sink.add_lanes(k * LANES, batch.used, &pairs);
    }
}

/// K_ab = V Σⱼₗ (∇Nₐ)ⱼ (∇N_b)ₗ T(j, l) for every pair a ≥ b; vertex 0 follows from Σₐ Nₐ = 1.
#[inline(always)]
fn element_stiffness<T: Real, const D: usize>(
    derivative: &Tensor4<T, D>,
    gradients: &Mat<T, D>,
    volume: T,
) -> [Mat<T, D>; PAIRS] {
    let mut stiffness = [Mat::zeros(); PAIRS];
    let mut corner = Mat::zeros();
    let mut border = [Mat::zeros(); VERTICES];
    for b in 0..D {
        let mut half = [Mat::zeros(); D];
        for j in 0..D {
            half[j] = derivative.0[j][0].scale(gradients.0[b][0]);
            for l in 1..D {
                half[j] += derivative.0[j][l].scale(gradients.0[b][l]);
            }
        }
        for a in b..D {
            let mut block = half[0].scale(gradients.0[a][0]);
            for j in 1..D {
                block += half[j].scale(gradients.0[a][j]);
            }
            let block = block.scale(volume);
            stiffness[pair(a + 1, b + 1)] = block;
            border[a + 1] -= block;
            if a != b {
                border[b + 1] -= block.transpose();
            }
        }
    }
    for a in 1..=D {
        stiffness[pair(a, 0)] = border[a];
        corner -= border[a];
    }
    stiffness[0] = corner.symmetric_part();
    stiffness
}

struct ProductPass<'a, 'b, const D: usize, L> {
    group: &'a ElementGroup<D, L>,
    at: Configuration<'a, D>,
    displacement: &'a [[f64; D]],
    batches: Range<usize>,
    sink: &'a mut GradientSink<'b, D>,
}
impl<const D: usize, L: Law<D>> PackedKernel for ProductPass<'_, '_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        let start = self.batches.start;
        for (offset, batch) in self.group.batches[self.batches].iter().enumerate() {
            let k = start + offset;
            let F = batch.deformation_gradient::<V>(self.at.positions());
            let dF = batch.deformation_gradient::<V>(self.displacement);
            let dP = self
                .group
                .law
                .stress_differential(k, self.at.controls(), &F, &dF);
            let nodal = batch.nodal_gradient(&dP);
            self.sink.add_lanes(k * LANES, &nodal[..=D]);
        }
    }
}

struct ControlPass<'a, 'b, const D: usize, L> {
    group: &'a ElementGroup<D, L>,
    at: Configuration<'a, D>,
    control: usize,
    batches: Range<usize>,
    sink: &'a mut GradientSink<'b, D>,
}
impl<const D: usize, L: Law<D>> PackedKernel for ControlPass<'_, '_, D, L> {
    type Output = ();
    #[inline(always)]
    fn run<V: Pack>(self) {
        for k in self.batches {
            if !self.group.law.has_control(k, self.control) {
                continue;
            }
            let batch = &self.group.batches[k];
            let F = batch.deformation_gradient::<V>(self.at.positions());
            let P = self.group.law.stress_by_control(k, self.control, &F);
            let nodal = batch.nodal_gradient(&P);
            self.sink.add_lanes(k * LANES, &nodal[..=D]);
        }
    }
}

impl<const D: usize, L: Law<D>> Term<D> for ElementGroup<D, L> {
    fn stencils(&self) -> Stencils {
        let mut nodes = Vec::with_capacity((D + 1) * self.elements.len());
        for batch in &self.batches {
            for lane in 0..batch.used {
                nodes.extend((0..=D).map(|a| batch.nodes[a][lane] as usize));
            }
        }
        Stencils {
            nodes,
            vertices: D + 1,
            batch: LANES,
        }
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        dispatch_packed(EnergyPass {
            group: self,
            at,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
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
            HessianProjection::None => dispatch_packed(HessianPass {
                group: self,
                at,
                batches,
                sink,
            }),
            _ => projected_hessian(self, at, projection, batches, sink),
        }
    }
    fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        dispatch_packed(ProductPass {
            group: self,
            at,
            displacement,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn controls(&self) -> usize {
        self.law.controls()
    }
    fn control_gradient(
        &self,
        at: Configuration<D>,
        control: usize,
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        dispatch_packed(ControlPass {
            group: self,
            at,
            control,
            batches: self.batches(&stencils),
            sink,
        });
    }
    fn element(&self, stencil: usize) -> Option<usize> {
        Some(self.elements[stencil] as usize)
    }
}
