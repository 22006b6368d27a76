//! Uniform refinement: every tetrahedron into eight, every triangle into four.

use super::error::MeshError;
use super::simplex::{SimplexMesh, edges};
use super::validate::{Orientation, Orphans};

/// A refined mesh and where its parts come from.
///
/// The nodes of the coarse mesh keep their numbers; the midpoint of `node_parents[k]` follows as
/// node `coarse_nodes + k`.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined<const D: usize> {
    /// The finer mesh.
    pub mesh: SimplexMesh<D>,
    /// The coarse element that each fine element lies in.
    pub parent: Vec<u32>,
    /// Nodes of the coarse mesh.
    pub coarse_nodes: usize,
    /// The two ends of the coarse edge whose midpoint a new node is.
    pub node_parents: Vec<[u32; 2]>,
}

impl<const D: usize> Refined<D> {
    /// Values per coarse element, carried to the fine elements. `None` for a wrong length.
    pub fn per_element<T: Clone>(&self, coarse: &[T]) -> Option<Vec<T>> {
        let value = |&e: &u32| coarse.get(e as usize).cloned();
        let children = 1 << D;
        (coarse.len() * children == self.parent.len())
            .then(|| self.parent.iter().map(value).collect())
            .flatten()
    }
    /// Values per coarse node, carried to the fine nodes; `merge` gives a midpoint its value from
    /// those of the two ends. `None` for a wrong length.
    pub fn per_node<T: Clone>(&self, coarse: &[T], merge: impl Fn(&T, &T) -> T) -> Option<Vec<T>> {
        if coarse.len() != self.coarse_nodes {
            return None;
        }
        let mut fine = coarse.to_vec();
        fine.extend(
            self.node_parents
                .iter()
                .map(|&[a, b]| merge(&coarse[a as usize], &coarse[b as usize])),
        );
        Some(fine)
    }
    /// Vectors per coarse node, interpolated linearly. `None` for a wrong length.
    pub fn interpolate<const N: usize>(&self, coarse: &[[f64; N]]) -> Option<Vec<[f64; N]>> {
        self.per_node(coarse, |a, b| std::array::from_fn(|i| 0.5 * (a[i] + b[i])))
    }
}

/// Edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// The diagonals of the inner octahedron as pairs of entries of `EDGES`, each with the ring of the
/// four other midpoints around it.
const DIAGONALS: [([usize; 2], [usize; 4]); 3] = [
    ([0, 5], [1, 2, 4, 3]),
    ([1, 4], [0, 2, 5, 3]),
    ([2, 3], [0, 1, 5, 4]),
];

impl<const D: usize> SimplexMesh<D> {
    /// Splits every element at its edge midpoints: tetrahedra into four corners and an octahedron
    /// cut along its shortest diagonal, triangles into four. Volumes add up exactly, and
    /// neighbors stay conforming.
    ///
    /// # Errors
    /// [`MeshError::TooManyNodes`], or [`MeshError::ZeroVolume`] where a child of an almost flat
    /// element is flat.
    pub fn refine(&self) -> Result<Refined<D>, MeshError> {
        let midpoints = self.edges();
        let total = self.num_nodes() + midpoints.len();
        if total > u32::MAX as usize {
            return Err(MeshError::TooManyNodes(total));
        }
        let mut nodes = self.nodes().to_vec();
        nodes.extend(midpoints.iter().map(|&[a, b]| {
            let (a, b) = (self.node(a), self.node(b));
            std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
        }));
        let midpoint = |a: u32, b: u32| {
            let key = [a.min(b), a.max(b)];
            // `edges` is sorted and has every edge of every element: as many lie before this one.
            let at = midpoints.partition_point(|edge| *edge < key);
            (self.num_nodes() + at) as u32
        };
        let children = 1 << D;
        let mut connectivity = Vec::with_capacity(self.connectivity().len() * children);
        let mut parent = Vec::with_capacity(self.num_elements() * children);
        for (e, t) in self.elements().enumerate() {
            if D == 2 {
                let [ab, ac, bc] = [[0, 1], [0, 2], [1, 2]].map(|[i, j]| midpoint(t[i], t[j]));
                connectivity.extend([t[0], ab, ac, ab, t[1], bc, ac, bc, t[2], ab, bc, ac]);
            } else {
                let m = EDGES.map(|[i, j]| midpoint(t[i], t[j]));
                let [ab, ac, ad, bc, bd, cd] = m;
                connectivity.extend([t[0], ab, ac, ad, ab, t[1], bc, bd]);
                connectivity.extend([ac, bc, t[2], cd, ad, bd, cd, t[3]]);
                octahedron(&nodes, m, &mut connectivity);
            }
            parent.extend(std::iter::repeat_n(e as u32, children));
        }
        // Orphans of the coarse mesh stay orphans of the fine one.
        let checks = (Orientation::Refuse, Orphans::Allow);
        let (mesh, _) = Self::with_repairs(nodes, connectivity, checks.0, checks.1)?;
        Ok(Refined {
            mesh,
            parent,
            coarse_nodes: self.num_nodes(),
            node_parents: midpoints,
        })
    }
}

