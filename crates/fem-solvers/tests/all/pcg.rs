//! Conjugate gradients and their preconditioners.

use crate::common::{grid_matrix, max_abs, random_matrix};
use fem_solvers::{
    AssumedPositiveDefinite, BlockIc0, BlockJacobi, BlockPattern, BlockSymmetric, Identity,
    LinearOperator, PcgError, PcgParams, Preconditioner, PreconditionerError, Structure, pcg,
    pcg_semidefinite,
};
use std::sync::Arc;

pub(super) fn dense_product<const D: usize>(a: &BlockSymmetric<D>, x: &[f64]) -> Vec<f64> {
    let (n, dense) = (a.dim(), a.to_dense());
    (0..n)
        .map(|i| (0..n).map(|j| dense[i * n + j] * x[j]).sum())
        .collect()
}

#[test]
fn the_half_stored_product_is_the_dense_product() {
    for (seed, blocks, degree) in [(1, 1, 0), (2, 30, 3), (3, 200, 4)] {
        let a = random_matrix::<3>(seed, blocks, degree);
        let dense = a.to_dense();
        let n = a.dim();
        assert!((0..n).all(|i| (0..n).all(|j| dense[i * n + j] == dense[j * n + i])));
        let x: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
        let mut y = vec![f64::NAN; n];
        a.apply(&x, &mut y);
        for (p, q) in y.iter().zip(dense_product(&a, &x)) {
            assert!((p - q).abs() < 1e-12 * max_abs(&y));
        }
    }
}

#[test]
fn a_large_product_is_the_sum_of_columns_and_has_the_same_bits_on_any_number_of_threads() {
    a_large_product::<2>();
    a_large_product::<3>();
}

fn a_large_product<const D: usize>() {
    // Large enough for several chunks.
    let (a, _) = grid_matrix::<D>([16, 16, 32]);
    assert!(a.pattern().stored() > 3 * 16_384);
    let x: Vec<f64> = (0..a.dim()).map(|i| (0.37 * i as f64).sin()).collect();
    let apply = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut y = vec![0.0; a.dim()];
            a.apply(&x, &mut y);
            y
        })
    };
    let one = apply(1);
    assert_eq!(one, apply(2));
    // An independent sum over the stored blocks.
    let mut sum = vec![0.0; a.dim()];
    let p = a.pattern();
    for i in 0..p.blocks() {
        for k in p.row_start()[i]..p.row_start()[i + 1] {
            let j = p.columns()[k] as usize;
            for r in 0..D {
                for c in 0..D {
                    sum[D * i + r] += a.values()[k][r][c] * x[D * j + c];
                    if j != i {
                        sum[D * j + c] += a.values()[k][r][c] * x[D * i + r];
                    }
                }
            }
        }
    }
    assert!(one.iter().zip(&sum).all(|(p, q)| (p - q).abs() < 1e-12));
}

#[test]
fn every_preconditioner_reaches_the_dense_solution() {
    let a = random_matrix::<3>(5, 120, 3);
    let n = a.dim();
    let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let dense = nalgebra::DMatrix::from_row_slice(n, n, &a.to_dense());
    let expected = dense
        .cholesky()
        .unwrap()
        .solve(&nalgebra::DVector::from_row_slice(&b));
    let params = PcgParams {
        relative_tolerance: 1e-12,
        ..Default::default()
    };
    let mut iterations = Vec::new();
    let jacobi = BlockJacobi::new(&a).unwrap();
    let ic = BlockIc0::new(&a).unwrap();
    let list: [&dyn Preconditioner; 3] = [&Identity, &jacobi, &ic];
    for m in list {
        let mut x = vec![0.0; n];
        let info = pcg(&a, m, &b, &mut x, &params).unwrap();
        assert!(info.relative_residual <= 1e-12);
        for i in 0..n {
            assert!((x[i] - expected[i]).abs() < 1e-9 * expected.amax());
        }
        iterations.push(info.iterations);
    }
    assert!(
        iterations[0] > iterations[1] && iterations[1] > iterations[2],
        "{iterations:?}"
    );
}

