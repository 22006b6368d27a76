//! Pressure in a cavity: a force that follows the surface and still has an energy.

use crate::configuration::Configuration;
use crate::error::AssemblyError;
use crate::faces::{caps, check_closed};
use crate::sink::{EnergySink, GradientSink, HessianSink};
use crate::term::{Stencils, Term};
use fem_kinematics::{Mat, Tensor4};
use fem_materials::HessianProjection;
use std::ops::Range;

/// Gas of pressure p in a cavity: E = −p V(x), joules, V being the volume (area in 2D) that the faces
/// enclose at the current positions, V = Σ det[x₁ − o, …, x_D − o]/D! over the faces.
///
/// The force −∂E/∂x = p ∂V/∂x is p times a third of the current area vector of each face at each of
/// its nodes, which follows the surface; V is cubic, its Hessian symmetric. E is affine in p:
/// [`Scaled`](crate::Scaled) of a cavity of 1 Pa makes the pressure a control, in pascals.
///
/// Faces are counter-clockwise seen from outside the cavity (in 2D the cavity is on the left): those
/// of [`SimplexMesh::boundary`](crate::mesh::SimplexMesh::boundary) for a pressure inside the body,
/// and [`Cavity::turned`] around for one that presses on it.
///
/// A follower pressure on an *open* patch has no energy: its Hessian is symmetric only where the
/// patch's rim does not move. What closes the patch decides what is symmetric; see
/// [`Cavity::capped`] and [`Cavity::about`].
#[derive(Clone, Debug, PartialEq)]
pub struct Cavity<const D: usize> {
    faces: Vec<[u32; D]>,
    apex: [f64; D],
    pressure: f64,
}

impl<const D: usize> Cavity<D> {
    /// Faces that close a cavity, and the pressure in it, pascals (N/m in 2D).
    ///
    /// # Errors
    /// When the pressure is not finite, or the surface is open or changes its orientation; the edge is
    /// named.
    pub fn closed(faces: Vec<[u32; D]>, pressure: f64) -> Result<Self, AssemblyError> {
        check_closed(&faces)?;
        Self::about(faces, [0.0; D], pressure)
    }

    /// Faces that need not close anything: a mantle from their rim to the fixed point `apex` (meters)
    /// does. The pressure pushes on the mantle too and the rim carries a part of that, so this is the
    /// follower pressure on the faces alone where the rim is prescribed, and at every other node.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn about(
        faces: Vec<[u32; D]>,
        apex: [f64; D],
        pressure: f64,
    ) -> Result<Self, AssemblyError> {
        let numbers = std::iter::once(pressure).chain(apex);
        for (index, number) in numbers.enumerate() {
            if !number.is_finite() {
                let what = "number of a cavity (pressure, then apex)";
                return Err(AssemblyError::NotFinite { what, index });
            }
        }
        Ok(Self {
            faces,
            apex,
            pressure,
        })
    }

    /// A cavity about whose sides the pressure pushes the other way: faces of the body's boundary, seen
    /// from outside the body, become those of what the body surrounds.
    #[must_use]
    pub fn turned(faces: Vec<[u32; D]>) -> Vec<[u32; D]> {
        crate::faces::turned(faces)
    }

    /// V at these positions, m³ (m² in 2D).
    ///
    /// # Errors
    /// When a face names a node that has no position.
    pub fn volume(&self, positions: &[[f64; D]]) -> Result<f64, AssemblyError> {
        let count = positions.len();
        let mut named = self.faces.as_flattened().iter().map(|&n| n as usize);
        if let Some(node) = named.find(|&n| n >= count) {
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        let of = |s| self.edges(positions, s).determinant() / Self::FACTORIAL;
        Ok((0..self.faces.len()).map(of).sum())
    }

    /// The faces, with those that close it.
    pub fn faces(&self) -> &[[u32; D]] {
        &self.faces
    }

    const FACTORIAL: f64 = if D == 2 { 2.0 } else { 6.0 };

    /// Its columns are x − o of the face's nodes.
    fn edges(&self, positions: &[[f64; D]], stencil: usize) -> Mat<f64, D> {
        let nodes = &self.faces[stencil];
        Mat::from_fn(|i, a| positions[nodes[a] as usize][i] - self.apex[i])
    }

    /// ∂E/∂det.
    fn slope(&self) -> f64 {
        -self.pressure / Self::FACTORIAL
    }
}

impl Cavity<3> {
    /// Faces with holes, each of which is closed by a fan of triangles through the nodes of its own rim:
    /// a closed surface, on which no force or torque is left over. The fan carries its pressure to the
    /// rim; it lies around the first node of the rim that `prescribed` accepts (say, one on bone), or else
    /// around the first one.
    ///
    /// # Errors
    /// As [`Cavity::closed`], for faces that change their orientation.
    pub fn capped(
        mut faces: Vec<[u32; 3]>,
        pressure: f64,
        prescribed: impl Fn(u32) -> bool,
    ) -> Result<Self, AssemblyError> {
        let caps = caps(&faces, prescribed)?;
        faces.extend(caps);
        Self::closed(faces, pressure)
    }
}

/// Each face is a stencil.
impl<const D: usize> Term<D> for Cavity<D> {
    fn stencils(&self) -> Stencils {
        Stencils::new(self.faces.iter().map(|face| face.map(|n| n as usize)))
    }
    fn energy(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut EnergySink) {
        for s in stencils {
            let det = self.edges(at.positions(), s).determinant();
            sink.energy(s, self.slope() * det);
        }
    }
    fn gradient(&self, at: Configuration<D>, stencils: Range<usize>, sink: &mut GradientSink<D>) {
        for s in stencils {
            let edges = self.edges(at.positions(), s);
            sink.energy(s, self.slope() * edges.determinant());
            let cofactor = edges.cofactor().scale(self.slope());
            for a in 0..D {
                sink.add(s, a, cofactor.column(a));
            }
        }
    }
    fn hessian(
        &self,
        at: Configuration<D>,
        projection: HessianProjection,
        stencils: Range<usize>,
        sink: &mut HessianSink<D>,
    ) {
        for s in stencils {
            let edges = self.edges(at.positions(), s);
            let differential = |d: &Mat<f64, D>| edges.cofactor_differential(d).scale(self.slope());
            let tensor = projection.apply(&Tensor4::from_linear_map(differential));
            for a in 0..D {
                for b in 0..=a {
                    sink.add(s, a, b, tensor.0[a][b].0);
                }
            }
        }
    }
}