/// The four tetrahedra around the shortest diagonal of the octahedron of edge midpoints `m`.
fn octahedron<const D: usize>(nodes: &[[f64; D]], m: [u32; 6], connectivity: &mut Vec<u32>) {
    let length = |[i, j]: [usize; 2]| -> f64 {
        let (a, b) = (nodes[m[i] as usize], nodes[m[j] as usize]);
        (0..D).map(|k| (a[k] - b[k]).powi(2)).sum()
    };
    let (mut ends, mut ring) = DIAGONALS[0];
    for (other, around) in &DIAGONALS[1..] {
        if length(*other) < length(ends) {
            (ends, ring) = (*other, *around);
        }
    }
    for k in 0..4 {
        let mut tet = [ends[0], ends[1], ring[k], ring[(k + 1) % 4]].map(|i| m[i]);
        if edges(nodes, &tet).determinant() < 0.0 {
            tet.swap(2, 3);
        }
        connectivity.extend(tet);
    }
}

#[cfg(test)]
mod tests {
    use super::super::kuhn_grid;
    use super::*;

    #[test]
    fn children_fill_their_parent() {
        let coarse = kuhn_grid(2, 1, 3, [1.0, 0.5, 2.0]).expect("a grid");
        let fine = coarse.refine().expect("refinable");
        assert_eq!(fine.mesh.num_elements(), 8 * coarse.num_elements());
        let mut volume = vec![0.0; coarse.num_elements()];
        for (e, &p) in fine.parent.iter().enumerate() {
            volume[p as usize] += fine.mesh.volume(e);
        }
        for (e, v) in volume.iter().enumerate() {
            assert!((v / coarse.volume(e) - 1.0).abs() < 1e-12, "{e}");
        }
        // Conforming: the surface has four faces for each coarse one, and no crack inside.
        assert_eq!(
            fine.mesh.boundary().faces.len(),
            4 * coarse.boundary().faces.len()
        );
        assert_eq!(fine.mesh.components().1, 1);
    }

    #[test]
    fn data_is_carried() {
        let coarse = kuhn_grid(1, 1, 1, [1.0, 2.0, 3.0]).expect("a grid");
        let fine = coarse.refine().expect("refinable");
        assert_eq!(
            fine.interpolate(coarse.nodes()).as_deref(),
            Some(fine.mesh.nodes())
        );
        let label: Vec<usize> = (0..6).collect();
        let carried = fine.per_element(&label).expect("one label per element");
        assert_eq!(&carried[7..9], [0, 1]);
        assert_eq!(fine.per_element(&label[1..]), None);
        assert_eq!(fine.interpolate(&coarse.nodes()[1..]), None);
    }

    #[test]
    fn triangles_split_into_four() {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let fine = SimplexMesh::<2>::new(nodes, vec![0, 1, 2])
            .expect("a triangle")
            .refine()
            .expect("refinable");
        assert_eq!(fine.mesh.num_elements(), 4);
        assert!((0..4).all(|e| fine.mesh.volume(e) == 0.125));
    }
}
