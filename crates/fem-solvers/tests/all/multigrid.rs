//! The multigrid preconditioner, against dense and direct solves.

use crate::common::{Lcg, grid_matrix, max_abs};
use fem_solvers::{
    BlockPattern, BlockSymmetric, CholeskyFactor, LevelScalar, LinearOperator,
    MatrixPreconditioner, Multigrid, MultigridParams, NearKernel, NearKernelError, PcgParams,
    Preconditioner, PreconditionerError, Structure, SymbolicCholesky, pcg,
};
use std::sync::Arc;

/// Free nodes of n × n × 4n cubes, six tetrahedra each, prescribed at one end; edges of the Kuhn grid.
pub(super) struct Bar {
    pub points: Vec<[f64; 3]>,
    pub matrix: BlockSymmetric<3>,
}

/// Springs that resist changes of length alone: between free ends their matrix takes the six rigid
/// motions to zero.
pub(super) fn bar(n: usize, prescribed_end: bool) -> Bar {
    let (nx, ny, nz) = (n + 1, n + 1, 4 * n + 1);
    let index = |x: usize, y: usize, z: usize| (z * ny + y) * nx + x;
    let below = if prescribed_end { nx * ny } else { 0 };
    let h = 1.0 / n as f64;
    let corners = [
        (1, 0, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 1, 0),
        (1, 0, 1),
        (0, 1, 1),
        (1, 1, 1),
    ];
    let (mut points, mut edges) = (Vec::new(), Vec::new());
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                points.push([x as f64 * h, y as f64 * h, z as f64 * h]);
                for (dx, dy, dz) in corners {
                    if x + dx < nx && y + dy < ny && z + dz < nz {
                        edges.push((index(x, y, z), index(x + dx, y + dy, z + dz)));
                    }
                }
            }
        }
    }
    let free = points.len() - below;
    let inside = edges.iter().filter(|(i, _)| *i >= below);
    let pairs = inside.map(|(i, j)| (i - below, j - below));
    let pattern = Arc::new(BlockPattern::from_adjacency(free, pairs).unwrap());
    let mut matrix = BlockSymmetric::<3>::zeros(pattern.clone());
    for (i, j) in edges {
        let d: [f64; 3] = std::array::from_fn(|k| points[j][k] - points[i][k]);
        let length2: f64 = d.iter().map(|v| v * v).sum();
        for r in 0..3 {
            for c in 0..3 {
                let k = d[r] * d[c] / length2;
                for node in [i, j] {
                    if node >= below {
                        matrix.values_mut()[pattern.diagonal(node - below)][r][c] += k;
                    }
                }
                if i >= below {
                    let off = pattern.find(j - below, i - below).unwrap();
                    matrix.values_mut()[off][r][c] -= k;
                }
            }
        }
    }
    points.drain(..below);
    let matrix = matrix.claiming(Structure::SymmetricPositiveDefinite);
    Bar { points, matrix }
}

