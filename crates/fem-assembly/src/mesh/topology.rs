//! Which elements touch: boundary, neighbors, connected components.

use super::simplex::SimplexMesh;

/// Lists of varying length behind one another: list `i` is `items[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Csr {
    offsets: Vec<u32>,
    items: Vec<u32>,
}

impl Csr {
    /// Groups `(row, item)` pairs by row, keeping the order within a row.
    fn group(rows: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut offsets = vec![0_u32; rows + 1];
        for (row, _) in pairs.clone() {
            offsets[row as usize + 1] += 1;
        }
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        let mut next = offsets.clone();
        let mut items = vec![0; offsets[rows] as usize];
        for (row, item) in pairs {
            items[next[row as usize] as usize] = item;
            next[row as usize] += 1;
        }
        Self { offsets, items }
    }
    /// How many lists.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }
    /// Whether there is no list.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// List `i`.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.items[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }
}

/// The faces that belong to one element only, with their outward orientation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Boundary<const D: usize> {
    /// D nodes each: counter-clockwise seen from outside (3D), material on the left (2D).
    pub faces: Vec<[u32; D]>,
    /// The element behind each face.
    pub element: Vec<u32>,
}

/// Nodes of the face opposite node k, outward for a positive element.
const TET_FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
const TRIANGLE_FACES: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

impl<const D: usize> SimplexMesh<D> {
    fn face(&self, e: usize, k: usize) -> [u32; D] {
        let t = self.element(e);
        std::array::from_fn(|i| match D {
            2 => t[TRIANGLE_FACES[k][i]],
            _ => t[TET_FACES[k][i]],
        })
    }

    /// (sorted nodes, element, opposite corner) of every face, equal faces next to each other.
    fn sorted_faces(&self) -> Vec<([u32; D], u32, u8)> {
        let mut faces = Vec::with_capacity(self.connectivity().len());
        for e in 0..self.num_elements() {
            for k in 0..=D {
                let mut key = self.face(e, k);
                key.sort_unstable();
                faces.push((key, e as u32, k as u8));
            }
        }
        faces.sort_unstable();
        faces
    }

