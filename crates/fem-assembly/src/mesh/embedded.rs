//! Points that ride on a mesh.

/// A point fixed to a tetrahedron by barycentric weights: x = Σ wₖ x_(node k). Weights sum to 1; a
/// point a little outside the mesh has a negative one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedPoint {
    /// The nodes of the tetrahedron.
    pub nodes: [u32; 4],
    /// Their weights.
    pub weights: [f64; 4],
}

impl EmbeddedPoint {
    /// A node itself.
    pub fn node(node: u32) -> Self {
        Self {
            nodes: [node; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
        }
    }

    /// Where the point is when the mesh's nodes are at `x`, meters: at rest with those of the mesh.
    /// `x` has one entry per node; without one for a node of the point, as of a point of another mesh,
    /// its place is NaN, which fails every comparison that accepts something.
    #[inline]
    pub fn position(&self, x: &[[f64; 3]]) -> [f64; 3] {
        let at = |n: u32| x.get(n as usize).copied().unwrap_or([f64::NAN; 3]);
        let [a, b, c, d] = self.nodes.map(at);
        let [p, q, r, s] = self.weights;
        std::array::from_fn(|i| p * a[i] + q * b[i] + r * c[i] + s * d[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::kuhn_grid;

    #[test]
    fn a_point_of_another_mesh_is_nowhere() {
        let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).expect("a grid");
        let inside = EmbeddedPoint {
            nodes: [0, 1, 2, 7],
            weights: [0.25, 0.25, 0.5, 0.0],
        };
        let place = inside.position(mesh.nodes());
        assert!(place.iter().all(|c| c.is_finite()), "{place:?}");
        for nodes in [[0, 1, 2, 8], [u32::MAX, 1, 2, 3]] {
            let place = EmbeddedPoint { nodes, ..inside }.position(mesh.nodes());
            assert!(place.iter().all(|c| c.is_nan()), "{place:?}");
        }
        let place = inside.position(&mesh.nodes()[..7]);
        assert!(place.iter().all(|c| c.is_nan()), "{place:?}");
    }

    #[test]
    fn an_affine_motion_carries_the_point() {
        let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).expect("a grid");
        let point = EmbeddedPoint {
            nodes: mesh.tet(2),
            weights: [0.4, 0.3, 0.5, -0.2],
        };
        let affine = |x: [f64; 3]| [2.0 * x[0] + x[1], x[1] - 1.0, 3.0 * x[2] + 0.5];
        let moved: Vec<_> = mesh.nodes().iter().map(|&x| affine(x)).collect();
        let expected = affine(point.position(mesh.nodes()));
        let found = point.position(&moved);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-15));
    }
}
