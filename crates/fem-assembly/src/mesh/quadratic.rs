//! Meshes of straight quadratic triangles and tetrahedra.

use super::error::{Ids, MeshError};
use super::simplex::SimplexMesh;
use super::validate::{Orientation, Orphans, Repairs};

/// Nodes and straight-sided quadratic simplices (6 nodes each for D = 2, 10 for D = 3), validated.
///
/// An element lists its D + 1 corners, then the middles of its edges in VTK's order: 01, 12, 02
/// for a triangle (VTK type 22) and 01, 12, 02, 03, 13, 23 for a tetrahedron (type 24). Elements
/// that share an edge share the node in its middle. Edges are straight, so an element has the rest
/// shape of its corners: D_m, volume and quality are those of [`QuadraticMesh::corners`].
///
/// ```
/// use fem_assembly::mesh::{kuhn_grid, QuadraticMesh};
/// let linear = kuhn_grid(1, 1, 1, [1.0; 3])?;
/// let mesh = QuadraticMesh::from_linear(&linear)?;
/// // A node for each of the 19 edges, behind the 8 corners.
/// assert_eq!((mesh.num_nodes(), mesh.num_elements()), (8 + 19, 6));
/// assert_eq!(mesh.corners().connectivity(), linear.connectivity());
/// # Ok::<(), fem_assembly::mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticMesh<const D: usize> {
    /// Has all nodes, so that both meshes number them alike.
    corners: SimplexMesh<D>,
    connectivity: Vec<u32>,
}

/// How far a midside node may lie off the middle, as a share of its edge.
const OFF_MIDDLE: f64 = 1e-9;

/// Corners at the ends of every edge, in VTK's order; a triangle has the first three.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

impl<const D: usize> QuadraticMesh<D> {
    /// Nodes of one element, (D + 1)(D + 2)/2.
    pub const NODES_PER_ELEMENT: usize = (D + 1) * (D + 2) / 2;

