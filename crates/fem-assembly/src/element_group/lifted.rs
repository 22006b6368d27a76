//! The passes of a group whose material sees no stretch below a threshold (document 000, 5.5): one
//! element at a time, since every F is decomposed for it.

use super::{ElementGroup, LANES, projected_derivative, store};
use crate::configuration::Configuration;
use crate::shape::ElementShape;
use crate::sink::{EnergySink, GradientSink};
use fem_kinematics::{F64x8, Mat};
use fem_materials::HessianProjection;
use fem_materials::field::MaterialField;
use fem_materials::inversion::Threshold;
use std::ops::Range;

/// ψ and P, compiled once for each material.
#[inline(never)]
fn energy_and_stress<const D: usize, M: MaterialField<D>>(
    material: &M,
    local: &M::Local<f64>,
    F: &Mat<f64, D>,
) -> (f64, Mat<f64, D>) {
    material.energy_and_stress(local, F)
}

impl<const D: usize, S: ElementShape<D>, M: MaterialField<D>> ElementGroup<D, S, M> {
    pub(super) fn lifted_energy(
        &self,
        threshold: Threshold,
        at: Configuration<D>,
        batches: Range<usize>,
        sink: &mut EnergySink,
    ) {
        for k in batches.filter(|&k| !self.idle(k, at.controls())) {
            let batch = &self.batches[k];
            let edges = batch.edges(at.positions());
            for lane in 0..batch.used {
                let local = self.local::<f64>(k, lane, at.controls());
                let mut energy = 0.0;
                for point in batch.points.as_ref() {
                    let F = threshold.lifted(&point.deformation_gradient::<f64>(&edges, lane));
                    let (psi, _) = energy_and_stress(&self.material, &local, &F);
                    energy += psi * point.weight.0[lane];
                }
                sink.energy(k * LANES + lane, energy);
            }
        }
    }

    pub(super) fn lifted_gradient(
        &self,
        threshold: Threshold,
        at: Configuration<D>,
        batches: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        for k in batches.filter(|&k| !self.idle(k, at.controls())) {
            let batch = &self.batches[k];
            let edges = batch.edges(at.positions());
            let mut forces = S::nodes([F64x8::default(); D]);
            for lane in 0..batch.used {
                let local = self.local::<f64>(k, lane, at.controls());
                let (mut energy, mut nodal) = (0.0, S::nodes([0.0; D]));
                for point in batch.points.as_ref() {
                    let F = threshold.lifted(&point.deformation_gradient::<f64>(&edges, lane));
                    let (psi, P) = energy_and_stress(&self.material, &local, &F);
                    energy += psi * point.weight.0[lane];
                    point.add_nodal_gradient(&P, lane, &mut nodal);
                }
                sink.energy(k * LANES + lane, energy);
                store::<f64, S, D>(&nodal, lane, &mut forces);
            }
            sink.add_lanes(k * LANES, &forces.as_ref()[..S::NODES]);
        }
    }

    pub(super) fn lifted_product(
        &self,
        threshold: Threshold,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        batches: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        for k in batches.filter(|&k| !self.idle(k, at.controls())) {
            let batch = &self.batches[k];
            let edges = batch.edges(at.positions());
            let moved = batch.edges(displacement);
            let mut forces = S::nodes([F64x8::default(); D]);
            for lane in 0..batch.used {
                let local = self.local::<f64>(k, lane, at.controls());
                let mut nodal = S::nodes([0.0; D]);
                for point in batch.points.as_ref() {
                    let F = threshold.lifted(&point.deformation_gradient::<f64>(&edges, lane));
                    let dF = point.deformation_gradient::<f64>(&moved, lane);
                    let exact = HessianProjection::None;
                    let T = projected_derivative(&self.material, &local, &F, exact);
                    point.add_nodal_gradient(&T.apply(&dF), lane, &mut nodal);
                }
                store::<f64, S, D>(&nodal, lane, &mut forces);
            }
            sink.add_lanes(k * LANES, &forces.as_ref()[..S::NODES]);
        }
    }

    pub(super) fn lifted_control(
        &self,
        threshold: Threshold,
        at: Configuration<D>,
        control: u32,
        batches: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        for k in batches.filter(|&k| self.control[k].contains(&control)) {
            let batch = &self.batches[k];
            let edges = batch.edges(at.positions());
            let mut forces = S::nodes([F64x8::default(); D]);
            let listens = |&lane: &usize| self.control[k][lane] == control;
            for lane in (0..batch.used).filter(listens) {
                let local = self.local::<f64>(k, lane, at.controls());
                let mut nodal = S::nodes([0.0; D]);
                for point in batch.points.as_ref() {
                    let F = threshold.lifted(&point.deformation_gradient::<f64>(&edges, lane));
                    let P = self.material.stress_by_control(&local, &F);
                    point.add_nodal_gradient(&P, lane, &mut nodal);
                }
                store::<f64, S, D>(&nodal, lane, &mut forces);
                sink.evaluated(k * LANES + lane);
            }
            sink.add_lanes(k * LANES, &forces.as_ref()[..S::NODES]);
        }
    }
}