pub(super) fn rigid(points: &[[f64; 3]]) -> NearKernel {
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

/// Small enough a bottom that there are several levels.
pub(super) fn params() -> MultigridParams {
    MultigridParams {
        coarsest: 20,
        ..MultigridParams::default()
    }
}

pub(super) fn made<T: LevelScalar>(bar: &Bar) -> Multigrid<3, 6, T> {
    let mut multigrid = Multigrid::new(rigid(&bar.points), params());
    multigrid.update(&bar.matrix).unwrap();
    multigrid
}

pub(super) fn load(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = Lcg::new(seed);
    (0..n).map(|_| rng.next()).collect()
}

fn to(relative_tolerance: f64) -> PcgParams {
    PcgParams {
        relative_tolerance,
        ..PcgParams::default()
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn conjugate_gradients_on_it_find_what_a_factor_finds() {
    let bar = bar(4, true);
    let b = load(bar.matrix.dim(), 3);
    let symbolic = Arc::new(SymbolicCholesky::new(bar.matrix.pattern()));
    let mut exact = b.clone();
    let factor = CholeskyFactor::<f64, 3>::factor(&symbolic, &bar.matrix).unwrap();
    factor.solve_in_place(&mut exact);
    let (single, double) = (made::<f32>(&bar), made::<f64>(&bar));
    assert!(single.info().unwrap().rows.len() > 2);
    for multigrid in [&single as &dyn Preconditioner, &double] {
        let mut x = vec![0.0; b.len()];
        pcg(&bar.matrix, multigrid, &b, &mut x, &to(1e-12)).unwrap();
        let off: Vec<f64> = x.iter().zip(&exact).map(|(x, e)| x - e).collect();
        assert!(max_abs(&off) < 1e-9 * max_abs(&exact));
    }
}

#[test]
fn iterations_hardly_grow_with_the_number_of_unknowns() {
    let counts: Vec<usize> = [4, 8, 16]
        .into_iter()
        .map(|n| {
            let bar = bar(n, true);
            // A load that pulls everything along the bar and across it.
            let b: Vec<f64> = bar.points.iter().flat_map(|_| [1.0, 0.0, 0.3]).collect();
            let mut x = vec![0.0; b.len()];
            let multigrid = made::<f32>(&bar);
            assert!(multigrid.info().unwrap().operator_complexity < 1.6);
            pcg(&bar.matrix, &multigrid, &b, &mut x, &to(1e-8))
                .unwrap()
                .iterations
        })
        .collect();
    // Block Jacobi alone takes hundreds, three times as many on the last as on the first.
    let near = |(found, expected): (&usize, usize)| found.abs_diff(expected) <= 1;
    assert!(counts.iter().zip([15, 17, 18]).all(near), "{counts:?}");
}

#[test]
fn it_is_symmetric_and_positive_definite() {
    let bar = bar(4, true);
    let multigrid = made::<f64>(&bar);
    let n = bar.matrix.dim();
    let (mut mx, mut my) = (vec![0.0; n], vec![0.0; n]);
    for seed in 0..5 {
        let (x, y) = (load(n, seed), load(n, 100 + seed));
        multigrid.apply(&x, &mut mx);
        multigrid.apply(&y, &mut my);
        let (xmy, ymx) = (dot(&x, &my), dot(&y, &mx));
        assert!(
            (xmy - ymx).abs() < 1e-12 * dot(&x, &mx).max(dot(&y, &my)),
            "{xmy} {ymx}"
        );
        assert!(dot(&x, &mx) > 0.0);
    }
}

/// For the energy of an error e, ‖e − M⁻¹Ae‖_A < ‖e‖_A, smooth errors and rough ones.
#[test]
fn one_cycle_takes_most_of_any_error() {
    let bar = bar(8, true);
    let multigrid = made::<f32>(&bar);
    let n = bar.matrix.dim();
    let smooth: Vec<f64> = bar
        .points
        .iter()
        .flat_map(|p| [p[2] * p[2], 0.0, -2.0 * p[2] * p[0]])
        .collect();
    for e in [smooth, load(n, 9)] {
        let (mut ae, mut m) = (vec![0.0; n], vec![0.0; n]);
        bar.matrix.apply(&e, &mut ae);
        multigrid.apply(&ae, &mut m);
        let left: Vec<f64> = e.iter().zip(&m).map(|(e, m)| e - m).collect();
        let mut al = vec![0.0; n];
        bar.matrix.apply(&left, &mut al);
        let ratio = (dot(&left, &al) / dot(&e, &ae)).sqrt();
        assert!(ratio < 0.6, "{ratio}");
    }
}

#[test]
fn the_bits_do_not_depend_on_the_threads() {
    let bar = bar(8, true);
    let r = load(bar.matrix.dim(), 1);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut z = vec![0.0; r.len()];
            made::<f32>(&bar).apply(&r, &mut z);
            z
        })
    };
    let one = run(1);
    assert!(max_abs(&one) > 0.0);
    assert!(run(2) == one && run(3) == one);
}

