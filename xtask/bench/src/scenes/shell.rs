//! An eighth of a thick sphere as tetrahedra: the three faces of a cube, drawn out along the radius.

use crate::failure::Failure;
use fem_assembly::mesh::SimplexMesh;
use std::collections::BTreeMap;

/// Corners of a cell's six tetrahedra: paths from its first corner to its last along the axes, in the
/// orders that turn left, and the others with two corners swapped.
const PATHS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [1, 0, 2],
    [2, 1, 0],
];

/// n × n cells on each of the three faces, n layers, x, y, z ≥ 0. Nodes lie on spheres.
///
/// # Errors
/// If `n` is zero.
pub fn octant(n: usize, inner: f64, outer: f64) -> Result<SimplexMesh<3>, Failure> {
    let mut numbers = BTreeMap::new();
    let mut nodes = Vec::new();
    // A node by its place on the surface of the cube [0, n]³, and its layer.
    let mut node = |at: [usize; 3], layer: usize| -> u32 {
        *numbers.entry((at, layer)).or_insert_with(|| {
            let radius = inner * (outer / inner).powf(layer as f64 / n as f64);
            // Angles in equal parts: cells of about the same size.
            let angle = |i: usize| (i as f64 / n as f64 * std::f64::consts::FRAC_PI_4).tan();
            let direction = at.map(angle);
            let length = workbench::numbers::norm(&direction);
            nodes.push(direction.map(|c| radius * c / length));
            (nodes.len() - 1) as u32
        })
    };
    let mut tets = Vec::new();
    for face in 0..3 {
        let (u, v) = ((face + 1) % 3, (face + 2) % 3);
        for cell in 0..n * n * n {
            let first = [cell % n, cell / n % n, cell / (n * n)];
            let mut corner = |c: [usize; 3]| {
                let mut at = [n; 3];
                at[u] = c[0];
                at[v] = c[1];
                node(at, c[2])
            };
            for (k, path) in PATHS.iter().enumerate() {
                let mut at = first;
                let mut tet = vec![corner(at)];
                for &axis in path {
                    at[axis] += 1;
                    tet.push(corner(at));
                }
                if k >= 3 {
                    tet.swap(2, 3);
                }
                tets.extend(tet);
            }
        }
    }
    Ok(SimplexMesh::new(nodes, tets)?)
}
