//! The mesh itself.

use fem_kinematics::{Mat, shape_matrix, simplex_volume};

/// Nodes and simplices in D dimensions (triangles for D = 2, tetrahedra for D = 3), validated:
/// finite coordinates, indices in range, no element degenerate, inverted or given twice.
///
/// An element has D + 1 nodes; the indices of all elements lie one after the other in one list.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplexMesh<const D: usize> {
    pub(super) nodes: Vec<[f64; D]>,
    pub(super) connectivity: Vec<u32>,
}

impl<const D: usize> SimplexMesh<D> {
    /// Nodes of one element, D + 1.
    pub const NODES_PER_ELEMENT: usize = D + 1;

    /// Rest positions, meters.
    pub fn nodes(&self) -> &[[f64; D]] {
        &self.nodes
    }
    /// Position of node `n`, meters.
    pub fn node(&self, n: u32) -> [f64; D] {
        self.nodes[n as usize]
    }
    /// How many nodes.
    pub fn num_nodes(&self) -> usize {
        self.nodes.len()
    }
    /// How many elements.
    pub fn num_elements(&self) -> usize {
        self.connectivity.len() / (D + 1)
    }
    /// The node indices of all elements, D + 1 for each.
    pub fn connectivity(&self) -> &[u32] {
        &self.connectivity
    }
    /// The D + 1 nodes of element `e`.
    pub fn element(&self, e: usize) -> &[u32] {
        &self.connectivity[e * (D + 1)..(e + 1) * (D + 1)]
    }
    /// The nodes of every element, in order.
    pub fn elements(&self) -> std::slice::ChunksExact<'_, u32> {
        self.connectivity.chunks_exact(D + 1)
    }
    /// D_m of element `e`: column k is x_{k+1} − x_0 at rest, meters (document 000, 4.1).
    pub fn rest_edges(&self, e: usize) -> Mat<f64, D> {
        edges(&self.nodes, self.element(e))
    }
    /// Volume of element `e`, det(D_m)/D!, m³ (m² for D = 2); positive.
    pub fn volume(&self, e: usize) -> f64 {
        simplex_volume(&self.rest_edges(e))
    }
    /// Sum of all element volumes, m³ (m² for D = 2).
    pub fn total_volume(&self) -> f64 {
        (0..self.num_elements()).map(|e| self.volume(e)).sum()
    }
    /// Lowest and highest coordinate along every axis, meters.
    pub fn bounding_box(&self) -> ([f64; D], [f64; D]) {
        let mut low = [f64::INFINITY; D];
        let mut high = [f64::NEG_INFINITY; D];
        for x in &self.nodes {
            for k in 0..D {
                low[k] = low[k].min(x[k]);
                high[k] = high[k].max(x[k]);
            }
        }
        (low, high)
    }
    /// The same mesh in another unit: every coordinate times `factor`, which must be positive and
    /// finite and keep the coordinates so; otherwise `None`.
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        let nodes: Vec<[f64; D]> = self.nodes.iter().map(|x| x.map(|v| v * factor)).collect();
        let usable = factor > 0.0 && nodes.iter().flatten().all(|v| v.is_finite());
        usable.then(|| Self {
            nodes,
            connectivity: self.connectivity.clone(),
        })
    }
}

impl SimplexMesh<3> {
    /// The four nodes of tetrahedron `e`.
    pub fn tet(&self, e: usize) -> [u32; 4] {
        let t = self.element(e);
        [t[0], t[1], t[2], t[3]]
    }
    /// The four nodes of every tetrahedron, in order.
    pub fn tets(&self) -> impl ExactSizeIterator<Item = [u32; 4]> + '_ {
        self.elements().map(|t| [t[0], t[1], t[2], t[3]])
    }
}

/// The matrix whose column k is x_{k+1} − x_0.
pub(super) fn edges<const D: usize>(nodes: &[[f64; D]], element: &[u32]) -> Mat<f64, D> {
    let corners: [[f64; D]; 4] = std::array::from_fn(|a| nodes[element[a.min(D)] as usize]);
    shape_matrix(&corners[..=D])
}