#[test]
fn an_update_is_a_new_one_where_the_aggregates_are_the_same() {
    let bar = bar(5, true);
    let mut multigrid = made::<f32>(&bar);
    let mut other = bar.matrix.clone();
    // Held a little more at one node: no coupling becomes the strongest by that.
    let k = other.pattern().diagonal(100);
    other.values_mut()[k][1][1] += 1e-3;
    let r = load(other.dim(), 1);
    let (mut before, mut updated, mut new) = (r.clone(), r.clone(), r.clone());
    multigrid.apply(&r, &mut before);
    multigrid.update(&other).unwrap();
    multigrid.apply(&r, &mut updated);
    let mut fresh = Multigrid::<3, 6>::new(rigid(&bar.points), params());
    fresh.update(&other).unwrap();
    fresh.apply(&r, &mut new);
    assert!(updated == new);
    assert!(updated != before);
}

#[test]
fn another_pattern_is_a_new_hierarchy() {
    let (small, large) = (bar(3, true), bar(4, true));
    let mut multigrid = made::<f32>(&small);
    assert!(multigrid.fits(&small.matrix) && !multigrid.fits(&large.matrix));
    assert!(matches!(
        multigrid.update(&large.matrix),
        Err(PreconditionerError::NearKernel(
            NearKernelError::Length { .. }
        ))
    ));
    multigrid.set_near_kernel(rigid(&large.points));
    multigrid.update(&large.matrix).unwrap();
    let r = load(large.matrix.dim(), 2);
    let (mut one, mut two) = (r.clone(), r.clone());
    multigrid.apply(&r, &mut one);
    made::<f32>(&large).apply(&r, &mut two);
    assert!(one == two);
}

#[test]
fn what_is_not_positive_definite_is_refused() {
    let free = bar(4, false);
    let mut multigrid = Multigrid::<3, 6>::new(rigid(&free.points), params());
    let refused = multigrid.update(&free.matrix);
    assert!(
        matches!(refused, Err(PreconditionerError::NegativeCurvature { .. })),
        "{refused:?}"
    );
    assert!(!multigrid.fits(&free.matrix) && multigrid.info().is_none());

    let prescribed = bar(4, true);
    // Only what moves as a whole is unstable: no block of the diagonal shows it.
    let mut pushed = prescribed.matrix.clone();
    for i in 0..pushed.pattern().blocks() {
        let k = pushed.pattern().diagonal(i);
        (0..3).for_each(|c| pushed.values_mut()[k][c][c] -= 0.05);
    }
    let refused = multigrid_of(&prescribed, &pushed);
    assert!(
        matches!(refused, Err(PreconditionerError::NegativeCurvature { .. })),
        "{refused:?}"
    );

    let mut flipped = prescribed.matrix.clone();
    let k = flipped.pattern().diagonal(7);
    flipped.values_mut()[k][1][1] *= -1.0;
    let refused = multigrid_of(&prescribed, &flipped);
    assert_eq!(
        refused,
        Err(PreconditionerError::NotPositiveDefinite { block: 7 })
    );

    for bad in [f64::NAN, f64::INFINITY] {
        let mut broken = prescribed.matrix.clone();
        let k = broken.pattern().row_start()[30];
        broken.values_mut()[k][0][2] = bad;
        let refused = multigrid_of(&prescribed, &broken);
        assert_eq!(refused, Err(PreconditionerError::NonFinite { block: 30 }));
    }
}

fn multigrid_of(bar: &Bar, matrix: &BlockSymmetric<3>) -> Result<(), PreconditionerError> {
    let mut multigrid = made::<f32>(bar);
    let refused = multigrid.update(matrix);
    assert!(!multigrid.fits(matrix));
    refused
}

