//! Weight.

use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::mesh::{QuadraticMesh, SimplexMesh};
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_materials::HessianProjection;
use std::ops::Range;

/// Weight of a body of uniform density ρ: E = −Σₑ ρ Vₑ g·x̄ₑ over the elements' centers x̄ₑ, joules.
/// Rest volumes make it −Σₙ mₙ g·xₙ with the mass mₙ of a quarter (in 2D a third) of each element
/// around node n; quadratic elements have masses of their own.
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
        let shares = vec![1.0 / (D + 1) as f64; D + 1];
        Self::of(mesh, mesh.elements(), &shares, density, acceleration)
    }

    /// The same for quadratic elements: ∫ N dV of a corner is 0 in triangles and −V/20 in
    /// tetrahedra, of a node on an edge V/3 and V/5.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn quadratic(
        mesh: &QuadraticMesh<D>,
        density: f64,
        acceleration: [f64; D],
    ) -> Result<Self, AssemblyError> {
        let (corner, edge) = if D == 2 {
            (0.0, 1.0 / 3.0)
        } else {
            (-1.0 / 20.0, 1.0 / 5.0)
        };
        let mut shares = vec![edge; QuadraticMesh::<D>::NODES_PER_ELEMENT];
        shares[..=D].fill(corner);
        Self::of(
            mesh.corners(),
            mesh.elements(),
            &shares,
            density,
            acceleration,
        )
    }

    /// Each node of an element carries a share of its mass.
    fn of<'a>(
        corners: &SimplexMesh<D>,
        elements: impl Iterator<Item = &'a [u32]>,
        shares: &[f64],
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
        let mut masses: Vec<(usize, f64)> = (0..corners.num_nodes()).map(|n| (n, 0.0)).collect();
        for (element, nodes) in elements.enumerate() {
            let mass = density * corners.volume(element);
            for (&node, share) in nodes.iter().zip(shares) {
                masses[node as usize].1 += share * mass;
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
