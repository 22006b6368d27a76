//! Patches of elements that share one volume ratio.

use crate::mesh::SimplexMesh;

/// Which elements share one volume ratio: lists of elements with the share of each one's volume that
/// is counted there.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumePatches(Vec<Vec<(usize, f64)>>);

/// Elements that a patch cut out of the rest of an edge's star must have at least.
const SMALLEST_REMNANT: usize = 3;
const NOBODY: usize = usize::MAX;

impl VolumePatches {
    /// Disjoint stars of edges, longest edges first: about six tetrahedra or two triangles to a patch,
    /// the cells of a grid cut into six around their diagonals among them. What is left between them
    /// joins a neighbor. One volume for about each node of the mesh: enough for incompressible flesh,
    /// few enough not to lock.
    pub fn around_edges<const D: usize>(mesh: &SimplexMesh<D>) -> Self {
        let stars = stars(mesh);
        let mut owner = vec![NOBODY; mesh.num_elements()];
        let mut patches: Vec<Vec<usize>> = Vec::new();
        for whole in [true, false] {
            for star in &stars {
                let left = || star.iter().copied().filter(|&e| owner[e] == NOBODY);
                let count = left().count();
                let enough = if whole { star.len() } else { SMALLEST_REMNANT };
                if count >= enough && count > 1 {
                    let patch: Vec<usize> = left().collect();
                    patch.iter().for_each(|&e| owner[e] = patches.len());
                    patches.push(patch);
                }
            }
        }
        join_the_rest(mesh, &mut owner, &mut patches);
        Self::disjoint(patches)
    }

    /// The elements around each node, each with a share of 1/(D + 1): the nodal averages of Bonet and
    /// Burton (1998). Every node is coupled to the neighbors of its neighbors.
    pub fn around_nodes<const D: usize>(mesh: &SimplexMesh<D>) -> Self {
        let mut patches = vec![Vec::new(); mesh.num_nodes()];
        for (e, corners) in mesh.elements().enumerate() {
            for &n in corners {
                patches[n as usize].push((e, 1.0 / corners.len() as f64));
            }
        }
        patches.retain(|patch| !patch.is_empty());
        Self(patches)
    }

    /// Patches of your own: the elements of each.
    pub fn disjoint(patches: Vec<Vec<usize>>) -> Self {
        let whole = |patch: Vec<usize>| patch.into_iter().map(|e| (e, 1.0)).collect();
        Self(patches.into_iter().map(whole).collect())
    }

    /// Only the elements that are wanted; patches without any are dropped.
    #[must_use]
    pub fn restricted_to(&self, wanted: impl Fn(usize) -> bool) -> Self {
        let keep = |patch: &Vec<(usize, f64)>| -> Vec<(usize, f64)> {
            patch.iter().copied().filter(|(e, _)| wanted(*e)).collect()
        };
        let patches = self.0.iter().map(keep).filter(|patch| !patch.is_empty());
        Self(patches.collect())
    }

    /// Elements and shares of each patch.
    pub fn lists(&self) -> &[Vec<(usize, f64)>] {
        &self.0
    }
}

/// The elements around each edge, longest edges first, then by nodes.
fn stars<const D: usize>(mesh: &SimplexMesh<D>) -> Vec<Vec<usize>> {
    let mut uses: Vec<([u32; 2], usize)> = Vec::new();
    for (e, corners) in mesh.elements().enumerate() {
        for (a, &m) in corners.iter().enumerate() {
            uses.extend(corners[..a].iter().map(|&n| ([m.min(n), m.max(n)], e)));
        }
    }
    uses.sort_unstable();
    let mut stars: Vec<(f64, [u32; 2], Vec<usize>)> = uses
        .chunk_by(|a, b| a.0 == b.0)
        .map(|star| {
            let edge = star[0].0;
            let (x, y) = (mesh.node(edge[0]), mesh.node(edge[1]));
            let square: f64 = (0..D).map(|i| (x[i] - y[i]).powi(2)).sum();
            (square, edge, star.iter().map(|&(_, e)| e).collect())
        })
        .collect();
    stars.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    stars.into_iter().map(|(_, _, star)| star).collect()
}

/// Gives every element without a patch to the smallest patch across one of its faces, and one that
/// has no neighbor a patch of its own.
fn join_the_rest<const D: usize>(
    mesh: &SimplexMesh<D>,
    owner: &mut [usize],
    patches: &mut Vec<Vec<usize>>,
) {
    let mut faces: Vec<(Vec<u32>, usize)> = Vec::new();
    for (e, corners) in mesh.elements().enumerate() {
        for out in 0..=D {
            let mut face: Vec<u32> = (0..=D).filter(|&a| a != out).map(|a| corners[a]).collect();
            face.sort_unstable();
            faces.push((face, e));
        }
    }
    faces.sort_unstable();
    let mut neighbors = vec![Vec::new(); owner.len()];
    for pair in faces.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b)] = pair {
            neighbors[*a].push(*b);
            neighbors[*b].push(*a);
        }
    }
    loop {
        let mut changed = false;
        for e in 0..owner.len() {
            if owner[e] != NOBODY {
                continue;
            }
            let across = neighbors[e].iter().map(|&n| owner[n]);
            let smallest = across
                .filter(|&p| p != NOBODY)
                .min_by_key(|&p| (patches[p].len(), p));
            if let Some(patch) = smallest {
                owner[e] = patch;
                patches[patch].push(e);
                changed = true;
            }
        }
        if changed {
            continue;
        }
        match owner.iter().position(|&p| p == NOBODY) {
            Some(e) => {
                owner[e] = patches.len();
                patches.push(vec![e]);
            }
            None => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::kuhn_grid;

    #[test]
    fn every_element_is_in_one_patch_and_cells_are_found_again() {
        let mesh = kuhn_grid(3, 4, 2, [1.0, 1.3, 0.7]).unwrap();
        let patches = VolumePatches::around_edges(&mesh);
        assert_eq!(patches.lists().len(), 24);
        for patch in patches.lists() {
            let mut elements: Vec<usize> = patch.iter().map(|m| m.0).collect();
            elements.sort_unstable();
            let first = elements[0];
            assert_eq!(first % 6, 0);
            assert_eq!(elements, (first..first + 6).collect::<Vec<_>>());
        }
        let bent = mesh.nodes().iter().map(|&[x, y, z]| {
            let s = 0.03 * (9.0 * x + 7.0 * y + 5.0 * z).sin();
            [x + s, y - s, z + 0.5 * s]
        });
        let bent = SimplexMesh::new(bent.collect(), mesh.connectivity().to_vec()).unwrap();
        let patches = VolumePatches::around_edges(&bent);
        let mut all: Vec<usize> = patches.lists().iter().flatten().map(|m| m.0).collect();
        all.sort_unstable();
        assert_eq!(all, (0..144).collect::<Vec<_>>());
        assert!((18..40).contains(&patches.lists().len()));
        let half = patches.restricted_to(|e| e < 72);
        let kept: usize = half.lists().iter().map(Vec::len).sum();
        assert_eq!(kept, 72);
    }

    #[test]
    fn shares_around_nodes_make_up_every_element() {
        let mesh = kuhn_grid(2, 1, 1, [1.0; 3]).unwrap();
        let patches = VolumePatches::around_nodes(&mesh);
        let mut sums = vec![0.0; 12];
        for &(e, share) in patches.lists().iter().flatten() {
            sums[e] += share;
        }
        assert_eq!(sums, vec![1.0; 12]);
    }
}