#[test]
fn exact_in_as_many_iterations_as_there_are_distinct_eigenvalues() {
    // diag(1, 2, 5): three steps.
    let pattern = Arc::new(BlockPattern::from_adjacency(3, []).unwrap());
    let mut a = BlockSymmetric::<1>::zeros(pattern);
    a.values_mut().copy_from_slice(&[[[1.0]], [[2.0]], [[5.0]]]);
    let a = a.claiming(Structure::SymmetricPositiveDefinite);
    let mut x = [0.0; 3];
    let info = pcg(
        &a,
        &Identity,
        &[1.0, 1.0, 1.0],
        &mut x,
        &PcgParams::default(),
    )
    .unwrap();
    assert_eq!(info.iterations, 3);
    assert!((x[2] - 0.2).abs() < 1e-14);
}

#[test]
fn incomplete_factor_without_fill_to_drop_is_exact() {
    // A chain has no fill: one iteration.
    let pattern = Arc::new(BlockPattern::from_adjacency(50, (0..49).map(|i| (i, i + 1))).unwrap());
    let mut a = BlockSymmetric::<2>::zeros(pattern.clone());
    for i in 0..50 {
        let k = pattern.diagonal(i);
        a.values_mut()[k] = [[4.0, 0.5], [0.5, 3.0]];
        if i > 0 {
            a.values_mut()[k - 1] = [[-1.0, 0.2], [0.3, -0.9]];
        }
    }
    let a = a.claiming(Structure::SymmetricPositiveDefinite);
    let b = vec![1.0; 100];
    let ic = BlockIc0::new(&a).unwrap();
    assert_eq!(ic.shift(), 0.0);
    // Seven digits each: the factor is exact but for the rounding of f32.
    for (relative_tolerance, iterations) in [(1e-6, 1), (1e-13, 2)] {
        let params = PcgParams {
            relative_tolerance,
            ..PcgParams::default()
        };
        let mut x = vec![0.0; 100];
        let info = pcg(&a, &ic, &b, &mut x, &params).unwrap();
        assert_eq!(info.iterations, iterations);
    }
}

#[test]
fn incomplete_factor_shifts_when_it_breaks_down() {
    // Kershaw's matrix (1978): positive definite, IC(0) breaks down.
    let pattern =
        Arc::new(BlockPattern::from_adjacency(4, [(0, 1), (1, 2), (2, 3), (0, 3)]).unwrap());
    let mut a = BlockSymmetric::<1>::zeros(pattern.clone());
    a.shift_diagonal(3.0);
    for (i, j, v) in [(1, 0, -2.0), (2, 1, -2.0), (3, 2, -2.0), (3, 0, 2.0)] {
        let k = pattern.find(i, j).unwrap();
        a.values_mut()[k][0][0] = v;
    }
    let a = a.claiming(Structure::SymmetricPositiveDefinite);
    let ic = BlockIc0::new(&a).unwrap();
    assert!(ic.shift() > 0.0);
    let mut x = [0.0; 4];
    let info = pcg(
        &a,
        &ic,
        &[1.0, 2.0, 3.0, 4.0],
        &mut x,
        &PcgParams::default(),
    )
    .unwrap();
    // Four in exact arithmetic; what f32 rounds off takes as many again at most.
    assert!(info.iterations <= 8, "{}", info.iterations);
}

#[test]
fn preconditioners_refuse_what_cannot_be_definite() {
    let mut a = random_matrix::<2>(1, 10, 2);
    let k = a.pattern().diagonal(4);
    let good = a.values()[k];
    a.values_mut()[k] = [[1.0, 2.0], [2.0, 1.0]];
    let refused = PreconditionerError::NotPositiveDefinite { block: 4 };
    assert_eq!(BlockJacobi::new(&a).unwrap_err(), refused);
    assert_eq!(BlockIc0::new(&a).unwrap_err(), refused);
    a.values_mut()[k] = good;
    a.values_mut()[k][0][0] = f64::NAN;
    assert_eq!(
        BlockJacobi::new(&a).unwrap_err(),
        PreconditionerError::NonFinite { block: 4 }
    );
    assert_eq!(
        BlockIc0::new(&a).unwrap_err(),
        PreconditionerError::NonFinite { block: 4 }
    );
}

