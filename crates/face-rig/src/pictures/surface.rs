//! The boundary of a tet mesh as a triangle surface.

use super::PictureError;

/// Boundary triangles of a tet mesh, outward oriented, with their own compact vertex numbering.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundarySurface {
    /// Triangles over surface vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The tet each triangle belongs to.
    pub source_tet: Vec<u32>,
    /// Mesh node of each surface vertex, ascending.
    pub source_node: Vec<u32>,
}

impl BoundarySurface {
    /// Values of the surface vertices, picked from a per-node array of the tet mesh.
    ///
    /// # Panics
    /// If `per_node` is shorter than the mesh's node count.
    pub fn gather<T: Copy>(&self, per_node: &[T]) -> Vec<T> {
        self.source_node
            .iter()
            .map(|&n| per_node[n as usize])
            .collect()
    }
}

/// Faces that belong to exactly one tet, in the order (tet, face).
///
/// Positively oriented tets, `(x1-x0)·((x2-x0)×(x3-x0)) > 0`, give outward triangles.
///
/// # Errors
/// [`PictureError::IndexOutOfRange`] for a tet that names a node `>= node_count`.
pub fn boundary_surface(
    node_count: usize,
    tets: &[[u32; 4]],
) -> Result<BoundarySurface, PictureError> {
    // Face opposite to vertex k, seen from outside.
    const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
    let mut faces: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * tets.len());
    for (t, tet) in tets.iter().enumerate() {
        if let Some(&point) = tet.iter().find(|&&n| n as usize >= node_count) {
            return Err(PictureError::IndexOutOfRange {
                what: "tet",
                element: t,
                point: point as usize,
                count: node_count,
            });
        }
        for (k, f) in FACES.iter().enumerate() {
            let mut key = f.map(|i| tet[i]);
            key.sort_unstable();
            faces.push((key, (4 * t + k) as u32));
        }
    }
    faces.sort_unstable();
    let mut single: Vec<u32> = Vec::new();
    let mut at = 0;
    while at < faces.len() {
        let mut end = at + 1;
        while end < faces.len() && faces[end].0 == faces[at].0 {
            end += 1;
        }
        if end == at + 1 {
            single.push(faces[at].1);
        }
        at = end;
    }
    single.sort_unstable();
    let corner_nodes: Vec<[u32; 3]> = single
        .iter()
        .map(|&id| FACES[id as usize % 4].map(|i| tets[id as usize / 4][i]))
        .collect();
    let mut source_node: Vec<u32> = corner_nodes.iter().flatten().copied().collect();
    source_node.sort_unstable();
    source_node.dedup();
    let mut compact = vec![u32::MAX; node_count];
    for (i, &n) in source_node.iter().enumerate() {
        compact[n as usize] = i as u32;
    }
    Ok(BoundarySurface {
        triangles: corner_nodes
            .iter()
            .map(|t| t.map(|n| compact[n as usize]))
            .collect(),
        source_tet: single.iter().map(|id| id / 4).collect(),
        source_node,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_tets_show_six_outward_faces() {
        let points: [[f64; 3]; 5] = [
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [1., 1., 1.],
        ];
        let tets = [[0, 1, 2, 3], [1, 2, 3, 4]];
        let surface = boundary_surface(5, &tets).unwrap();
        assert_eq!(surface.triangles.len(), 6);
        assert_eq!(surface.source_node, [0, 1, 2, 3, 4]);
        // Divergence theorem: outward triangles enclose the sum of the volumes, 1/6 + 1/3.
        let volume: f64 = surface
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i as usize]);
                (a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]))
                    / 6.0
            })
            .sum();
        assert!((volume - 0.5).abs() < 1e-15, "{volume}");
        assert!(boundary_surface(4, &tets).is_err());
    }
}