    /// The boundary surface (curve in 2D), ordered by element.
    pub fn boundary(&self) -> Boundary<D> {
        let faces = self.sorted_faces();
        let mut single: Vec<(u32, u8)> = faces
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|equal| equal.len() == 1)
            .map(|equal| (equal[0].1, equal[0].2))
            .collect();
        single.sort_unstable();
        Boundary {
            faces: single
                .iter()
                .map(|&(e, k)| self.face(e as usize, k as usize))
                .collect(),
            element: single.iter().map(|&(e, _)| e).collect(),
        }
    }

    /// The elements around every node, ascending.
    pub fn node_elements(&self) -> Csr {
        let pairs = self
            .connectivity()
            .iter()
            .enumerate()
            .map(|(i, &n)| (n, (i / (D + 1)) as u32));
        Csr::group(self.num_nodes(), pairs)
    }

    /// The neighbors of every node along edges, ascending, without the node itself.
    pub fn node_neighbors(&self) -> Csr {
        let pairs: Vec<(u32, u32)> = self
            .edges()
            .iter()
            .flat_map(|&[a, b]| [(a, b), (b, a)])
            .collect();
        let mut sorted = pairs;
        sorted.sort_unstable();
        Csr::group(self.num_nodes(), sorted.iter().copied())
    }

    /// All edges, the lower node first, in lexical order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.num_elements() * D * (D + 1) / 2);
        for t in self.elements() {
            for j in 1..=D {
                for i in 0..j {
                    edges.push([t[i].min(t[j]), t[i].max(t[j])]);
                }
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The elements that share a whole face with every element, ascending.
    pub fn element_neighbors(&self) -> Csr {
        let mut pairs = Vec::new();
        for equal in self.sorted_faces().chunk_by(|a, b| a.0 == b.0) {
            for a in equal {
                for b in equal {
                    if a.1 != b.1 {
                        pairs.push((a.1, b.1));
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        Csr::group(self.num_elements(), pairs.iter().copied())
    }

    /// For every element the number of its face-connected component, numbered by first element;
    /// and how many components there are.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let neighbors = self.element_neighbors();
        let mut component = vec![u32::MAX; self.num_elements()];
        let mut count = 0_u32;
        let mut stack = Vec::new();
        for start in 0..self.num_elements() {
            if component[start] != u32::MAX {
                continue;
            }
            component[start] = count;
            stack.push(start);
            while let Some(e) = stack.pop() {
                for &other in neighbors.row(e) {
                    if component[other as usize] == u32::MAX {
                        component[other as usize] = count;
                        stack.push(other as usize);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }

    /// Faces shared by three or more elements; none in a manifold mesh.
    pub fn overlapping_faces(&self) -> usize {
        self.sorted_faces()
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|equal| equal.len() > 2)
            .count()
    }
}

#[cfg(test)]
mod tests {
    use super::super::kuhn_grid;
    use super::*;

    #[test]
    fn box_boundary_is_closed_and_outward() {
        let mesh = kuhn_grid(2, 3, 2, [1.0, 2.0, 3.0]).expect("a grid");
        let boundary = mesh.boundary();
        assert_eq!(boundary.faces.len(), 4 * (2 * 3 + 2 * 2 + 3 * 2));
        // Divergence theorem: the enclosed volume is a third of the sum of x·n dA.
        let mut volume = 0.0;
        let mut area = [0.0; 3];
        for face in &boundary.faces {
            let [a, b, c] = face.map(|n| mesh.node(n));
            let u: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
            let v: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
            let n: [f64; 3] = std::array::from_fn(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                0.5 * (u[j] * v[k] - u[k] * v[j])
            });
            for i in 0..3 {
                volume += a[i] * n[i] / 3.0;
                area[i] += n[i];
            }
        }
        assert!((volume - 6.0).abs() < 1e-12);
        assert!(area.iter().all(|a| a.abs() < 1e-12));
    }

    #[test]
    fn triangle_boundary_turns_around_the_material() {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mesh = SimplexMesh::<2>::new(nodes, vec![0, 1, 2, 0, 2, 3]).expect("a square");
        let area: f64 = mesh
            .boundary()
            .faces
            .iter()
            .map(|f| {
                let [a, b] = f.map(|n| mesh.node(n));
                0.5 * (a[0] * b[1] - a[1] * b[0])
            })
            .sum();
        assert!((area - 1.0).abs() < 1e-15);
    }

    #[test]
    fn two_islands_are_two_components() {
        let one = kuhn_grid(1, 1, 1, [1.0; 3]).expect("a grid");
        let shift = one.num_nodes() as u32;
        let mut nodes = one.nodes().to_vec();
        nodes.extend(one.nodes().iter().map(|x| [x[0] + 5.0, x[1], x[2]]));
        let mut connectivity = one.connectivity().to_vec();
        connectivity.extend(one.connectivity().iter().map(|n| n + shift));
        let two = SimplexMesh::<3>::new(nodes, connectivity).expect("two boxes");
        let (component, count) = two.components();
        assert_eq!(count, 2);
        assert_eq!((component[5], component[6]), (0, 1));
        assert_eq!(two.overlapping_faces(), 0);
    }

    #[test]
    fn node_lists_agree_with_the_elements() {
        let mesh = kuhn_grid(2, 2, 2, [1.0; 3]).expect("a grid");
        let around = mesh.node_elements();
        assert_eq!(around.len(), mesh.num_nodes());
        for n in 0..mesh.num_nodes() {
            let direct: Vec<u32> = (0..mesh.num_elements() as u32)
                .filter(|&e| mesh.element(e as usize).contains(&(n as u32)))
                .collect();
            assert_eq!(around.row(n), direct);
        }
        let neighbors = mesh.node_neighbors();
        assert_eq!(neighbors.row(13).len(), 14);
    }
}
