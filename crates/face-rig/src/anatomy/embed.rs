//! Points that ride on the mesh.

use fem_assembly::mesh::SimplexMesh;

/// A point fixed to a tetrahedron by barycentric weights: x = Σ wₖ x_(node k). Weights sum to 1; a
/// point a little outside the mesh has a negative one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedPoint {
    /// Number of the point in its own table (a skin vertex, say).
    pub id: u32,
    /// The tetrahedron.
    pub tet: u32,
    /// Weights of its four nodes.
    pub weights: [f64; 4],
}

impl EmbeddedPoint {
    /// Where the point is when the mesh's nodes are at `x`, meters. `x` has one entry per node.
    pub fn position(&self, mesh: &SimplexMesh<3>, x: &[[f64; 3]]) -> [f64; 3] {
        let nodes = mesh.tet(self.tet as usize);
        std::array::from_fn(|i| {
            (0..4)
                .map(|k| self.weights[k] * x[nodes[k] as usize][i])
                .sum()
        })
    }
    /// Where the point is at rest, meters.
    pub fn rest_position(&self, mesh: &SimplexMesh<3>) -> [f64; 3] {
        self.position(mesh, mesh.nodes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_assembly::mesh::kuhn_grid;

    #[test]
    fn an_affine_motion_carries_the_point() {
        let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).expect("a grid");
        let point = EmbeddedPoint {
            id: 7,
            tet: 2,
            weights: [0.4, 0.3, 0.5, -0.2],
        };
        let affine = |x: [f64; 3]| [2.0 * x[0] + x[1], x[1] - 1.0, 3.0 * x[2] + 0.5];
        let moved: Vec<_> = mesh.nodes().iter().map(|&x| affine(x)).collect();
        let expected = affine(point.rest_position(&mesh));
        let found = point.position(&mesh, &moved);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-15));
    }
}
