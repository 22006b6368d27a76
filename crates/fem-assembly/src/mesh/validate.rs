//! Making a mesh: every check an element needs before elasticity may use it.

use super::error::{Ids, MeshError};
use super::simplex::{SimplexMesh, edges};

/// What to do with elements of negative volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// Swap their last two nodes and report them.
    Repair,
    /// Refuse the mesh.
    Refuse,
}

/// What to do with nodes that belong to no element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orphans {
    /// Keep them and report them. Whoever solves on the mesh must hold them.
    Allow,
    /// Refuse the mesh.
    Refuse,
}

/// What was repaired or tolerated while a mesh was made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Elements whose last two nodes were swapped.
    pub inverted: Vec<u32>,
    /// Nodes that belong to no element.
    pub orphans: Vec<u32>,
}

/// |det D_m| at or below this share of the longest edge to the power D is a flat element: well
/// above the rounding of coordinates, far below any element a mesher leaves.
const FLAT: f64 = 1e-10;

impl<const D: usize> SimplexMesh<D> {
    /// A mesh from nodes (meters) and the node indices of its elements, D + 1 for each.
    ///
    /// # Errors
    /// Any [`MeshError`]; negative volumes and orphan nodes are refused. See
    /// [`SimplexMesh::with_repairs`] for the lenient form.
    pub fn new(nodes: Vec<[f64; D]>, connectivity: Vec<u32>) -> Result<Self, MeshError> {
        Self::with_repairs(nodes, connectivity, Orientation::Refuse, Orphans::Refuse)
            .map(|(mesh, _)| mesh)
    }

    /// A mesh from nodes (meters) and node indices; says what it repaired and tolerated.
    ///
    /// # Errors
    /// Any [`MeshError`]: what cannot be repaired, or was asked to be refused.
    pub fn with_repairs(
        nodes: Vec<[f64; D]>,
        mut connectivity: Vec<u32>,
        orientation: Orientation,
        orphans: Orphans,
    ) -> Result<(Self, Repairs), MeshError> {
        const { assert!(D == 2 || D == 3, "triangles and tetrahedra only") };
        check(&nodes, &connectivity)?;
        let each: Vec<&[u32]> = connectivity.chunks_exact(D + 1).collect();
        let negative = positions(&each, |t| edges(&nodes, t).determinant() < 0.0);
        let inverted: Vec<u32> = negative.map(|e| e as u32).collect();
        if orientation == Orientation::Refuse {
            let ids = Ids::of(inverted.iter().map(|&e| e as usize));
            refuse(ids, MeshError::NegativeVolume)?;
        }
        for &e in &inverted {
            let last = (e as usize + 1) * (D + 1) - 1;
            connectivity.swap(last - 1, last);
        }

        let mut used = vec![false; nodes.len()];
        for &n in &connectivity {
            used[n as usize] = true;
        }
        let unused: Vec<u32> = positions(&used, |&u| !u).map(|n| n as u32).collect();
        if orphans == Orphans::Refuse {
            let ids = Ids::of(unused.iter().map(|&n| n as usize));
            refuse(ids, MeshError::Orphan)?;
        }
        let mesh = Self {
            nodes,
            connectivity,
        };
        let repairs = Repairs {
            inverted,
            orphans: unused,
        };
        Ok((mesh, repairs))
    }
}

fn refuse(ids: Option<Ids>, error: fn(Ids) -> MeshError) -> Result<(), MeshError> {
    match ids {
        Some(ids) => Err(error(ids)),
        None => Ok(()),
    }
}

/// What can be wrong with nodes and elements whatever is asked to be repaired.
fn check<const D: usize>(nodes: &[[f64; D]], connectivity: &[u32]) -> Result<(), MeshError> {
    if connectivity.is_empty() {
        return Err(MeshError::Empty);
    }
    if !connectivity.len().is_multiple_of(D + 1) {
        return Err(MeshError::RaggedConnectivity {
            length: connectivity.len(),
            nodes_per_element: D + 1,
        });
    }
    if nodes.len() > u32::MAX as usize {
        return Err(MeshError::TooManyNodes(nodes.len()));
    }
    let not_finite = |x: &[f64; D]| !x.iter().all(|v| v.is_finite());
    refuse(Ids::of(positions(nodes, not_finite)), MeshError::NotFinite)?;

    let each: Vec<&[u32]> = connectivity.chunks_exact(D + 1).collect();
    let beyond = |t: &&[u32]| t.iter().any(|&n| n as usize >= nodes.len());
    if let Some(ids) = Ids::of(positions(&each, beyond)) {
        return Err(MeshError::IndexOutOfRange {
            ids,
            nodes: nodes.len(),
        });
    }
    let repeated = |t: &&[u32]| (1..=D).any(|k| t[..k].contains(&t[k]));
    refuse(Ids::of(positions(&each, repeated)), MeshError::RepeatedNode)?;
    refuse(Ids::of(duplicates(&each)), MeshError::Duplicate)?;
    refuse(
        Ids::of(positions(&each, |t| is_flat(nodes, t))),
        MeshError::ZeroVolume,
    )?;
    Ok(())
}

