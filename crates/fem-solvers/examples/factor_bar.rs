//! Cholesky of a vector Laplacian on a bar of n × n × 4n cubes, six tetrahedra each, both ends held.
//!
//! `cargo run --release --example factor_bar -- 8 16 24` prints ordering, fill, and factor and solve
//! times with one and two threads, and those of conjugate gradients on a multigrid hierarchy, for one
//! right-hand side and for several together.

use fem_solvers::{
    AssumedPositiveDefinite, BlockPattern, BlockSymmetric, CholeskyFactor, LinearOperator,
    MatrixPreconditioner, Multigrid, MultigridParams, NearKernel, PcgParams, RefineParams,
    SolveManyParams, SymbolicCholesky, pcg,
};
use std::sync::Arc;
use std::time::Instant;

/// Free nodes of the bar and the edges of the Kuhn triangulation of every cube.
fn bar(n: usize) -> (Vec<[f64; 3]>, Vec<(usize, usize)>) {
    let (nx, ny, nz) = (n + 1, n + 1, 4 * n + 1);
    // The ends z = 0 and z = 4n are held: not unknowns.
    let index =
        |x: usize, y: usize, z: usize| (z > 0 && z < nz - 1).then(|| ((z - 1) * ny + y) * nx + x);
    let mut points = Vec::new();
    let mut edges = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let Some(a) = index(x, y, z) else { continue };
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
                    let (x, y, z) = (x + dx, y + dy, z + dz);
                    if x < nx
                        && y < ny
                        && z < nz
                        && let Some(b) = index(x, y, z)
                    {
                        edges.push((a, b));
                    }
                }
            }
        }
    }
    (points, edges)
}

/// Springs along every edge plus a little isotropic stiffness.
fn matrix(points: &[[f64; 3]], edges: &[(usize, usize)]) -> BlockSymmetric<3> {
    let pattern = Arc::new(
        BlockPattern::from_adjacency(points.len(), edges.iter().copied()).expect("a valid pattern"),
    );
    let mut a = BlockSymmetric::<3>::zeros(pattern.clone());
    a.shift_diagonal(0.05);
    for &(i, j) in edges {
        let d: Vec<f64> = (0..3).map(|k| points[j][k] - points[i][k]).collect();
        let length2: f64 = d.iter().map(|v| v * v).sum();
        for r in 0..3 {
            for c in 0..3 {
                let k = d[r] * d[c] / length2 + if r == c { 0.3 } else { 0.0 };
                a.values_mut()[pattern.diagonal(i)][r][c] += k;
                a.values_mut()[pattern.diagonal(j)][r][c] += k;
                let off = pattern
                    .find(i.max(j), i.min(j))
                    .expect("an edge of the pattern");
                a.values_mut()[off][r][c] -= k;
            }
        }
    }
    a
}

/// Translations and rotations.
fn rigid(points: &[[f64; 3]]) -> NearKernel {
    let mut vectors = vec![Vec::new(); 6];
    for p in points {
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let (mut along, mut around) = ([0.0; 3], [0.0; 3]);
            along[a] = 1.0;
            (around[b], around[c]) = (-p[c], p[b]);
            vectors[a].extend(along);
            vectors[3 + a].extend(around);
        }
    }
    NearKernel::new(vectors)
}

/// Conjugate gradients on a hierarchy, to 1e-10.
fn multigrid(
    a: &BlockSymmetric<3>,
    points: &[[f64; 3]],
    rhs: &[f64],
    repeats: usize,
    threads: usize,
) {
    let mut multigrid = Multigrid::<3, 6>::new(rigid(points), MultigridParams::default());
    let (made, build) = seconds(|| multigrid.update(a));
    made.expect("positive definite");
    let renewal = best(repeats, || multigrid.update(a).expect("positive definite"));
    let mut x = vec![0.0; rhs.len()];
    let mut iterations = 0;
    let op = AssumedPositiveDefinite(a);
    let solve = best(repeats, || {
        x.fill(0.0);
        let info = pcg(&op, &multigrid, rhs, &mut x, &PcgParams::default());
        iterations = info.map_or(0, |info| info.iterations);
    });
    let info = multigrid.info().expect("just made");
    println!(
        "  {threads} thread(s): multigrid {:?} rows, complexity {:.2}: made in {:.2} ms, renewed in {:.2} ms, {iterations} iterations in {:.2} ms",
        info.rows,
        info.operator_complexity,
        1e3 * build,
        1e3 * renewal,
        1e3 * solve
    );
    let params = SolveManyParams::default();
    for count in [1, 8, 40] {
        let columns = rhs.iter().enumerate().map(|(i, v)| v + (i % 7) as f64);
        let block: Vec<f64> = columns.cycle().take(count * a.dim()).collect();
        let (mut x, mut iterations) = (block.clone(), 0);
        let solve = best(repeats, || {
            x.copy_from_slice(&block);
            let info = multigrid.solve_many(a, &mut x, count, &params);
            iterations = info.map_or(0, |info| info.iterations);
        });
        println!(
            "    {count} columns: {iterations} iterations in {:.2} ms",
            1e3 * solve
        );
    }
}

