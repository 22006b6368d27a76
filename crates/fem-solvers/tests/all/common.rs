//! Matrices for the tests.
use fem_solvers::{BlockPattern, BlockSymmetric, Structure};
use std::sync::Arc;

/// Numbers in (−1, 1) that are the same everywhere (Knuth's MMIX generator).
pub struct Lcg(u64);

impl Lcg {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }
    pub fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn below(&mut self, n: usize) -> usize {
        ((self.next() + 1.0) * 0.5 * n as f64) as usize % n
    }
}

pub fn max_abs(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// A random graph with blocks `Σ_edges B Bᵀ` on it: positive definite, dense inside the blocks.
pub fn random_matrix<const D: usize>(seed: u64, blocks: usize, degree: usize) -> BlockSymmetric<D> {
    let mut rng = Lcg::new(seed);
    let pairs: Vec<(usize, usize)> = (0..blocks * degree)
        .map(|_| (rng.below(blocks), rng.below(blocks)))
        .filter(|(a, b)| a != b)
        .collect();
    let mut a = assemble::<D>(blocks, &pairs, &mut || rng.next());
    a.shift_diagonal(0.3);
    a.claiming(Structure::SymmetricPositiveDefinite)
}

/// A Kuhn grid of nodes with random positive semidefinite edge blocks plus 0.5 on the diagonal.
pub fn grid_matrix<const D: usize>(size: [usize; 3]) -> (BlockSymmetric<D>, Vec<[f64; 3]>) {
    let [nx, ny, nz] = size;
    let index = |x: usize, y: usize, z: usize| (z * ny + y) * nx + x;
    let mut points = Vec::new();
    let mut pairs = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                points.push([x as f64, y as f64, z as f64]);
                for (dx, dy, dz) in [
                    (1, 0, 0),
                    (0, 1, 0),
                    (0, 0, 1),
                    (1, 1, 0),
                    (1, 0, 1),
                    (0, 1, 1),
                    (1, 1, 1),
                ] {
                    if x + dx < nx && y + dy < ny && z + dz < nz {
                        pairs.push((index(x, y, z), index(x + dx, y + dy, z + dz)));
                    }
                }
            }
        }
    }
    let mut rng = Lcg::new(11);
    let mut a = assemble::<D>(points.len(), &pairs, &mut || rng.next());
    a.shift_diagonal(0.5);
    (a.claiming(Structure::SymmetricPositiveDefinite), points)
}

fn assemble<const D: usize>(
    blocks: usize,
    pairs: &[(usize, usize)],
    random: &mut dyn FnMut() -> f64,
) -> BlockSymmetric<D> {
    let pattern = Arc::new(BlockPattern::from_adjacency(blocks, pairs.iter().copied()).unwrap());
    let mut a = BlockSymmetric::<D>::zeros(pattern.clone());
    for &(i, j) in pairs {
        // [u; v] [u; v]ᵀ with random u, v
        let u: [f64; D] = std::array::from_fn(|_| random());
        let v: [f64; D] = std::array::from_fn(|_| random());
        let (low, high, u, v) = if i < j { (i, j, u, v) } else { (j, i, v, u) };
        let off = pattern.find(high, low).unwrap();
        for r in 0..D {
            for c in 0..D {
                a.values_mut()[pattern.diagonal(low)][r][c] += u[r] * u[c];
                a.values_mut()[pattern.diagonal(high)][r][c] += v[r] * v[c];
                a.values_mut()[off][r][c] += v[r] * u[c];
            }
        }
    }
    a
}