    /// The two corners (0 to D) of every edge, in the order of the midside nodes.
    pub fn edges_of_an_element() -> &'static [[usize; 2]] {
        &EDGES[..D * (D + 1) / 2]
    }

    /// Puts a node into the middle of every edge, behind the nodes there are: edge k of
    /// [`SimplexMesh::edges`] (sorted by its lower, then its higher node) gets node `num_nodes + k`.
    ///
    /// # Errors
    /// [`MeshError::TooManyNodes`].
    pub fn from_linear(mesh: &SimplexMesh<D>) -> Result<Self, MeshError> {
        let edges = mesh.edges();
        let first = mesh.num_nodes();
        if first + edges.len() > u32::MAX as usize {
            return Err(MeshError::TooManyNodes(first + edges.len()));
        }
        let mut nodes = mesh.nodes().to_vec();
        nodes.extend(
            edges
                .iter()
                .map(|&[a, b]| middle(mesh.node(a), mesh.node(b))),
        );
        let mut connectivity = Vec::with_capacity(mesh.num_elements() * Self::NODES_PER_ELEMENT);
        for element in mesh.elements() {
            connectivity.extend_from_slice(element);
            for &[i, j] in Self::edges_of_an_element() {
                let edge = [element[i].min(element[j]), element[i].max(element[j])];
                let at = edges.partition_point(|e| *e < edge);
                connectivity.push((first + at) as u32);
            }
        }
        let corners = SimplexMesh {
            nodes,
            connectivity: mesh.connectivity().to_vec(),
        };
        Ok(Self {
            corners,
            connectivity,
        })
    }

    /// A mesh from nodes (meters) and the node indices of its elements, in VTK's order.
    ///
    /// # Errors
    /// Any [`MeshError`]; negative volumes and orphan nodes are refused.
    pub fn new(nodes: Vec<[f64; D]>, connectivity: Vec<u32>) -> Result<Self, MeshError> {
        Self::with_repairs(nodes, connectivity, Orientation::Refuse, Orphans::Refuse)
            .map(|(mesh, _)| mesh)
    }

    /// A mesh from nodes (meters) and node indices; says what it repaired and tolerated. An element
    /// of negative volume gets its last two corners swapped, and the middles of its edges with them.
    ///
    /// A midside node may lie off the middle of its edge by 1e-9 of the edge, and by the rounding of
    /// the coordinates: that of 32-bit floats where all of them are such numbers.
    ///
    /// # Errors
    /// Any [`MeshError`]: what cannot be repaired, or was asked to be refused.
    pub fn with_repairs(
        nodes: Vec<[f64; D]>,
        mut connectivity: Vec<u32>,
        orientation: Orientation,
        orphans: Orphans,
    ) -> Result<(Self, Repairs), MeshError> {
        let all = Self::NODES_PER_ELEMENT;
        if !connectivity.len().is_multiple_of(all) {
            return Err(MeshError::RaggedConnectivity {
                length: connectivity.len(),
                nodes_per_element: all,
            });
        }
        let elements = connectivity.chunks_exact(all);
        let linear: Vec<u32> = elements.clone().flat_map(|e| &e[..=D]).copied().collect();
        let count = nodes.len();
        let beyond = |e: &[u32]| e.iter().any(|&n| n as usize >= count);
        if let Some(ids) = Ids::of(elements.enumerate().filter(|(_, e)| beyond(e)).map(first)) {
            return Err(MeshError::IndexOutOfRange { ids, nodes: count });
        }
        let (corners, mut repairs) =
            SimplexMesh::with_repairs(nodes, linear, orientation, Orphans::Allow)?;
        for &e in &repairs.inverted {
            swap_last_corners::<D>(&mut connectivity[e as usize * all..][..all]);
        }
        let mesh = Self {
            corners,
            connectivity,
        };
        mesh.check_middles()?;
        mesh.check_sharing()?;
        let mut used = vec![false; count];
        for &n in &mesh.connectivity {
            used[n as usize] = true;
        }
        repairs.orphans.retain(|&n| !used[n as usize]);
        match Ids::of(repairs.orphans.iter().map(|&n| n as usize)) {
            Some(ids) if orphans == Orphans::Refuse => Err(MeshError::Orphan(ids)),
            _ => Ok((mesh, repairs)),
        }
    }

    fn check_middles(&self) -> Result<(), MeshError> {
        let rounding = rounding_of(self.nodes());
        let off = |(_, element): &(usize, &[u32])| {
            let edges = Self::edges_of_an_element().iter();
            edges.zip(&element[D + 1..]).any(|(&[i, j], &n)| {
                let (a, b) = (self.node(element[i]), self.node(element[j]));
                let size = a.iter().chain(&b).fold(0.0_f64, |s, v| s.max(v.abs()));
                let allowed = OFF_MIDDLE * distance(a, b) + rounding * size;
                !(distance(self.node(n), middle(a, b)) <= allowed)
            })
        };
        let bad = self.elements().enumerate().filter(off).map(first);
        Ids::of(bad).map_or(Ok(()), |ids| Err(MeshError::NotMidpoint(ids)))
    }

    /// One node for each edge, and one edge (and no corner) for each midside node.
    fn check_sharing(&self) -> Result<(), MeshError> {
        let mut edges = Vec::with_capacity(self.num_elements() * D * (D + 1) / 2);
        for (e, element) in self.elements().enumerate() {
            for (&[i, j], &n) in Self::edges_of_an_element().iter().zip(&element[D + 1..]) {
                let edge = [element[i].min(element[j]), element[i].max(element[j])];
                edges.push((edge, e, n));
            }
        }
        edges.sort_unstable();
        let same = edges.windows(2).filter(|w| w[0].0 == w[1].0);
        let mut split: Vec<usize> = same.filter(|w| w[0].2 != w[1].2).map(|w| w[1].1).collect();
        split.sort_unstable();
        split.dedup();
        if let Some(ids) = Ids::of(split) {
            return Err(MeshError::SplitEdge(ids));
        }
        edges.dedup_by_key(|edge| edge.0);
        let mut uses = vec![0_u8; self.num_nodes()];
        for &n in self.corners.connectivity() {
            uses[n as usize] = 1;
        }
        let mut twice = Vec::new();
        for &(_, _, n) in &edges {
            match &mut uses[n as usize] {
                0 => uses[n as usize] = 1,
                _ => twice.push(n as usize),
            }
        }
        twice.sort_unstable();
        twice.dedup();
        Ids::of(twice).map_or(Ok(()), |ids| Err(MeshError::MidsideTwice(ids)))
    }

    /// The linear mesh of the corners. It has all nodes of this one under the same numbers; the
    /// midside nodes belong to none of its elements.
    pub fn corners(&self) -> &SimplexMesh<D> {
        &self.corners
    }
    /// Rest positions of corners and midside nodes, meters.
    pub fn nodes(&self) -> &[[f64; D]] {
        self.corners.nodes()
    }
    /// Position of node `n`, meters.
    pub fn node(&self, n: u32) -> [f64; D] {
        self.corners.node(n)
    }
    /// How many nodes.
    pub fn num_nodes(&self) -> usize {
        self.corners.num_nodes()
    }
    /// How many elements.
    pub fn num_elements(&self) -> usize {
        self.corners.num_elements()
    }
    /// The node indices of all elements, [`QuadraticMesh::NODES_PER_ELEMENT`] for each.
    pub fn connectivity(&self) -> &[u32] {
        &self.connectivity
    }
    /// The nodes of element `e`: corners, then the middles of the edges.
    pub fn element(&self, e: usize) -> &[u32] {
        &self.connectivity[e * Self::NODES_PER_ELEMENT..(e + 1) * Self::NODES_PER_ELEMENT]
    }
    /// The nodes of every element, in order.
    pub fn elements(&self) -> std::slice::ChunksExact<'_, u32> {
        self.connectivity.chunks_exact(Self::NODES_PER_ELEMENT)
    }
}