fn seconds<R>(f: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = f();
    (result, start.elapsed().as_secs_f64())
}

fn best<R>(repeats: usize, mut f: impl FnMut() -> R) -> f64 {
    (0..repeats)
        .map(|_| seconds(&mut f).1)
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let sizes: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse().ok())
        .collect();
    let sizes = if sizes.is_empty() { vec![8, 16] } else { sizes };
    for n in sizes {
        let (points, edges) = bar(n);
        let a = matrix(&points, &edges);
        let repeats = if n <= 12 { 7 } else { 3 };
        println!(
            "\nn = {n}: {} unknowns, {} stored blocks",
            a.dim(),
            a.pattern().stored()
        );
        let (graph_based, t) = seconds(|| SymbolicCholesky::<3>::new(a.pattern()));
        println!(
            "  levels of the graph: {:7.1} ms, fill {:6.2} M, {:7.2} GF, {} fronts",
            1e3 * t,
            graph_based.fill() as f64 / 1e6,
            graph_based.flops() / 1e9,
            graph_based.fronts()
        );
        let (symbolic, t) = seconds(|| {
            Arc::new(SymbolicCholesky::<3>::with_coordinates(
                a.pattern(),
                &points,
            ))
        });
        println!(
            "  planes             : {:7.1} ms, fill {:6.2} M, {:7.2} GF, {} fronts",
            1e3 * t,
            symbolic.fill() as f64 / 1e6,
            symbolic.flops() / 1e9,
            symbolic.fronts()
        );
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a thread pool");
            pool.install(|| {
                let mut factor = CholeskyFactor::<f64, 3>::factor(&symbolic, &a).expect("positive definite");
                let t64 = best(repeats, || factor.refactor(&a).expect("positive definite"));
                let rhs: Vec<f64> = (0..a.dim()).map(|i| (i as f64 * 0.7).sin()).collect();
                let mut x = rhs.clone();
                let t1 = best(repeats, || {
                    x.copy_from_slice(&rhs);
                    factor.solve_in_place(&mut x);
                });
                let mut y = vec![0.0; a.dim()];
                a.apply(&x, &mut y);
                let residual = y.iter().zip(&rhs).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max);
                let mut many: Vec<f64> = rhs.iter().copied().cycle().take(40 * a.dim()).collect();
                let t40 = best(repeats, || factor.solve_many(&mut many, 40));
                drop(factor);
                let mut small = CholeskyFactor::<f32, 3>::factor(&symbolic, &a).expect("positive definite");
                let t32 = best(repeats, || small.refactor(&a).expect("positive definite"));
                let mut info = None;
                let refine = best(repeats, || {
                    info = small.solve_refined(&a, &rhs, &mut x, &RefineParams { relative_tolerance: 1e-10, ..Default::default() }).ok();
                });
                multigrid(&a, &points, &rhs, repeats, threads);
                let spmv = best(20, || a.apply(&x, &mut y));
                println!("  {threads} thread(s): f64 factor {:8.2} ms ({:5.1} GF/s), solve {:6.2} ms, 40 columns {:7.2} ms, residual {residual:.1e}", 1e3 * t64, symbolic.flops() / t64 / 1e9, 1e3 * t1, 1e3 * t40);
                println!("               f32 factor {:8.2} ms, refined solve {:6.2} ms in {:?} iterations; A x {:.3} ms", 1e3 * t32, 1e3 * refine, info.map(|i| i.iterations), 1e3 * spmv);
            });
        }
    }
}
