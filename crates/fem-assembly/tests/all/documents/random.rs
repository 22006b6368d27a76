//! Points, and triangles to put them in.

use fem_assembly::mesh::SimplexMesh;

/// A linear congruential generator (Knuth's MMIX constants).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [−1, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn point<const D: usize>(&mut self) -> [f64; D] {
        core::array::from_fn(|_| self.unit())
    }
    pub fn near<const D: usize>(&mut self, p: &[f64; D], by: f64) -> [f64; D] {
        p.map(|c| c + by * self.unit())
    }
}

/// The unit square in nx × ny cells of two triangles.
pub struct Triangles {
    nx: usize,
    ny: usize,
}

impl Triangles {
    pub fn new(nx: usize, ny: usize) -> Self {
        Self { nx, ny }
    }
    pub fn mesh(&self) -> SimplexMesh<2> {
        let (nx, ny) = (self.nx, self.ny);
        let nodes = (0..=ny)
            .flat_map(|j| (0..=nx).map(move |i| [i as f64 / nx as f64, j as f64 / ny as f64]))
            .collect();
        let at = |i: usize, j: usize| (i + (nx + 1) * j) as u32;
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let triangles = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                // Diagonals alternate: no direction is preferred.
                if (i + j) % 2 == 0 {
                    [a, b, c, a, c, d]
                } else {
                    [a, b, d, b, c, d]
                }
            })
            .collect();
        SimplexMesh::new(nodes, triangles).unwrap()
    }
}
