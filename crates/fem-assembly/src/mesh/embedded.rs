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

    /// The point at `p` on the tetrahedron of `nodes`, whose places are `rest`; far outside it the weights
    /// are large. `None` where the tetrahedron has less than 1e-9 of the volume that its longest edge
    /// allows, a node is not in `rest` or a number is not finite.
    pub fn at(nodes: [u32; 4], rest: &[[f64; 3]], p: [f64; 3]) -> Option<Self> {
        let mut corners = [[0.0; 3]; 4];
        for (corner, n) in corners.iter_mut().zip(nodes) {
            *corner = *rest.get(n as usize)?;
        }
        let from = |x: [f64; 3]| sub(x, corners[0]);
        let [b, c, d, p] = [corners[1], corners[2], corners[3], p].map(from);
        let volume = triple(b, c, d);
        let edges = [b, c, d, sub(c, b), sub(d, b), sub(d, c)];
        let longest = edges.map(|e| e.map(|x| x * x).iter().sum::<f64>().sqrt());
        let longest = longest.into_iter().fold(0.0, f64::max);
        if !(volume.abs() > FLAT * longest * longest * longest) {
            return None;
        }
        let others = [triple(p, c, d), triple(b, p, d), triple(b, c, p)].map(|v| v / volume);
        let weights = [
            1.0 - others[0] - others[1] - others[2],
            others[0],
            others[1],
            others[2],
        ];
        let finite = weights.iter().all(|w| w.is_finite());
        finite.then_some(Self { nodes, weights })
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

/// The share of the cube of its longest edge that a tetrahedron's volume, six times, is at least.
const FLAT: f64 = 1e-9;

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// a · (b × c).
fn triple(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
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
    fn a_place_has_weights_inside_and_outside() {
        let mesh = kuhn_grid(1, 1, 1, [1.0, 2.0, 3.0]).expect("a grid");
        for weights in [[0.4, 0.3, 0.5, -0.2], [0.0, 0.0, 1.0, 0.0]] {
            let nodes = mesh.tet(3);
            let place = EmbeddedPoint { nodes, weights }.position(mesh.nodes());
            let found = EmbeddedPoint::at(nodes, mesh.nodes(), place).expect("a tetrahedron");
            let off = |k: usize| (found.weights[k] - weights[k]).abs();
            assert!((0..4).all(|k| off(k) < 1e-14), "{found:?}");
        }
        let flat = [0, 1, 1, 2];
        assert_eq!(EmbeddedPoint::at(flat, mesh.nodes(), [0.5; 3]), None);
        assert_eq!(
            EmbeddedPoint::at([0, 1, 2, 8], mesh.nodes(), [0.5; 3]),
            None
        );
        // In one plane to the last digit that its coordinates have.
        let plane = [[0.1, 0.7, 0.3], [0.9, 0.2, 0.4], [0.3, 0.35, 0.6]];
        let mean = |i: usize| plane.iter().map(|p| p[i]).sum::<f64>() / 3.0;
        let flat = [plane[0], plane[1], plane[2], [mean(0), mean(1), mean(2)]];
        assert_eq!(EmbeddedPoint::at([0, 1, 2, 3], &flat, [0.5; 3]), None);
        let nowhere = [f64::NAN, 0.0, 0.0];
        assert_eq!(EmbeddedPoint::at(mesh.tet(0), mesh.nodes(), nowhere), None);
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
