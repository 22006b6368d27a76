//! A term behind a box is a term: what wraps one is compiled once, not for every material.

use crate::configuration::{Configuration, Positions};
use crate::evaluations::StencilCost;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

// A method that is not handed on would quietly be the default one.
#[warn(clippy::missing_trait_methods)]
impl<const D: usize> Term<D> for Box<dyn Term<D>> {
    fn stencils(&self) -> Stencils {
        (**self).stencils()
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        (**self).energy(at, stencils, sink);
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        (**self).gradient(at, stencils, sink);
    }
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        (**self).hessian(at, projection, stencils, sink);
    }
    fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        (**self).hessian_vector(at, displacement, stencils, sink);
    }
    fn active(&self, at: Positions<D>) -> Option<Vec<usize>> {
        (**self).active(at)
    }
    fn nodes(&self) -> usize {
        (**self).nodes()
    }
    fn controls(&self) -> usize {
        (**self).controls()
    }
    fn control_gradient(
        &self,
        at: Configuration<D>,
        control: usize,
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        (**self).control_gradient(at, control, stencils, sink);
    }
    fn largest_step(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
    ) -> f64 {
        (**self).largest_step(at, displacement, stencils)
    }
    fn renew(&mut self, at: Configuration<D>) -> bool {
        (**self).renew(at)
    }
    fn renew_along(&mut self, at: Configuration<D>, displacement: &[[f64; D]]) -> bool {
        (**self).renew_along(at, displacement)
    }
    fn renew_for_step(&mut self, at: Configuration<D>, displacement: &[[f64; D]]) -> bool {
        (**self).renew_for_step(at, displacement)
    }
    fn one_sided(&self) -> bool {
        (**self).one_sided()
    }
    fn renew_at_equilibrium(&mut self, at: Configuration<D>) -> bool {
        (**self).renew_at_equilibrium(at)
    }
    fn forget(&mut self) {
        (**self).forget();
    }
    fn changes(&self) -> bool {
        (**self).changes()
    }
    fn covered_step(&self, at: Configuration<D>, displacement: &[[f64; D]]) -> f64 {
        (**self).covered_step(at, displacement)
    }
    fn cost(&self) -> StencilCost {
        (**self).cost()
    }
    fn idle_without(&self, stencil: usize) -> Option<usize> {
        (**self).idle_without(stencil)
    }
    fn deepest_contact(&self, positions: &[[f64; D]]) -> Option<f64> {
        (**self).deepest_contact(positions)
    }
    fn element(&self, stencil: usize) -> Option<usize> {
        (**self).element(stencil)
    }
}
