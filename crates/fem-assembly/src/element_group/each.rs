//! The passes that take one element after the other: of a group whose material sees no stretch below a
//! threshold (document 000, 5.5), since every F is decomposed for it, and of projected elements; gradients
//! and Hessians also where a processor has no registers to do more at once. What does not depend on the
//! material is compiled once for each shape, and called.

use super::{Edges, ElementGroup, LANES, add_forces, add_stiffness, store, store_pairs};
use crate::configuration::Configuration;
use crate::element::QuadraturePoint;
use crate::shape::ElementShape;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::stiffness::element_stiffness;
use fem_kinematics::{F64x8, Mat, Tensor4};
use fem_materials::HessianProjection;
use fem_materials::field::MaterialField;
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

/// Compiled once for each material.
#[inline(never)]
fn projected_derivative<const D: usize, M: MaterialField<D>>(
    material: &M,
    local: &M::Local<f64>,
    F: &Mat<f64, D>,
    projection: HessianProjection,
) -> Tensor4<f64, D> {
    material.projected_derivative(local, F, projection)
}

#[inline(never)]
fn deformation_gradient<S: ElementShape<D>, const D: usize>(
    point: &QuadraturePoint<D, S>,
    edges: &Edges<S, D>,
    lane: usize,
) -> Mat<f64, D> {
    point.deformation_gradient::<f64>(edges, lane)
}

#[inline(never)]
fn add_nodal_gradient<S: ElementShape<D>, const D: usize>(
    point: &QuadraturePoint<D, S>,
    P: &Mat<f64, D>,
    lane: usize,
    sums: &mut S::Nodes<[f64; D]>,
) {
    point.add_nodal_gradient(P, lane, sums);
}

#[inline(never)]
fn add_element_stiffness<S: ElementShape<D>, const D: usize>(
    T: &Tensor4<f64, D>,
    point: &QuadraturePoint<D, S>,
    lane: usize,
    stiffness: &mut S::Pairs<Mat<f64, D>>,
) {
    let (gradients, weight) = (point.gradients::<f64>(lane), point.weight.0[lane]);
    element_stiffness::<f64, S, D>(T, &gradients, weight, stiffness);
}

impl<const D: usize, S: ElementShape<D>, M: MaterialField<D>> ElementGroup<D, S, M> {
    /// F as the material sees it.
    fn seen(&self, point: &QuadraturePoint<D, S>, edges: &Edges<S, D>, lane: usize) -> Mat<f64, D> {
        let F = deformation_gradient(point, edges, lane);
        self.threshold.map_or(F, |threshold| threshold.lifted(&F))
    }

    pub(super) fn energy_of_each(
        &self,
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
                    let F = self.seen(point, &edges, lane);
                    let (psi, _) = energy_and_stress(&self.material, &local, &F);
                    energy += psi * point.weight.0[lane];
                }
                sink.energy(k * LANES + lane, energy);
            }
        }
    }

    pub(super) fn gradient_of_each(
        &self,
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
                    let F = self.seen(point, &edges, lane);
                    let (psi, P) = energy_and_stress(&self.material, &local, &F);
                    energy += psi * point.weight.0[lane];
                    add_nodal_gradient(point, &P, lane, &mut nodal);
                }
                sink.energy(k * LANES + lane, energy);
                store::<f64, S, D>(&nodal, lane, &mut forces);
            }
            add_forces::<S, D>(sink, k * LANES, &forces);
        }
    }

    /// Projections decompose F, which in registers for three instruction sets would multiply the size of
    /// the program for a path that few steps take.
    pub(super) fn hessian_of_each(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        batches: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        let mut pairs = S::pairs([[[0.0; LANES]; D]; D]);
        for k in batches.filter(|&k| !self.idle(k, at.controls())) {
            let batch = &self.batches[k];
            let edges = batch.edges(at.positions());
            for lane in 0..batch.used {
                let local = self.local::<f64>(k, lane, at.controls());
                let mut stiffness = S::pairs(Mat::<f64, D>::zeros());
                for point in batch.points.as_ref() {
                    let F = self.seen(point, &edges, lane);
                    let T = projected_derivative(&self.material, &local, &F, projection);
                    add_element_stiffness(&T, point, lane, &mut stiffness);
                }
                store_pairs::<f64, S, D>(&stiffness, lane, &mut pairs);
            }
            add_stiffness::<S, D>(sink, k * LANES, batch.used, &pairs);
        }
    }

    pub(super) fn product_of_each(
        &self,
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
                    let F = self.seen(point, &edges, lane);
                    let dF = deformation_gradient(point, &moved, lane);
                    let exact = HessianProjection::None;
                    let T = projected_derivative(&self.material, &local, &F, exact);
                    add_nodal_gradient(point, &T.apply(&dF), lane, &mut nodal);
                }
                store::<f64, S, D>(&nodal, lane, &mut forces);
            }
            add_forces::<S, D>(sink, k * LANES, &forces);
        }
    }

    pub(super) fn control_of_each(
        &self,
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
                    let F = self.seen(point, &edges, lane);
                    let P = self.material.stress_by_control(&local, &F);
                    add_nodal_gradient(point, &P, lane, &mut nodal);
                }
                store::<f64, S, D>(&nodal, lane, &mut forces);
                sink.evaluated(k * LANES + lane);
            }
            add_forces::<S, D>(sink, k * LANES, &forces);
        }
    }
}