#[test]
fn an_operator_without_the_claim_is_refused() {
    let a = random_matrix::<1>(1, 5, 1).claiming(Structure::Symmetric);
    let mut x = [0.0; 5];
    let outcome = pcg(&a, &Identity, &[1.0; 5], &mut x, &PcgParams::default());
    assert!(matches!(outcome, Err(PcgError::Refused { .. })));
    assert!(
        pcg(
            &AssumedPositiveDefinite(&a),
            &Identity,
            &[1.0; 5],
            &mut x,
            &PcgParams::default()
        )
        .is_ok()
    );
    let general = a.claiming(Structure::General);
    let outcome = pcg(
        &AssumedPositiveDefinite(&general),
        &Identity,
        &[1.0; 5],
        &mut x,
        &PcgParams::default(),
    );
    assert!(matches!(outcome, Err(PcgError::Refused { .. })));
}

#[test]
fn negative_curvature_is_reported_with_its_direction() {
    let pattern = Arc::new(BlockPattern::from_adjacency(3, []).unwrap());
    let mut a = BlockSymmetric::<1>::zeros(pattern);
    a.values_mut()
        .copy_from_slice(&[[[1.0]], [[-2.0]], [[5.0]]]);
    let mut x = [0.0; 3];
    let op = AssumedPositiveDefinite(&a);
    match pcg(
        &op,
        &Identity,
        &[1.0, 1.0, 1.0],
        &mut x,
        &PcgParams::default(),
    ) {
        Err(PcgError::NegativeCurvature {
            curvature,
            direction,
            ..
        }) => {
            let mut ad = vec![0.0; 3];
            a.apply(&direction, &mut ad);
            let pap: f64 = direction.iter().zip(&ad).map(|(p, q)| p * q).sum();
            let pp: f64 = direction.iter().map(|p| p * p).sum();
            assert!(pap < 0.0 && (curvature - pap / pp).abs() < 1e-14);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn too_few_iterations_bad_numbers_and_bad_lengths_are_errors() {
    let a = random_matrix::<2>(3, 50, 3);
    let b = vec![1.0; 100];
    let mut x = vec![0.0; 100];
    let params = PcgParams {
        max_iterations: 3,
        ..Default::default()
    };
    match pcg(&a, &Identity, &b, &mut x, &params) {
        Err(PcgError::NotConverged {
            iterations: 3,
            relative_residual,
        }) => assert!(relative_residual < 1.0),
        other => panic!("{other:?}"),
    }
    let mut bad = b.clone();
    bad[7] = f64::NAN;
    assert!(matches!(
        pcg(&a, &Identity, &bad, &mut x, &params),
        Err(PcgError::NonFinite {
            iteration: 0,
            what: "the right-hand side",
            index: 7
        })
    ));
    assert!(matches!(
        pcg(&a, &Identity, &b[1..], &mut x, &params),
        Err(PcgError::Dimension { .. })
    ));
    let mut poisoned = a.clone();
    poisoned.values_mut()[5][0][0] = f64::NAN;
    x.fill(0.0);
    assert!(matches!(
        pcg(&poisoned, &Identity, &b, &mut x, &params),
        Err(PcgError::NonFinite { .. })
    ));
    // An unreachable tolerance ends in stagnation, not in a loop.
    x.fill(0.0);
    let params = PcgParams {
        relative_tolerance: 1e-30,
        stagnation_window: 20,
        ..Default::default()
    };
    let outcome = pcg(&a, &Identity, &b, &mut x, &params);
    assert!(
        matches!(outcome, Err(PcgError::Stagnated { .. }))
            || outcome.is_ok_and(|i| i.relative_residual <= 1e-30)
    );
    // Zero right-hand side, zero unknowns.
    x.fill(3.0);
    assert_eq!(
        pcg(&a, &Identity, &vec![0.0; 100], &mut x, &params)
            .unwrap()
            .iterations,
        0
    );
    assert!(x.iter().all(|&v| v == 0.0));
    let empty = random_matrix::<2>(3, 0, 0);
    assert_eq!(
        pcg(&empty, &Identity, &[], &mut [], &params)
            .unwrap()
            .iterations,
        0
    );
}

/// Neumann Laplacian of a chain, scaled, and one empty row.
fn neumann(n: usize) -> BlockSymmetric<1> {
    let pattern =
        Arc::new(BlockPattern::from_adjacency(n + 1, (1..n).map(|i| (i - 1, i))).unwrap());
    let mut a = BlockSymmetric::<1>::zeros(pattern.clone());
    for i in 1..n {
        let k = 10.0 + i as f64;
        let (d0, d1) = (pattern.diagonal(i - 1), pattern.diagonal(i));
        a.values_mut()[d0][0][0] += k;
        a.values_mut()[d1][0][0] += k;
        a.values_mut()[d1 - 1][0][0] -= k;
    }
    a.claiming(Structure::SymmetricPositiveSemidefinite)
}

#[test]
fn a_consistent_semidefinite_system_is_solved_and_an_inconsistent_one_refused() {
    let a = neumann(40);
    let n = a.dim();
    let exact: Vec<f64> = (0..n).map(|i| (0.2 * i as f64).sin()).collect();
    let mut b = vec![0.0; n];
    a.apply(&exact, &mut b);
    let mut x = vec![0.0; n];
    let params = PcgParams {
        relative_tolerance: 1e-12,
        ..Default::default()
    };
    let info = pcg_semidefinite(&a, &a.diagonal(), &b, &mut x, &params).unwrap();
    assert!(info.iterations <= 45);
    let mut ax = vec![0.0; n];
    a.apply(&x, &mut ax);
    assert!(ax.iter().zip(&b).all(|(p, q)| (p - q).abs() < 1e-10));
    // Equal up to a constant; the unknown of the empty row stays.
    let shift = x[0] - exact[0];
    assert!((0..n - 1).all(|i| (x[i] - exact[i] - shift).abs() < 1e-9));
    assert_eq!(x[n - 1], 0.0);

    b[3] += 1.0;
    let mut x = vec![0.0; n];
    assert!(matches!(
        pcg_semidefinite(&a, &a.diagonal(), &b, &mut x, &params),
        Err(PcgError::Inconsistent { .. }
            | PcgError::Stagnated { .. }
            | PcgError::NotConverged { .. })
    ));
    assert!(matches!(
        pcg(&a, &Identity, &b, &mut x, &params),
        Err(PcgError::Refused { .. })
    ));
    let mut row_without_diagonal = vec![0.0; n];
    row_without_diagonal[n - 1] = 1.0;
    let mut x = vec![0.0; n];
    assert!(matches!(
        pcg_semidefinite(&a, &a.diagonal(), &row_without_diagonal, &mut x, &params),
        Err(PcgError::Inconsistent { iteration: 0, .. })
    ));
}

#[test]
fn patterns_are_checked() {
    use fem_solvers::PatternError as E;
    assert!(matches!(
        BlockPattern::from_rows(vec![0, 1, 1], vec![0]),
        Err(E::MissingDiagonal { row: 1 })
    ));
    assert!(matches!(
        BlockPattern::from_rows(vec![0, 2], vec![0, 0]),
        Err(E::Column { row: 0, column: 0 })
    ));
    assert!(matches!(
        BlockPattern::from_rows(vec![0, 1, 3], vec![0, 1, 0]),
        Err(E::Column { row: 1, column: 0 })
    ));
    assert!(matches!(
        BlockPattern::from_rows(vec![0, 1, 2], vec![0, 2]),
        Err(E::Column { row: 1, column: 2 })
    ));
    assert!(matches!(
        BlockPattern::from_rows(vec![1, 1], vec![0]),
        Err(E::RowStart { index: 0, value: 1 })
    ));
    assert!(matches!(
        BlockPattern::from_rows(vec![0, 5], vec![0]),
        Err(E::RowStart { index: 1, value: 5 })
    ));
    assert!(matches!(
        BlockPattern::from_rows(vec![0, 1], vec![0, 1]),
        Err(E::RowStart { index: 1, value: 1 })
    ));
    assert!(matches!(
        BlockPattern::from_adjacency(3, [(0, 3)]),
        Err(E::OutOfRange {
            row: 0,
            column: 3,
            blocks: 3
        })
    ));
    let p = BlockPattern::from_adjacency(3, [(0, 2), (2, 0), (1, 1)]).unwrap();
    assert_eq!(
        (p.row_start(), p.columns()),
        (&[0, 1, 2, 4][..], &[0, 1, 0, 2][..])
    );
    assert_eq!(
        (p.find(2, 0), p.find(2, 1), p.diagonal(2)),
        (Some(2), None, 3)
    );
    assert_eq!(BlockPattern::from_rows(vec![], vec![]).unwrap().blocks(), 0);
}

#[test]
fn a_right_hand_side_of_any_size_is_solved_to_the_same_digits() {
    let a = random_matrix::<2>(3, 40, 3);
    let n = a.dim();
    let b: Vec<f64> = (0..n).map(|i| (1.3 * i as f64).sin()).collect();
    let solve = |b: &[f64]| {
        let mut x = vec![0.0; n];
        let params = PcgParams::default();
        let info = pcg(&a, &BlockJacobi::new(&a).unwrap(), b, &mut x, &params).unwrap();
        (x, info)
    };
    let (expected, plain) = solve(&b);
    for exponent in [-1000, -900, -548, -531, -300, 0, 300, 531, 1000] {
        let scale = (f64::from(exponent)).exp2();
        let scaled: Vec<f64> = b.iter().map(|b| b * scale).collect();
        let (x, info) = solve(&scaled);
        assert_eq!(info.iterations, plain.iterations, "2^{exponent}");
        for (x, e) in x.iter().zip(&expected) {
            assert!(
                (x / scale - e).abs() <= 1e-14 * max_abs(&expected),
                "2^{exponent}"
            );
        }
    }
    for scale in [1e-160, 1e-165, 1e-200, 1e300] {
        let scaled: Vec<f64> = b.iter().map(|b| b * scale).collect();
        let (x, info) = solve(&scaled);
        assert!(info.relative_residual > 0.0);
        for (x, e) in x.iter().zip(&expected) {
            assert!((x / scale - e).abs() <= 1e-12 * max_abs(&expected));
        }
    }
}

#[test]
fn without_a_load_a_semidefinite_system_keeps_the_null_space_of_its_first_guess() {
    let a = neumann(12);
    let n = a.dim();
    let mut x: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).cos()).collect();
    let start = x.clone();
    // In the scaled inner product the constant keeps its share.
    let d = a.diagonal();
    let mean = |x: &[f64]| {
        let weighted: f64 = (0..n - 1).map(|i| d[i] * x[i]).sum();
        weighted / d[..n - 1].iter().sum::<f64>()
    };
    let info = pcg_semidefinite(&a, &d, &vec![0.0; n], &mut x, &PcgParams::default()).unwrap();
    assert!(info.iterations > 0 && info.relative_residual <= 1e-10);
    assert!((0..n - 1).all(|i| (x[i] - mean(&start)).abs() < 1e-9));
    assert_eq!(x[n - 1], start[n - 1]);
    let constant = vec![3.0; n];
    let mut x = constant.clone();
    pcg_semidefinite(&a, &d, &vec![0.0; n], &mut x, &PcgParams::default()).unwrap();
    assert!(x.iter().all(|v| (v - 3.0).abs() < 1e-12));
}

/// `z = share · r` on even entries and `r` on odd ones.
struct Uneven(f64);

impl Preconditioner for Uneven {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for (i, (z, r)) in z.iter_mut().zip(r).enumerate() {
            *z = if i % 2 == 0 { self.0 * r } else { *r };
        }
    }
}

