//! A term times a control.

use crate::configuration::{Configuration, Positions};
use crate::error::AssemblyError;
use crate::evaluations::StencilCost;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

/// A term times a control c: E = c · Eᵗ, for loads that grow and pressures; or E = (1 + c) · Eᵗ, c being
/// a relative change of a stiffness or a strength.
///
/// The term may read other controls (a muscle its activations): E is then affine in each control
/// while the others stand still, and a column ∂²E/∂x∂c depends on the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaled<T> {
    term: T,
    control: usize,
    /// The factor where the control is 0.
    neutral: f64,
}

impl<T> Scaled<T> {
    /// Multiplies `term` by the control with this index: E = c · Eᵗ.
    ///
    /// # Errors
    /// When the term may read this control itself: the product would not be affine in it.
    pub fn new<const D: usize>(term: T, control: usize) -> Result<Self, AssemblyError>
    where
        T: Term<D>,
    {
        Self::around(term, control, 0.0)
    }

    /// Changes `term` by the control's share of it: E = (1 + c) · Eᵗ, c = −1 switching it off.
    ///
    /// # Errors
    /// As [`Scaled::new`].
    pub fn changed_by<const D: usize>(term: T, control: usize) -> Result<Self, AssemblyError>
    where
        T: Term<D>,
    {
        Self::around(term, control, 1.0)
    }

    fn around<const D: usize>(term: T, control: usize, neutral: f64) -> Result<Self, AssemblyError>
    where
        T: Term<D>,
    {
        if let Some(read) = term.controls().checked_sub(1)
            && control <= read
        {
            return Err(AssemblyError::ScaledTwice { read, control });
        }
        Ok(Self {
            term,
            control,
            neutral,
        })
    }

    fn factor<const D: usize>(&self, at: Configuration<D>) -> f64 {
        self.neutral + at.controls()[self.control]
    }
}

impl<const D: usize, T: Term<D>> Term<D> for Scaled<T> {
    fn stencils(&self) -> Stencils {
        self.term.stencils()
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        let factor = self.factor(at);
        self.term.energy(at, stencils, &mut sink.scaled(factor));
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        let factor = self.factor(at);
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
        let factor = self.factor(at);
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
        let factor = self.factor(at);
        let mut sink = sink.scaled(factor);
        self.term
            .hessian_vector(at, displacement, stencils, &mut sink);
    }
    fn active(&self, at: Positions<D>) -> Option<Vec<usize>> {
        self.term.active(at)
    }
    fn nodes(&self) -> usize {
        self.term.nodes()
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
        } else if control < self.term.controls() {
            let mut sink = sink.scaled(self.factor(at));
            self.term.control_gradient(at, control, stencils, &mut sink);
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
    fn forget(&mut self) {
        self.term.forget();
    }
    fn renew_at_equilibrium(&mut self, at: Configuration<D>) -> bool {
        self.term.renew_at_equilibrium(at)
    }
    fn renew(&mut self, at: Configuration<D>) -> bool {
        self.term.renew(at)
    }
    fn renew_along(&mut self, at: Configuration<D>, displacement: &[[f64; D]]) -> bool {
        self.term.renew_along(at, displacement)
    }
    fn renew_for_step(&mut self, at: Configuration<D>, displacement: &[[f64; D]]) -> bool {
        self.term.renew_for_step(at, displacement)
    }
    fn one_sided(&self) -> bool {
        self.term.one_sided()
    }
    fn covered_step(&self, at: Configuration<D>, displacement: &[[f64; D]]) -> f64 {
        self.term.covered_step(at, displacement)
    }
    fn cost(&self) -> StencilCost {
        self.term.cost()
    }
    fn deepest_contact(&self, positions: &[[f64; D]]) -> Option<f64> {
        self.term.deepest_contact(positions)
    }
    fn idle_without(&self, stencil: usize) -> Option<usize> {
        self.term.idle_without(stencil)
    }
    fn element(&self, stencil: usize) -> Option<usize> {
        self.term.element(stencil)
    }
}