fn first<T>((e, _): (usize, T)) -> usize {
    e
}

fn middle<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|i| 0.5 * a[i] + 0.5 * b[i])
}

fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    let square: f64 = (0..D).map(|i| (a[i] - b[i]).powi(2)).sum();
    square.sqrt()
}

/// Twice the relative rounding of the coordinates, which may have been 32-bit floats in a file.
fn rounding_of<const D: usize>(nodes: &[[f64; D]]) -> f64 {
    let single = |v: &f64| f64::from(*v as f32) == *v;
    if nodes.iter().flatten().all(single) {
        2.0 * f64::from(f32::EPSILON)
    } else {
        2.0 * f64::EPSILON
    }
}

/// What the swap of the last two corners does to the order of the middles.
fn swap_last_corners<const D: usize>(element: &mut [u32]) {
    element.swap(D - 1, D);
    if D == 2 {
        element.swap(3, 5);
    } else {
        element.swap(5, 8);
        element.swap(6, 7);
    }
}

#[cfg(test)]
mod tests {
    use super::super::kuhn_grid;
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [0.2, 0.0, 0.0],
        [0.0, 0.4, 0.0],
        [0.0, 0.0, 0.6],
    ];

    /// One tetrahedron with its middles written out from VTK's documentation.
    fn one_tet() -> (Vec<[f64; 3]>, Vec<u32>) {
        let mut nodes = CORNERS.to_vec();
        nodes.extend([
            [0.1, 0.0, 0.0],
            [0.1, 0.2, 0.0],
            [0.0, 0.2, 0.0],
            [0.0, 0.0, 0.3],
            [0.1, 0.0, 0.3],
            [0.0, 0.2, 0.3],
        ]);
        (nodes, (0..10).collect())
    }

    #[test]
    fn middles_are_shared_and_numbered_by_sorted_edges() {
        let linear = kuhn_grid(2, 1, 1, [1.0, 1.0, 1.0]).expect("a grid");
        let mesh = QuadraticMesh::from_linear(&linear).expect("a quadratic grid");
        // A grid of nx × ny × nz boxes: every box, face and grid edge has one edge of its own.
        assert_eq!(mesh.num_nodes() - linear.num_nodes(), 2 + 11 + 20);
        for (k, &[a, b]) in linear.edges().iter().enumerate() {
            let (x, y) = (linear.node(a), linear.node(b));
            let between: [f64; 3] = std::array::from_fn(|i| (x[i] + y[i]) / 2.0);
            assert_eq!(mesh.nodes()[linear.num_nodes() + k], between);
        }
        let again = QuadraticMesh::new(mesh.nodes().to_vec(), mesh.connectivity().to_vec());
        assert_eq!(again.as_ref(), Ok(&mesh));
        assert_eq!(mesh.element(3).len(), 10);
        assert!((mesh.corners().total_volume() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_order_of_the_middles_is_that_of_vtk() {
        let (nodes, connectivity) = one_tet();
        let mesh = QuadraticMesh::<3>::new(nodes.clone(), connectivity).expect("VTK's order");
        let linear = SimplexMesh::new(CORNERS.to_vec(), vec![0, 1, 2, 3]).expect("a tet");
        let made = QuadraticMesh::from_linear(&linear).expect("a quadratic tet");
        for (&n, &m) in mesh.element(0).iter().zip(made.element(0)) {
            assert_eq!(mesh.node(n), made.node(m));
        }
        let flat: Vec<[f64; 2]> = [0, 1, 2, 4, 5, 6]
            .map(|n| [nodes[n][0], nodes[n][1]])
            .to_vec();
        let triangle = QuadraticMesh::<2>::new(flat, (0..6).collect()).expect("VTK's order");
        assert!((triangle.corners().volume(0) - 0.04).abs() < 1e-15);
        // Another program's order: 01, 02, 12, …
        let swapped = vec![0, 1, 2, 3, 4, 6, 5, 7, 8, 9];
        let error = QuadraticMesh::<3>::new(nodes, swapped).expect_err("not VTK's order");
        assert!(matches!(&error, MeshError::NotMidpoint(ids) if ids.first == [0]));
    }

    #[test]
    fn each_defect_has_its_own_error() {
        let (nodes, connectivity) = one_tet();
        let refused = |nodes: &[[f64; 3]], c: &[u32]| {
            QuadraticMesh::<3>::new(nodes.to_vec(), c.to_vec()).expect_err("must be refused")
        };
        assert_eq!(refused(&nodes, &[]), MeshError::Empty);
        assert!(matches!(
            refused(&nodes, &connectivity[..9]),
            MeshError::RaggedConnectivity {
                length: 9,
                nodes_per_element: 10
            }
        ));
        assert!(matches!(
            refused(&nodes[..9], &connectivity),
            MeshError::IndexOutOfRange { nodes: 9, .. }
        ));
        let mut curved = nodes.clone();
        curved[8][1] += 1e-8;
        assert!(matches!(
            refused(&curved, &connectivity),
            MeshError::NotMidpoint(_)
        ));
        curved[8][1] = f64::NAN;
        assert!(matches!(
            refused(&curved, &connectivity),
            MeshError::NotFinite(_)
        ));
        let mut more = nodes.clone();
        more.push([1.0; 3]);
        assert!(
            matches!(refused(&more, &connectivity), MeshError::Orphan(ids) if ids.first == [10])
        );
    }

    /// Two tets on one face: the second names the third middle of that face by a node of its own.
    #[test]
    fn neighbors_must_share_the_middles_of_their_edges() {
        let mut corners = CORNERS.to_vec();
        corners.push([0.2, 0.4, 0.6]);
        let linear =
            SimplexMesh::<3>::new(corners, vec![0, 1, 2, 3, 1, 2, 3, 4]).expect("two tets");
        let mesh = QuadraticMesh::from_linear(&linear).expect("quadratic");
        let mut nodes = mesh.nodes().to_vec();
        let mut connectivity = mesh.connectivity().to_vec();
        nodes.push(mesh.node(connectivity[14]));
        connectivity[14] = mesh.num_nodes() as u32;
        let error = QuadraticMesh::<3>::new(nodes, connectivity).expect_err("a crack");
        assert!(matches!(error, MeshError::SplitEdge(ids) if ids.first == [1]));
    }

    /// The diagonals of a square have one middle: triangles that lie on one another.
    #[test]
    fn a_middle_belongs_to_one_edge() {
        let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let linear = SimplexMesh::<2>::new(square, vec![0, 1, 2, 0, 1, 3]).expect("two triangles");
        let mesh = QuadraticMesh::from_linear(&linear).expect("quadratic");
        let diagonal = |e: usize, k: usize| mesh.element(e)[3 + k];
        let (first, second) = (diagonal(0, 2), diagonal(1, 1));
        assert_eq!(mesh.node(first), mesh.node(second));
        let connectivity = mesh.connectivity().iter();
        let merged = connectivity
            .map(|&n| if n == second { first } else { n })
            .collect();
        let made = QuadraticMesh::with_repairs(
            mesh.nodes().to_vec(),
            merged,
            Orientation::Refuse,
            Orphans::Allow,
        );
        let error = made.expect_err("one middle of two edges");
        assert!(matches!(error, MeshError::MidsideTwice(ids) if ids.first == [first as usize]));
    }

    #[test]
    fn inverted_elements_are_repaired_with_their_middles() {
        let linear = kuhn_grid(1, 1, 1, [1.0; 3]).expect("a grid");
        let mesh = QuadraticMesh::from_linear(&linear).expect("quadratic");
        let mut turned = mesh.connectivity().to_vec();
        // Corners 0 and 1 swapped: 01 stays, 12 and 02 change places, 03 and 13 too.
        for (a, b) in [(0, 1), (5, 6), (7, 8)] {
            turned.swap(20 + a, 20 + b);
        }
        let nodes = mesh.nodes().to_vec();
        let error = QuadraticMesh::new(nodes.clone(), turned.clone()).expect_err("inside out");
        assert!(matches!(error, MeshError::NegativeVolume(ids) if ids.first == [2]));
        let (made, repairs) =
            QuadraticMesh::with_repairs(nodes, turned, Orientation::Repair, Orphans::Refuse)
                .expect("repairable");
        assert_eq!(repairs.inverted, [2]);
        assert_eq!(made.corners().volume(2), mesh.corners().volume(2));
        let flat = vec![
            [0.0, 0.0],
            [0.0, 1.0],
            [1.0, 0.0],
            [0.0, 0.5],
            [0.5, 0.5],
            [0.5, 0.0],
        ];
        let triangle = QuadraticMesh::<2>::with_repairs(
            flat,
            (0..6).collect(),
            Orientation::Repair,
            Orphans::Refuse,
        );
        let (triangle, _) = triangle.expect("repairable");
        assert_eq!(triangle.element(0), [0, 2, 1, 5, 4, 3]);
    }

    /// Files hold 32-bit coordinates more often than not: their middles are rounded.
    #[test]
    fn coordinates_of_32_bits_are_straight_enough() {
        let linear = kuhn_grid(7, 2, 3, [0.1; 3]).expect("a grid");
        let mesh = QuadraticMesh::from_linear(&linear).expect("quadratic");
        let shifted = |x: &[f64; 3]| x.map(|v| f64::from((v + 1.7) as f32));
        let rounded: Vec<_> = mesh.nodes().iter().map(shifted).collect();
        let connectivity = mesh.connectivity().to_vec();
        QuadraticMesh::new(rounded.clone(), connectivity.clone()).expect("rounded to 32 bits");
        let mut doubles = rounded;
        doubles[0][0] += 1e-12;
        assert!(QuadraticMesh::new(doubles, connectivity).is_err());
    }
}
