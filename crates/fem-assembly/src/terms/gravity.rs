//! Weight.

use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::mesh::SimplexMesh;
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::Mat;
use fem_materials::HessianProjection;
use std::ops::Range;

/// Weight of a body of uniform density ρ: E = −Σₑ ρ Vₑ g·x̄ₑ over the elements' centers x̄ₑ, joules.
/// Rest volumes make it −Σₙ mₙ g·xₙ with the mass mₙ of a quarter (in 2D a third) of each element
/// around node n.
#[derive(Clone, Debug, PartialEq)]
pub struct Gravity<const D: usize> {
    acceleration: [f64; D],
    masses: Vec<(usize, f64)>,
}

impl<const D: usize> Gravity<D> {
    /// `density` in kg/m³ (kg/m² in 2D), `acceleration` g in m/s².
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn new(
        mesh: &SimplexMesh<D>,
        density: f64,
        acceleration: [f64; D],
    ) -> Result<Self, AssemblyError> {
        let numbers = std::iter::once(density).chain(acceleration);
        for (index, number) in numbers.enumerate() {
            if !number.is_finite() {
                let what = "number of gravity (density, then acceleration)";
                return Err(AssemblyError::NotFinite { what, index });
            }
        }
        let rest = mesh.nodes();
        let mut masses: Vec<(usize, f64)> = (0..rest.len()).map(|n| (n, 0.0)).collect();
        let factorial = if D == 2 { 2.0 } else { 6.0 };
        for nodes in mesh.elements() {
            let corner = |a: usize| rest[nodes[a] as usize];
            let shape = Mat::<f64, D>::from_fn(|i, j| corner(j + 1)[i] - corner(0)[i]);
            let share = density * shape.determinant().abs() / factorial / (D + 1) as f64;
            for &node in nodes {
                masses[node as usize].1 += share;
            }
        }
        masses.retain(|&(_, mass)| mass != 0.0);
        Ok(Self {
            acceleration,
            masses,
        })
    }

    fn energy_of(&self, at: Configuration<D>, stencil: usize) -> f64 {
        let (node, mass) = self.masses[stencil];
        let x = &at.positions()[node];
        -mass * (0..D).map(|k| self.acceleration[k] * x[k]).sum::<f64>()
    }
}

impl<const D: usize> Term<D> for Gravity<D> {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.masses.iter().map(|&(node, _)| [node]))
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            sink.energy(s, self.energy_of(at, s));
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        for s in stencils {
            sink.energy(s, self.energy_of(at, s));
            sink.add(s, 0, self.acceleration.map(|g| -self.masses[s].1 * g));
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
