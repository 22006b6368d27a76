//! Constant forces on nodes.

use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

/// Constant forces f on nodes: E = −Σ f·x, joules.
#[derive(Clone, Debug, PartialEq)]
pub struct NodalLoads<const D: usize> {
    loads: Vec<(usize, [f64; D])>,
}

impl<const D: usize> NodalLoads<D> {
    /// (node, force in newtons); forces on the same node add up.
    ///
    /// # Errors
    /// When a force is not finite.
    pub fn new(loads: Vec<(usize, [f64; D])>) -> Result<Self, AssemblyError> {
        let bad = |(_, f): &(usize, [f64; D])| f.iter().any(|c| !c.is_finite());
        match loads.iter().position(bad) {
            Some(index) => Err(AssemblyError::NotFinite {
                what: "nodal load",
                index,
            }),
            None => Ok(Self { loads }),
        }
    }

    /// (node, force in newtons), as given or as worked out for faces.
    pub fn into_forces(self) -> Vec<(usize, [f64; D])> {
        self.loads
    }

    fn energy_of(&self, at: Configuration<D>, stencil: usize) -> f64 {
        let (node, force) = &self.loads[stencil];
        let x = &at.positions()[*node];
        -(0..D).map(|k| force[k] * x[k]).sum::<f64>()
    }
}

impl<const D: usize> Term<D> for NodalLoads<D> {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.loads.iter().map(|&(node, _)| [node]))
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            sink.energy(s, self.energy_of(at, s));
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        for s in stencils {
            sink.energy(s, self.energy_of(at, s));
            sink.add(s, 0, self.loads[s].1.map(|f| -f));
        }
    }
    fn hessian(
        &self,
        _: Configuration<D>,
        _: HessianProjection,
        _: Range<usize>,
        _: &mut HessianSink<D>,
    ) {
    }
}