fn positions<'a, T>(
    items: &'a [T],
    test: impl Fn(&T) -> bool + 'a,
) -> impl Iterator<Item = usize> + 'a {
    items
        .iter()
        .enumerate()
        .filter_map(move |(k, item)| test(item).then_some(k))
}

/// Written so that a NaN or an overflowing determinant counts as flat.
fn is_flat<const D: usize>(nodes: &[[f64; D]], element: &[u32]) -> bool {
    let mut longest = 0.0_f64;
    for (k, &a) in element.iter().enumerate() {
        for &b in &element[..k] {
            let (a, b) = (nodes[a as usize], nodes[b as usize]);
            let square: f64 = (0..D).map(|i| (a[i] - b[i]).powi(2)).sum();
            longest = longest.max(square.sqrt());
        }
    }
    let det = edges(nodes, element).determinant().abs();
    !(det > FLAT * longest.powi(D as i32) && det.is_finite())
}

/// Elements with the same nodes as an earlier one, ascending.
fn duplicates(elements: &[&[u32]]) -> Vec<usize> {
    let mut keys: Vec<([u32; 4], usize)> = elements
        .iter()
        .enumerate()
        .map(|(e, t)| {
            let mut key = [u32::MAX; 4];
            key[..t.len()].copy_from_slice(t);
            key.sort_unstable();
            (key, e)
        })
        .collect();
    keys.sort_unstable();
    let mut later: Vec<usize> = keys
        .windows(2)
        .filter_map(|w| (w[0].0 == w[1].0).then_some(w[1].1))
        .collect();
    later.sort_unstable();
    later
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 5] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
    ];

    fn ids(first: &[usize]) -> Ids {
        Ids::of(first.iter().copied()).expect("not empty")
    }
    fn refused(nodes: &[[f64; 3]], connectivity: &[u32]) -> MeshError {
        SimplexMesh::<3>::new(nodes.to_vec(), connectivity.to_vec()).expect_err("must be refused")
    }

    #[test]
    fn each_defect_has_its_own_error() {
        let nodes = &CORNERS[..4];
        assert_eq!(refused(nodes, &[]), MeshError::Empty);
        assert!(matches!(
            refused(nodes, &[0, 1, 2]),
            MeshError::RaggedConnectivity { length: 3, .. }
        ));
        assert_eq!(
            refused(nodes, &[0, 1, 2, 4]),
            MeshError::IndexOutOfRange {
                ids: ids(&[0]),
                nodes: 4
            }
        );
        assert_eq!(
            refused(nodes, &[0, 1, 2, 2]),
            MeshError::RepeatedNode(ids(&[0]))
        );
        assert_eq!(
            refused(nodes, &[0, 1, 2, 3, 0, 2, 3, 1]),
            MeshError::Duplicate(ids(&[1]))
        );
        assert_eq!(
            refused(nodes, &[0, 2, 1, 3]),
            MeshError::NegativeVolume(ids(&[0]))
        );
        assert_eq!(
            refused(&CORNERS, &[0, 1, 2, 3]),
            MeshError::Orphan(ids(&[4]))
        );
        for bad in [f64::NAN, f64::INFINITY] {
            let mut broken = CORNERS;
            broken[2][1] = bad;
            assert_eq!(
                refused(&broken[..4], &[0, 1, 2, 3]),
                MeshError::NotFinite(ids(&[2]))
            );
        }
        let flat = [CORNERS[0], CORNERS[1], CORNERS[2], [0.3, 0.3, 1e-14]];
        assert_eq!(
            refused(&flat, &[0, 1, 2, 3]),
            MeshError::ZeroVolume(ids(&[0]))
        );
    }

    #[test]
    fn flatness_is_relative_to_size() {
        let tiny: Vec<_> = CORNERS[..4].iter().map(|x| x.map(|v| v * 1e-9)).collect();
        let mesh = SimplexMesh::<3>::new(tiny, vec![0, 1, 2, 3]).expect("small but well shaped");
        assert!((mesh.volume(0) * 6e27 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn repairs_are_reported() {
        let (mesh, repairs) = SimplexMesh::<3>::with_repairs(
            CORNERS.to_vec(),
            vec![0, 2, 1, 3],
            Orientation::Repair,
            Orphans::Allow,
        )
        .expect("repairable");
        assert_eq!(mesh.tet(0), [0, 2, 3, 1]);
        assert_eq!(mesh.volume(0), 1.0 / 6.0);
        assert_eq!((repairs.inverted, repairs.orphans), (vec![0], vec![4]));
    }

    #[test]
    fn triangles_work_too() {
        let mesh = SimplexMesh::<2>::new(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], vec![0, 1, 2])
            .expect("a triangle");
        assert_eq!(mesh.volume(0), 0.5);
    }

    #[test]
    fn messages_list_the_first_ids_and_the_count() {
        let text = MeshError::ZeroVolume(Ids::of(0..20).expect("not empty")).to_string();
        assert!(
            text.contains("20 of them: 0, 1, 2, 3, 4, 5, 6, 7, …"),
            "{text}"
        );
        assert!(text.contains("remesh"), "{text}");
    }
}
