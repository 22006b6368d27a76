//! A vector Laplacian on a cube, factored and iterated on: `cargo bench -p fem-solvers`.

use criterion::{Criterion, criterion_group, criterion_main};
use fem_solvers::{
    BlockJacobi, BlockPattern, BlockSymmetric, CholeskyFactor, PcgParams, Structure,
    SymbolicCholesky, pcg,
};
use std::sync::Arc;

/// Points of a cube of n³, coupled along the axes.
fn cube(n: usize) -> (Vec<[f64; 3]>, BlockSymmetric<3>) {
    let index = |x: usize, y: usize, z: usize| (z * n + y) * n + x;
    let (mut points, mut edges) = (Vec::new(), Vec::new());
    for (z, y, x) in (0..n * n * n).map(|i| (i / (n * n), i / n % n, i % n)) {
        points.push([x as f64, y as f64, z as f64]);
        for (dx, dy, dz) in [(1, 0, 0), (0, 1, 0), (0, 0, 1)] {
            if x + dx < n && y + dy < n && z + dz < n {
                edges.push((index(x, y, z), index(x + dx, y + dy, z + dz)));
            }
        }
    }
    let pattern = BlockPattern::from_adjacency(points.len(), edges.iter().copied());
    let pattern = Arc::new(pattern.expect("a valid pattern"));
    let mut a = BlockSymmetric::<3>::zeros(pattern.clone());
    a.shift_diagonal(0.1);
    for (i, j) in edges {
        let off = pattern.find(j, i).expect("an edge of the pattern");
        for k in 0..3 {
            a.values_mut()[pattern.diagonal(i)][k][k] += 1.0;
            a.values_mut()[pattern.diagonal(j)][k][k] += 1.0;
            a.values_mut()[off][k][k] -= 1.0;
        }
    }
    // A Laplacian plus a tenth.
    (points, a.claiming(Structure::SymmetricPositiveDefinite))
}

fn systems(criterion: &mut Criterion) {
    let (points, a) = cube(16);
    let symbolic = SymbolicCholesky::with_coordinates(a.pattern(), &points);
    let symbolic = Arc::new(symbolic);
    let b = vec![1.0; 3 * points.len()];
    let mut group = criterion.benchmark_group("cube of 16");
    group.sample_size(10);
    group.bench_function("factor", |bench| {
        bench.iter(|| CholeskyFactor::<f64, 3>::factor(&symbolic, &a).expect("definite"));
    });
    let factor = CholeskyFactor::<f64, 3>::factor(&symbolic, &a).expect("definite");
    group.bench_function("solve", |bench| {
        bench.iter(|| {
            let mut x = b.clone();
            factor.solve_in_place(&mut x);
            x
        });
    });
    let jacobi = BlockJacobi::new(&a).expect("definite");
    group.bench_function("conjugate gradients", |bench| {
        bench.iter(|| {
            let mut x = vec![0.0; b.len()];
            pcg(&a, &jacobi, &b, &mut x, &PcgParams::default()).expect("converges");
            x
        });
    });
    group.finish();
}

criterion_group!(benches, systems);
criterion_main!(benches);