#[test]
fn a_preconditioner_that_is_not_positive_definite_is_named() {
    let a = random_matrix::<1>(9, 8, 2);
    let even: Vec<f64> = (0..8).map(|i| f64::from(1 - i % 2)).collect();
    for share in [-1.0, 0.0] {
        let mut x = vec![0.0; 8];
        let outcome = pcg(&a, &Uneven(share), &even, &mut x, &PcgParams::default());
        assert_eq!(outcome, Err(PcgError::Preconditioner { iteration: 0 }));
        assert!(x.iter().all(|&x| x == 0.0));
    }
    let mut x = vec![0.0; 8];
    let outcome = pcg(&a, &Uneven(f64::NAN), &even, &mut x, &PcgParams::default());
    assert!(matches!(outcome, Err(PcgError::NonFinite { .. })));
}

#[test]
fn tolerances_that_are_no_sizes_are_refused() {
    let a = random_matrix::<1>(9, 8, 2);
    for (relative, absolute) in [(-1.0, 0.0), (f64::NAN, 0.0), (0.0, -1e-9), (0.0, f64::NAN)] {
        let params = PcgParams {
            relative_tolerance: relative,
            absolute_tolerance: absolute,
            ..Default::default()
        };
        let outcome = pcg(&a, &Identity, &[1.0; 8], &mut [0.0; 8], &params);
        assert!(matches!(outcome, Err(PcgError::Tolerance { .. })));
    }
}
