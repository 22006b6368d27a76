//! Tractions and dead pressures on faces: nodal forces that do the same work.

use super::nodal_loads::NodalLoads;
use crate::error::AssemblyError;
use crate::faces::{area_vector, check_faces};
use crate::mesh::QuadraticMesh;
use std::collections::BTreeMap;

impl<const D: usize> NodalLoads<D> {
    /// A dead traction t (pascals; N/m in 2D) on flat faces, D nodes each: f_a = ∫ N_a t dA at rest,
    /// 1/D of the area times t at each node. It keeps its direction and its sum when the body moves.
    ///
    /// # Errors
    /// When a face names a node that does not exist or one twice, or a number is not finite.
    pub fn traction(
        rest: &[[f64; D]],
        faces: &[[u32; D]],
        traction: [f64; D],
    ) -> Result<Self, AssemblyError> {
        on_faces(rest, faces, |area| {
            let size = area.iter().map(|c| c * c).sum::<f64>().sqrt();
            traction.map(|t| size * t)
        })
    }

    /// A dead pressure p (pascals; N/m in 2D): the traction −p n along the normals at rest, outward for
    /// faces of [`SimplexMesh::boundary`](crate::mesh::SimplexMesh::boundary). For one that follows the
    /// surface see [`Cavity`](crate::Cavity).
    ///
    /// # Errors
    /// As [`NodalLoads::traction`].
    pub fn pressure(
        rest: &[[f64; D]],
        faces: &[[u32; D]],
        pressure: f64,
    ) -> Result<Self, AssemblyError> {
        on_faces(rest, faces, |area| area.map(|a| -pressure * a))
    }

    /// [`NodalLoads::traction`] on the faces of quadratic elements, named by their D corners. ∫ N dA is
    /// 0 at the corners of a triangle and A/3 at the middles of its edges; ℓ/6 at the ends of an edge
    /// and 2ℓ/3 in its middle.
    ///
    /// # Errors
    /// As [`NodalLoads::traction`], and when a face is none of the mesh's.
    pub fn quadratic_traction(
        mesh: &QuadraticMesh<D>,
        faces: &[[u32; D]],
        traction: [f64; D],
    ) -> Result<Self, AssemblyError> {
        on_quadratic_faces(mesh, faces, |area| {
            let size = area.iter().map(|c| c * c).sum::<f64>().sqrt();
            traction.map(|t| size * t)
        })
    }

    /// [`NodalLoads::pressure`] on the faces of quadratic elements, named by their D corners.
    ///
    /// # Errors
    /// As [`NodalLoads::quadratic_traction`].
    pub fn quadratic_pressure(
        mesh: &QuadraticMesh<D>,
        faces: &[[u32; D]],
        pressure: f64,
    ) -> Result<Self, AssemblyError> {
        on_quadratic_faces(mesh, faces, |area| area.map(|a| -pressure * a))
    }
}

/// Each node carries 1/D of what its faces do.
fn on_faces<const D: usize>(
    rest: &[[f64; D]],
    faces: &[[u32; D]],
    force: impl Fn([f64; D]) -> [f64; D],
) -> Result<NodalLoads<D>, AssemblyError> {
    check_faces(faces, rest.len())?;
    let mut loads = BTreeMap::new();
    for face in faces {
        let whole = force(area_vector(face.map(|n| rest[n as usize])));
        for &node in face {
            add(&mut loads, node, whole.map(|f| f / D as f64));
        }
    }
    NodalLoads::new(loads.into_iter().collect())
}

fn on_quadratic_faces<const D: usize>(
    mesh: &QuadraticMesh<D>,
    faces: &[[u32; D]],
    force: impl Fn([f64; D]) -> [f64; D],
) -> Result<NodalLoads<D>, AssemblyError> {
    check_faces(faces, mesh.num_nodes())?;
    let middles = middles(mesh);
    let (corner, middle) = if D == 2 {
        (1.0 / 6.0, 2.0 / 3.0)
    } else {
        (0.0, 1.0 / 3.0)
    };
    let mut loads = BTreeMap::new();
    for (face, corners) in faces.iter().enumerate() {
        let whole = force(area_vector(corners.map(|n| mesh.node(n))));
        // One edge in 2D.
        for k in 0..if D == 2 { 1 } else { D } {
            let (a, b) = (corners[k], corners[(k + 1) % D]);
            let node = middles.get(&(a.min(b), a.max(b)));
            let node = *node.ok_or(AssemblyError::NoSuchEdge {
                nodes: [a, b],
                face,
            })?;
            add(&mut loads, node, whole.map(|f| middle * f));
        }
        if corner != 0.0 {
            for &node in corners {
                add(&mut loads, node, whole.map(|f| corner * f));
            }
        }
    }
    NodalLoads::new(loads.into_iter().collect())
}

/// The node in the middle of each edge.
fn middles<const D: usize>(mesh: &QuadraticMesh<D>) -> BTreeMap<(u32, u32), u32> {
    let edges = QuadraticMesh::<D>::edges_of_an_element();
    let of_element = |element: &[u32]| {
        let middle = |(k, [a, b]): (usize, &[usize; 2])| {
            let (a, b) = (element[*a], element[*b]);
            ((a.min(b), a.max(b)), element[D + 1 + k])
        };
        edges.iter().enumerate().map(middle).collect::<Vec<_>>()
    };
    mesh.elements().flat_map(of_element).collect()
}

fn add<const D: usize>(loads: &mut BTreeMap<usize, [f64; D]>, node: u32, force: [f64; D]) {
    let sum = loads.entry(node as usize).or_insert([0.0; D]);
    (0..D).for_each(|i| sum[i] += force[i]);
}
