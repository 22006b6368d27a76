//! A term times a control.

use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

/// A term times a control c: E = c · Eᵗ. Loads that grow, weights that are switched on.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaled<T> {
    term: T,
    control: usize,
}

impl<T> Scaled<T> {
    /// Multiplies `term` by the control with this index (unitless).
    ///
    /// # Errors
    /// When the term depends on controls itself: the product would not be affine.
    pub fn new<const D: usize>(term: T, control: usize) -> Result<Self, AssemblyError>
    where
        T: Term<D>,
    {
        if term.controls() > 0 {
            return Err(AssemblyError::ScaledTwice);
        }
        Ok(Self { term, control })
    }
}

impl<const D: usize, T: Term<D>> Term<D> for Scaled<T> {
    fn stencils(&self) -> Stencils {
        self.term.stencils()
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        let factor = at.controls()[self.control];
        self.term.energy(at, stencils, &mut sink.scaled(factor));
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        let factor = at.controls()[self.control];
        self.term.gradient(at, stencils, &mut sink.scaled(factor));
    }
    /// For c < 0 the projections of cH follow from those of H: |cH| = |c| |H|, and what is positive
    /// of cH is (|cH| + cH)/2.
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        let factor = at.controls()[self.control];
        let mut add = |projection, factor| {
            let mut sink = sink.scaled(factor);
            self.term
                .hessian(at, projection, stencils.clone(), &mut sink);
        };
        match projection {
            HessianProjection::None => add(projection, factor),
            HessianProjection::Absolute => add(projection, factor.abs()),
            HessianProjection::Clamp if factor >= 0.0 => add(projection, factor),
            HessianProjection::Clamp => {
                add(HessianProjection::Absolute, -0.5 * factor);
                add(HessianProjection::None, 0.5 * factor);
            }
        }
    }
    fn hessian_vector(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        let factor = at.controls()[self.control];
        let mut sink = sink.scaled(factor);
        self.term
            .hessian_vector(at, displacement, stencils, &mut sink);
    }
    fn controls(&self) -> usize {
        self.control.saturating_add(1)
    }
    fn control_gradient(
        &self,
        at: Configuration<D>,
        control: usize,
        stencils: Range<usize>,
        sink: &mut GradientSink<D>,
    ) {
        if control == self.control {
            self.term.gradient(at, stencils, sink);
        }
    }
    fn largest_step(
        &self,
        at: Configuration<D>,
        displacement: &[[f64; D]],
        stencils: Range<usize>,
    ) -> f64 {
        self.term.largest_step(at, displacement, stencils)
    }
    fn changes(&self) -> bool {
        self.term.changes()
    }
    fn renew(&mut self, at: Configuration<D>) -> bool {
        self.term.renew(at)
    }
    fn covered_step(&self, at: Configuration<D>, displacement: &[[f64; D]]) -> f64 {
        self.term.covered_step(at, displacement)
    }
    fn element(&self, stencil: usize) -> Option<usize> {
        self.term.element(stencil)
    }
}
