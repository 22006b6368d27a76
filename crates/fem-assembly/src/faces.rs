//! Surfaces as lists of faces: areas, edges, what is open and what closes it.

use crate::error::AssemblyError;
use crate::mesh::SimplexMesh;
use std::collections::BTreeMap;

/// ∫ n dA of a flat face: half the cross product of two edges in 3D, the edge turned by −90° in 2D,
/// so that the faces of [`SimplexMesh::boundary`] have outward ones.
pub(crate) fn area_vector<const D: usize>(points: [[f64; D]; D]) -> [f64; D] {
    let edge = |k: usize, i: usize| points[k][i] - points[0][i];
    std::array::from_fn(|i| match D {
        2 => [edge(1, 1), -edge(1, 0)][i],
        _ => {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            0.5 * (edge(1, j) * edge(2, k) - edge(1, k) * edge(2, j))
        }
    })
}

/// The area of a flat face, m² (its length in 2D, m).
pub(crate) fn area<const D: usize>(points: [[f64; D]; D]) -> f64 {
    let vector = area_vector(points);
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// A face less one of its nodes, which of its two orientations it has, and the face.
struct Ridge {
    /// Ascending; one node in 2D.
    nodes: Vec<u32>,
    forward: bool,
    face: usize,
}

/// The ridges of all faces, equal ones together.
fn ridges<const D: usize>(faces: &[[u32; D]]) -> BTreeMap<Vec<u32>, Vec<Ridge>> {
    let mut all: BTreeMap<Vec<u32>, Vec<Ridge>> = BTreeMap::new();
    for (face, nodes) in faces.iter().enumerate() {
        for k in 0..D {
            let (ridge, forward) = match D {
                2 => (vec![nodes[k]], k == 1),
                _ => {
                    let (a, b) = (nodes[k], nodes[(k + 1) % D]);
                    (vec![a.min(b), a.max(b)], a < b)
                }
            };
            let nodes = ridge.clone();
            let ridge = Ridge {
                nodes: ridge,
                forward,
                face,
            };
            all.entry(nodes).or_default().push(ridge);
        }
    }
    all
}

fn surplus(around: &[Ridge]) -> isize {
    around.iter().map(|r| if r.forward { 1 } else { -1 }).sum()
}

/// Names the first edge (node in 2D) at which the surface is open or changes its orientation.
pub(crate) fn check_closed<const D: usize>(faces: &[[u32; D]]) -> Result<(), AssemblyError> {
    for (nodes, around) in ridges(faces) {
        if surplus(&around) != 0 {
            let faces = around.iter().map(|r| r.face).collect();
            return Err(match around.len() {
                1 => AssemblyError::OpenSurface { nodes, faces },
                _ => AssemblyError::TwistedSurface { nodes, faces },
            });
        }
    }
    Ok(())
}

/// Each face names D different nodes that exist.
pub(crate) fn check_faces<const D: usize>(
    faces: &[[u32; D]],
    count: usize,
) -> Result<(), AssemblyError> {
    for (face, nodes) in faces.iter().enumerate() {
        for (k, &node) in nodes.iter().enumerate() {
            if node as usize >= count {
                let node = node as usize;
                return Err(AssemblyError::NoSuchNode { node, count });
            }
            if nodes[..k].contains(&node) {
                return Err(AssemblyError::DegenerateFace { face, node });
            }
        }
    }
    Ok(())
}

/// Triangles that close the rims of an oriented surface, for each rim a fan around one of its nodes:
/// the first of those that `prescribed` accepts, or else the first of all.
///
/// # Errors
/// When two faces run the same way along an edge.
pub(crate) fn caps(
    faces: &[[u32; 3]],
    prescribed: impl Fn(u32) -> bool,
) -> Result<Vec<[u32; 3]>, AssemblyError> {
    let mut rim: Vec<[u32; 2]> = Vec::new();
    for (nodes, around) in ridges(faces) {
        let surplus = surplus(&around);
        if surplus.abs() > 1 || (surplus != 0 && around.len() > 1) {
            let faces = around.iter().map(|r| r.face).collect();
            return Err(AssemblyError::TwistedSurface { nodes, faces });
        }
        let [low, high] = [around[0].nodes[0], around[0].nodes[1]];
        match surplus {
            0 => {}
            1 => rim.push([high, low]),
            _ => rim.push([low, high]),
        }
    }
    let apex = apexes(&rim, prescribed);
    let fan = |edge: &[u32; 2]| [edge[0], edge[1], apex[&edge[0]]];
    let triangles = rim.iter().map(fan);
    Ok(triangles
        .filter(|[a, b, apex]| a != apex && b != apex)
        .collect())
}

/// For each node of a rim the node that its whole rim is fanned around.
fn apexes(rim: &[[u32; 2]], prescribed: impl Fn(u32) -> bool) -> BTreeMap<u32, u32> {
    let better = |a: u32, b: u32| {
        if (!prescribed(a), a) < (!prescribed(b), b) {
            a
        } else {
            b
        }
    };
    let mut apex: BTreeMap<u32, u32> = rim.iter().flatten().map(|&n| (n, n)).collect();
    loop {
        let mut changed = false;
        for [a, b] in rim {
            let best = better(apex[a], apex[b]);
            for node in [a, b] {
                if apex.insert(*node, best) != Some(best) {
                    changed = true;
                }
            }
        }
        if !changed {
            return apex;
        }
    }
}

impl<const D: usize> SimplexMesh<D> {
    /// The faces of the boundary all of whose nodes are accepted, outward.
    pub fn boundary_faces(&self, mut accepts: impl FnMut(u32) -> bool) -> Vec<[u32; D]> {
        let mut faces = self.boundary().faces;
        faces.retain(|face| face.iter().all(|&n| accepts(n)));
        faces
    }
}

/// The same surface seen from the other side.
pub(crate) fn turned<const D: usize>(mut faces: Vec<[u32; D]>) -> Vec<[u32; D]> {
    faces.iter_mut().for_each(|face| face.swap(0, 1));
    faces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::kuhn_grid;

    #[test]
    fn the_boundary_of_a_mesh_is_closed_and_its_areas_sum_to_nothing() {
        let mesh = kuhn_grid(2, 3, 2, [1.0, 2.0, 0.5]).unwrap();
        let faces = mesh.boundary().faces;
        assert_eq!(check_closed(&faces), Ok(()));
        let mut sum = [0.0; 3];
        let mut whole = 0.0;
        for face in &faces {
            let corners = face.map(|n| mesh.node(n));
            let vector = area_vector(corners);
            whole += area(corners);
            (0..3).for_each(|i| sum[i] += vector[i]);
        }
        assert!(sum.iter().all(|s| s.abs() < 1e-14), "{sum:?}");
        assert!((whole - 2.0 * (2.0 + 0.5 + 1.0)).abs() < 1e-13, "{whole}");
    }

    #[test]
    fn a_hole_and_a_turned_face_are_named_by_their_edge() {
        let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).unwrap();
        let whole = mesh.boundary().faces;
        let mut open = whole.clone();
        let lost = open.pop().unwrap();
        let Err(AssemblyError::OpenSurface { nodes, .. }) = check_closed(&open) else {
            panic!("open");
        };
        assert!(nodes.iter().all(|n| lost.contains(n)));
        let mut twisted = whole.clone();
        twisted[4].swap(0, 1);
        let Err(AssemblyError::TwistedSurface { nodes, faces }) = check_closed(&twisted) else {
            panic!("twisted");
        };
        assert!(faces.contains(&4) && nodes.iter().all(|n| twisted[4].contains(n)));
        assert!(matches!(
            caps(&twisted, |_| false),
            Err(AssemblyError::TwistedSurface { .. })
        ));
    }

    #[test]
    fn caps_close_every_rim_around_a_held_node() {
        let mesh = kuhn_grid(3, 3, 3, [1.0; 3]).unwrap();
        let open = |n: u32| mesh.node(n)[2] > 0.0 && mesh.node(n)[2] < 1.0;
        let side = |n: u32| !open(n) || mesh.node(n)[0] * (1.0 - mesh.node(n)[0]) == 0.0;
        let mut faces = mesh.boundary_faces(side);
        faces.retain(|f| !f.iter().all(|&n| mesh.node(n)[2] == 0.0));
        faces.retain(|f| !f.iter().all(|&n| mesh.node(n)[2] == 1.0));
        assert!(check_closed(&faces).is_err());
        let prescribed = |n: u32| n == 12;
        let caps = caps(&faces, prescribed).unwrap();
        assert!(caps.iter().any(|cap| cap[2] == 12) || !faces.iter().flatten().any(|&n| n == 12));
        let whole = [faces, caps].concat();
        assert_eq!(check_closed(&whole), Ok(()));
    }
}
