//! The rest state of all elements: nodes, shape function gradients and weights.

use crate::error::AssemblyError;
use crate::shape::ElementShape;
use fem_kinematics::{Mat, RestShape, deformation_gradient_at};

/// The rest states of elements of one shape, one after the other.
///
/// Nodes of an element are sorted by their row among the unknowns, prescribed ones last, so that
/// the lower half of its stiffness lands in the lower half of the Hessian.
#[derive(Clone, Debug)]
pub(crate) struct RestElements<const D: usize> {
    /// Nodes of an element.
    pub nodes_each: usize,
    /// Quadrature points of an element.
    pub points_each: usize,
    pub nodes: Vec<u32>,
    /// ∇N of every node but the first, 1/m, point by point.
    pub gradients: Vec<[f64; D]>,
    /// Weight times volume of every point, m³ (m² in 2D).
    pub weights: Vec<f64>,
    /// First row of each element, `u32::MAX` where all its nodes are prescribed.
    pub first_rows: Vec<u32>,
}

impl<const D: usize> RestElements<D> {
    fn empty<S: ElementShape<D>>(count: usize) -> Self {
        Self {
            nodes_each: S::NODES,
            points_each: S::POINTS,
            nodes: Vec::with_capacity(count * S::NODES),
            gradients: Vec::with_capacity(count * S::POINTS * (S::NODES - 1)),
            weights: Vec::with_capacity(count * S::POINTS),
            first_rows: Vec::with_capacity(count),
        }
    }

    /// Of linear simplices: ∇Nₐ is row a − 1 of D_m⁻¹ (document 000, 4.4).
    pub fn linear<'a>(
        elements: impl ExactSizeIterator<Item = &'a [u32]>,
        rest: &[[f64; D]],
        rank: &[u32],
    ) -> Result<Self, AssemblyError> {
        let mut all = Self::empty::<crate::shape::Linear>(elements.len());
        for (element, nodes) in elements.enumerate() {
            let mut sorted = nodes.to_vec();
            check(&sorted, rest.len())?;
            sorted.sort_by_key(|&n| (rank[n as usize], n));
            let shape = rest_shape(element, &sorted, rest)?;
            all.first_rows.push(rank[sorted[0] as usize]);
            all.nodes.extend(sorted);
            all.gradients.extend(shape.inverse.0);
            all.weights.push(shape.volume);
        }
        Ok(all)
    }

    /// Of quadratic simplices with straight edges: corners, then the middle of each edge; the rule
    /// of D + 1 points that is exact for quadratic integrands.
    pub fn quadratic<'a, S: ElementShape<D>>(
        elements: impl ExactSizeIterator<Item = &'a [u32]>,
        edges: &[[usize; 2]],
        rest: &[[f64; D]],
        rank: &[u32],
    ) -> Result<Self, AssemblyError> {
        let mut all = Self::empty::<S>(elements.len());
        for (element, nodes) in elements.enumerate() {
            check(nodes, rest.len())?;
            let shape = rest_shape(element, &nodes[..=D], rest)?;
            let corners: Vec<_> = (0..=D).map(|a| shape.barycentric_gradient(a)).collect();
            let mut order: Vec<usize> = (0..nodes.len()).collect();
            order.sort_by_key(|&a| (rank[nodes[a] as usize], nodes[a]));
            all.first_rows.push(rank[nodes[order[0]] as usize]);
            all.nodes.extend(order.iter().map(|&a| nodes[a]));
            for point in 0..S::POINTS {
                let gradients = quadratic_gradients(barycentric::<D>(point), &corners, edges);
                all.gradients
                    .extend(order[1..].iter().map(|&a| gradients[a]));
                all.weights.push(shape.volume / S::POINTS as f64);
            }
        }
        Ok(all)
    }

    pub fn len(&self) -> usize {
        self.first_rows.len()
    }
    /// The nodes of an element.
    pub fn nodes_of(&self, element: usize) -> &[u32] {
        &self.nodes[element * self.nodes_each..(element + 1) * self.nodes_each]
    }
    /// Its weights, one for each point.
    pub fn weights_of(&self, element: usize) -> &[f64] {
        &self.weights[element * self.points_each..(element + 1) * self.points_each]
    }
    /// ∇N of every node but the first at a point.
    pub fn gradients_of(&self, element: usize, point: usize) -> &[[f64; D]] {
        let each = self.nodes_each - 1;
        let start = (element * self.points_each + point) * each;
        &self.gradients[start..start + each]
    }
    /// Rest volume, m³ (m² in 2D).
    pub fn volume(&self, element: usize) -> f64 {
        self.weights_of(element).iter().sum()
    }
    /// F = Σₐ xₐ ∇Nₐᵀ at a point.
    pub fn deformation_gradient(
        &self,
        element: usize,
        point: usize,
        positions: &[[f64; D]],
    ) -> Mat<f64, D> {
        let nodes = self.nodes_of(element);
        let origin = positions[nodes[0] as usize];
        // Room for the largest element, a quadratic tetrahedron.
        let mut edges = [[0.0; D]; 9];
        for (edge, &node) in edges.iter_mut().zip(&nodes[1..]) {
            let x = positions[node as usize];
            *edge = std::array::from_fn(|i| x[i] - origin[i]);
        }
        deformation_gradient_at(&edges, self.gradients_of(element, point))
    }
}

fn check(nodes: &[u32], count: usize) -> Result<(), AssemblyError> {
    match nodes.iter().find(|&&n| n as usize >= count) {
        Some(&node) => {
            let node = node as usize;
            Err(AssemblyError::NoSuchNode { node, count })
        }
        None => Ok(()),
    }
}

fn rest_shape<const D: usize>(
    element: usize,
    corners: &[u32],
    rest: &[[f64; D]],
) -> Result<RestShape<f64, D>, AssemblyError> {
    let vertices: Vec<[f64; D]> = corners.iter().map(|&n| rest[n as usize]).collect();
    RestShape::from_vertices(&vertices).map_err(|_| AssemblyError::DegenerateElement {
        element,
        volume: RestShape::from_shape_matrix(&fem_kinematics::shape_matrix(&vertices)).volume,
        nodes: corners.to_vec(),
    })
}

/// Barycentric coordinates of the points of the rule: near each corner in turn.
fn barycentric<const D: usize>(point: usize) -> Vec<f64> {
    // (1/6, 1/6, 2/3); (5 − √5)/20 and (5 + 3√5)/20 (Hammer, Marlowe and Stroud 1956).
    let far = if D == 2 {
        1.0 / 6.0
    } else {
        (5.0 - 5.0_f64.sqrt()) / 20.0
    };
    let mut coordinates = vec![far; D + 1];
    coordinates[point] = 1.0 - D as f64 * far;
    coordinates
}

/// ∇N of corner a, N = λ_a (2 λ_a − 1), and of the middle of edge ab, N = 4 λ_a λ_b.
fn quadratic_gradients<const D: usize>(
    at: Vec<f64>,
    corners: &[[f64; D]],
    edges: &[[usize; 2]],
) -> Vec<[f64; D]> {
    let of_corner = |a: usize| corners[a].map(|g| (4.0 * at[a] - 1.0) * g);
    let of_edge = |&[a, b]: &[usize; 2]| {
        std::array::from_fn(|j| 4.0 * (at[a] * corners[b][j] + at[b] * corners[a][j]))
    };
    (0..=D)
        .map(of_corner)
        .chain(edges.iter().map(of_edge))
        .collect()
}
