//! The frame of a bone that moves as its nodes do.

use super::geometry::{Point, cross, dot, norm, sub};
use crate::error::AssemblyError;
use fem_kinematics::{Mat, RestShape, deformation_gradient_at, shape_matrix};

/// Four nodes of a bone that is moved as a whole, X ↦ M X + t: they say where it is.
///
/// With gₖ = ∇bₖ of the barycentric coordinates in the tetrahedron of the nodes at rest,
/// M = Σ (xₖ − x₀) gₖᵀ, and the point that lies at x now lay at X₀ + M⁻¹(x − x₀).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidFrame {
    nodes: [usize; 4],
    origin: Point,
    gradients: [Point; 4],
}

/// Where a frame is now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// M⁻¹.
    pub inverse: Mat<f64, 3>,
    at: Point,
    origin: Point,
    /// gₖ.
    gradients: [Point; 4],
}

impl RigidFrame {
    /// Takes those of `candidates` that are far from each other.
    ///
    /// # Errors
    /// When a node does not exist, or all lie (nearly) in a plane.
    pub fn new(rest: &[[f64; 3]], candidates: &[usize]) -> Result<Self, AssemblyError> {
        let count = rest.len();
        if let Some(&node) = candidates.iter().find(|&&n| n >= count) {
            return Err(AssemblyError::NoSuchNode { node, count });
        }
        let farthest = |size: &dyn Fn(usize) -> f64| {
            let larger = |&a: &usize, &b: &usize| size(a).total_cmp(&size(b)).then(b.cmp(&a));
            candidates.iter().copied().max_by(larger)
        };
        let flat = |value: f64| AssemblyError::UnusableContact {
            what: "the volume between four nodes of a bone",
            value,
        };
        let first = *candidates.first().ok_or_else(|| flat(0.0))?;
        let way = |from: usize, to: usize| sub(rest[to], rest[from]);
        let far = |size: &dyn Fn(usize) -> f64| farthest(size).ok_or_else(|| flat(0.0));
        let a = far(&|n| norm(way(first, n)))?;
        let b = far(&|n| norm(way(a, n)))?;
        let c = far(&|n| norm(cross(way(a, b), way(a, n))))?;
        let across = cross(way(a, b), way(a, c));
        let d = far(&|n| dot(across, way(a, n)).abs())?;
        let volume = dot(across, way(a, d));
        let size = norm(way(a, b));
        if !(volume.abs() > 1e-6 * size * size * size) {
            return Err(flat(volume.abs()));
        }
        let nodes = [a, b, c, d];
        let shape = RestShape::from_shape_matrix(&shape_matrix(&nodes.map(|n| rest[n])));
        Ok(Self {
            nodes,
            origin: rest[a],
            gradients: std::array::from_fn(|k| shape.barycentric_gradient(k)),
        })
    }

    /// Its nodes.
    pub fn nodes(&self) -> [usize; 4] {
        self.nodes
    }

    pub(crate) fn placed(&self, positions: &[Point]) -> Placed {
        let x = self.nodes.map(|n| positions[n]);
        let edges: [Point; 3] = std::array::from_fn(|k| sub(x[k + 1], x[0]));
        Placed {
            inverse: deformation_gradient_at(&edges, &self.gradients[1..]).inverse(),
            at: x[0],
            origin: self.origin,
            gradients: self.gradients,
        }
    }
}

impl Placed {
    /// A frame that does not move.
    pub const FIXED: Self = Self {
        inverse: Mat([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        at: [0.0; 3],
        origin: [0.0; 3],
        gradients: [[0.0; 3]; 4],
    };

    /// Where x would be at rest.
    pub fn at_rest(&self, x: Point) -> Point {
        let turned = self.inverse.mul_vec(sub(x, self.at));
        std::array::from_fn(|i| self.origin[i] + turned[i])
    }

    /// bₖ of a point at rest.
    pub fn barycentric(&self, rest: Point) -> [f64; 4] {
        let way = sub(rest, self.origin);
        std::array::from_fn(|k| f64::from(u8::from(k == 0)) + dot(self.gradients[k], way))
    }

    /// M⁻ᵀ gₖ: the gradients in the moved frame.
    pub fn moved_gradients(&self) -> [Point; 4] {
        self.gradients.map(|g| self.inverse.tr_mul_vec(g))
    }
}