#[test]
fn near_kernels_that_do_not_fit_are_named() {
    let bar = bar(2, true);
    let n = bar.matrix.dim();
    let refused = |vectors: Vec<Vec<f64>>| {
        let mut multigrid = Multigrid::<3, 6>::new(NearKernel::new(vectors), params());
        multigrid.update(&bar.matrix).unwrap_err()
    };
    let good = rigid(&bar.points).vectors().to_vec();
    let expected = |error: NearKernelError| PreconditionerError::NearKernel(error);
    let (found, wanted) = (
        refused(good[..3].to_vec()),
        NearKernelError::Count {
            found: 3,
            expected: 6,
        },
    );
    assert_eq!(found, expected(wanted));
    let mut short = good.clone();
    short[4].pop();
    let wanted = NearKernelError::Length {
        vector: 4,
        found: n - 1,
        expected: n,
    };
    assert_eq!(refused(short), expected(wanted));
    let mut bad = good;
    bad[5][8] = f64::NAN;
    let wanted = NearKernelError::NonFinite {
        vector: 5,
        index: 8,
    };
    assert_eq!(refused(bad), expected(wanted));
}

/// Units: a matrix times 1e-40 has no number in `f32`, and its cycle is 1e40 times as large.
#[test]
fn any_unit_will_do() {
    let bar = bar(4, true);
    let r = load(bar.matrix.dim(), 5);
    let mut plain = r.clone();
    made::<f32>(&bar).apply(&r, &mut plain);
    for exponent in [-130, 130] {
        let unit = 2.0_f64.powi(exponent);
        let mut matrix = bar.matrix.clone();
        let values = matrix.values_mut().as_flattened_mut().as_flattened_mut();
        values.iter_mut().for_each(|v| *v *= unit);
        let mut multigrid = made::<f32>(&bar);
        multigrid.update(&matrix).unwrap();
        let mut z = r.clone();
        multigrid.apply(&r, &mut z);
        let scaled = |z: &[f64]| z.iter().zip(&plain).all(|(z, p)| z * unit == *p);
        assert!(scaled(&z), "{exponent}");
        // The same where the first matrix that it sees has that unit.
        let mut fresh = Multigrid::<3, 6>::new(rigid(&bar.points), params());
        fresh.update(&matrix).unwrap();
        fresh.apply(&r, &mut z);
        assert!(scaled(&z), "{exponent}, new");
    }
}

/// Rows that couple to nothing, and separate parts.
#[test]
fn constants_serve_a_scalar_matrix_and_lone_rows_stay_alone() {
    let (matrix, _) = grid_matrix::<1>([9, 9, 9]);
    let pattern = matrix.pattern();
    let n = pattern.blocks();
    let rows = (0..n).flat_map(|i| pattern.row(i).iter().map(move |&j| (i, j as usize)));
    let wider = BlockPattern::from_adjacency(n + 2, rows).unwrap();
    let mut a = BlockSymmetric::<1>::zeros(wider.into());
    a.values_mut()[..pattern.stored()].copy_from_slice(matrix.values());
    let last = a.values().len();
    a.values_mut()[last - 2..].copy_from_slice(&[[[2.0]], [[4.0]]]);
    let a = a.claiming(Structure::SymmetricPositiveDefinite);
    let mut multigrid = Multigrid::<1, 1>::new(NearKernel::constants::<1>(n + 2), params());
    multigrid.update(&a).unwrap();
    let b = vec![1.0; n + 2];
    let mut x = vec![0.0; n + 2];
    pcg(&a, &multigrid, &b, &mut x, &to(1e-12)).unwrap();
    assert!((x[n] - 0.5).abs() < 1e-10 && (x[n + 1] - 0.25).abs() < 1e-10);
    let mut back = vec![0.0; n + 2];
    a.apply(&x, &mut back);
    assert!(back.iter().all(|v| (v - 1.0).abs() < 1e-10));
}
