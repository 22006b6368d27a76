//! A box filled with tetrahedra.

use super::error::MeshError;
use super::simplex::SimplexMesh;

/// The Kuhn (Freudenthal) triangulation of the box [0, size₀]×[0, size₁]×[0, size₂] (meters): nx·ny·nz
/// boxes of six tetrahedra each, all of positive volume.
///
/// Node i + (nx+1)(j + (ny+1)k) lies at (size₀ i/nx, size₁ j/ny, size₂ k/nz). Boxes come with i
/// fastest; in each box one tetrahedron per permutation p of the axes in the order 012, 021, 102,
/// 120, 201, 210: from the lowest corner one step along p₀, p₁, p₂, the last two nodes swapped for
/// odd permutations.
///
/// # Errors
/// [`MeshError::EmptyGrid`] and [`MeshError::TooManyNodes`].
pub fn kuhn_grid(
    nx: usize,
    ny: usize,
    nz: usize,
    size: [f64; 3],
) -> Result<SimplexMesh<3>, MeshError> {
    const EVEN_ODD: [([usize; 3], bool); 6] = [
        ([0, 1, 2], false),
        ([0, 2, 1], true),
        ([1, 0, 2], true),
        ([1, 2, 0], false),
        ([2, 0, 1], false),
        ([2, 1, 0], true),
    ];
    let counts = [nx, ny, nz];
    if counts.contains(&0) || !size.iter().all(|&s| s > 0.0 && s.is_finite()) {
        return Err(MeshError::EmptyGrid);
    }
    let total = counts
        .iter()
        .try_fold(1_usize, |product, &n| {
            product.checked_mul(n.checked_add(1)?)
        })
        .unwrap_or(usize::MAX);
    if total > u32::MAX as usize {
        return Err(MeshError::TooManyNodes(total));
    }
    let strides = [1, nx + 1, (nx + 1) * (ny + 1)];
    let mut nodes = Vec::with_capacity(total);
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let at = [i, j, k];
                nodes.push(std::array::from_fn(|a| {
                    size[a] * at[a] as f64 / counts[a] as f64
                }));
            }
        }
    }
    let mut connectivity = Vec::with_capacity(24 * nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let corner = i * strides[0] + j * strides[1] + k * strides[2];
                for (p, odd) in EVEN_ODD {
                    let a = corner + strides[p[0]];
                    let b = a + strides[p[1]];
                    let c = b + strides[p[2]];
                    let (b, c) = if odd { (c, b) } else { (b, c) };
                    connectivity.extend([corner, a, b, c].map(|n| n as u32));
                }
            }
        }
    }
    SimplexMesh::new(nodes, connectivity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_are_equal_and_positive() {
        let mesh = kuhn_grid(2, 3, 4, [1.0, 2.0, 3.0]).expect("a grid");
        assert_eq!(mesh.num_elements(), 6 * 24);
        assert_eq!(mesh.num_nodes(), 60);
        for e in 0..mesh.num_elements() {
            assert!((mesh.volume(e) - 6.0 / 144.0).abs() < 1e-15);
        }
        assert_eq!(mesh.tet(0), [0, 1, 4, 16]);
        assert_eq!(mesh.tet(1), [0, 1, 16, 13]);
        assert_eq!(mesh.node(59), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn empty_grids_are_refused() {
        assert_eq!(kuhn_grid(0, 1, 1, [1.0; 3]), Err(MeshError::EmptyGrid));
        assert_eq!(
            kuhn_grid(1, 1, 1, [1.0, f64::NAN, 1.0]),
            Err(MeshError::EmptyGrid)
        );
    }
}
