//! The sparse factorization against dense solves.

use crate::common::{Lcg, grid_matrix, max_abs, random_matrix};
use fem_solvers::{
    BlockPattern, BlockSymmetric, CholeskyError, CholeskyFactor, LinearOperator, RefineParams,
    SymbolicCholesky,
};
use std::sync::Arc;

fn residual<const D: usize>(a: &BlockSymmetric<D>, x: &[f64], b: &[f64]) -> f64 {
    let mut ax = vec![0.0; x.len()];
    a.apply(x, &mut ax);
    ax.iter()
        .zip(b)
        .fold(0.0, |m: f64, (p, q)| m.max((p - q).abs()))
}

#[test]
fn rows_that_are_not_there_are_refused() {
    for pair in [(3, 0), (0, 3), (3, 3)] {
        assert!(
            BlockPattern::from_adjacency(3, [(2, 0), pair]).is_err(),
            "{pair:?}"
        );
    }
}

/// As a preconditioner in `f32` it takes right-hand sides that `f32` does not hold.
#[test]
fn a_factor_in_f32_applies_to_tiny_and_huge_vectors() {
    let a = random_matrix::<3>(2, 7, 2);
    let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
    let factor = CholeskyFactor::<f32, 3>::factor(&symbolic, &a).unwrap();
    let b: Vec<f64> = (0..a.dim()).map(|i| (i as f64).sin()).collect();
    for exponent in [0, -400, 400] {
        let unit = 2.0_f64.powi(exponent);
        let scaled: Vec<f64> = b.iter().map(|b| b * unit).collect();
        let mut x = vec![0.0; b.len()];
        fem_solvers::Preconditioner::apply(&factor, &scaled, &mut x);
        let x: Vec<f64> = x.iter().map(|x| x / unit).collect();
        assert!(residual(&a, &x, &b) < 1e-4, "{exponent}");
    }
}

/// A full matrix is one front, n³/3 additions and multiplications.
#[test]
fn operations_of_a_full_matrix_are_a_third_of_its_cube() {
    for blocks in [1, 4, 9] {
        let all = (0..blocks).flat_map(|i| (0..i).map(move |j| (i, j)));
        let pattern = Arc::new(BlockPattern::from_adjacency(blocks, all).unwrap());
        let symbolic = SymbolicCholesky::<3>::new(&pattern);
        let n = 3.0 * blocks as f64;
        assert_eq!(symbolic.fronts(), 1);
        assert!((symbolic.flops() / (n * n * n / 3.0) - 1.0).abs() < 1e-15);
    }
}

#[test]
fn agrees_with_a_dense_cholesky_on_random_matrices() {
    for (seed, blocks, degree) in [(1, 1, 0), (2, 7, 2), (3, 40, 3), (4, 300, 2), (5, 300, 5)] {
        let a = random_matrix::<3>(seed, blocks, degree);
        let n = a.dim();
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let dense = nalgebra::DMatrix::from_row_slice(n, n, &a.to_dense());
        let expected = dense
            .cholesky()
            .expect("positive definite")
            .solve(&nalgebra::DVector::from_row_slice(&b));
        let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
        let factor = CholeskyFactor::<f64, 3>::factor(&symbolic, &a).unwrap();
        let mut x = b.clone();
        factor.solve_in_place(&mut x);
        for i in 0..n {
            assert!(
                (x[i] - expected[i]).abs() < 1e-10 * max_abs(expected.as_slice()),
                "seed {seed}"
            );
        }
    }
}

#[test]
fn solves_a_grid_with_and_without_coordinates() {
    let (a, points) = grid_matrix::<3>([14, 14, 14]);
    let b: Vec<f64> = (0..a.dim()).map(|i| (0.3 * i as f64).cos()).collect();
    let by_planes = Arc::new(SymbolicCholesky::with_coordinates(a.pattern(), &points));
    let by_levels = Arc::new(SymbolicCholesky::new(a.pattern()));
    for symbolic in [&by_planes, &by_levels] {
        let mut x = b.clone();
        CholeskyFactor::<f64, 3>::factor(symbolic, &a)
            .unwrap()
            .solve_in_place(&mut x);
        assert!(residual(&a, &x, &b) < 1e-12);
    }
    // The ordering is worth its name: natural order stores a band of 2744 · 212 blocks, 5.2 M scalars.
    assert!(by_planes.fill() < 2_600_000, "{}", by_planes.fill());
    assert!(by_levels.fill() < 2_600_000, "{}", by_levels.fill());
}

#[test]
fn many_right_hand_sides_are_solved_as_one_block() {
    let (a, points) = grid_matrix::<3>([5, 6, 7]);
    let symbolic = Arc::new(SymbolicCholesky::with_coordinates(a.pattern(), &points));
    let factor = CholeskyFactor::<f64, 3>::factor(&symbolic, &a).unwrap();
    let n = a.dim();
    let b: Vec<f64> = (0..5 * n).map(|i| (0.1 * i as f64).sin()).collect();
    let mut x = b.clone();
    factor.solve_many(&mut x, 5);
    for c in 0..5 {
        assert!(residual(&a, &x[c * n..(c + 1) * n], &b[c * n..(c + 1) * n]) < 1e-12);
    }
}

#[test]
fn other_block_sizes() {
    fn check<const D: usize>() {
        let (a, points) = grid_matrix::<D>([6, 7, 8]);
        let symbolic = Arc::new(SymbolicCholesky::with_coordinates(a.pattern(), &points));
        let factor = CholeskyFactor::<f64, D>::factor(&symbolic, &a).unwrap();
        let b: Vec<f64> = (0..a.dim()).map(|i| (0.3 * i as f64).cos()).collect();
        let mut x = b.clone();
        factor.solve_in_place(&mut x);
        assert!(residual(&a, &x, &b) < 1e-12);
    }
    check::<1>();
    check::<2>();
    check::<4>();
}

#[test]
fn single_precision_factor_with_refinement_is_fully_accurate() {
    let (a, points) = grid_matrix::<3>([8, 8, 12]);
    let symbolic = Arc::new(SymbolicCholesky::with_coordinates(a.pattern(), &points));
    let factor = CholeskyFactor::<f32, 3>::factor(&symbolic, &a).unwrap();
    let b: Vec<f64> = (0..a.dim())
        .map(|i| 1e-9 * (0.3 * i as f64).cos())
        .collect();
    let mut x = vec![0.0; a.dim()];
    let info = factor
        .solve_refined(
            &a,
            &b,
            &mut x,
            &RefineParams {
                relative_tolerance: 1e-13,
                ..Default::default()
            },
        )
        .unwrap();
    assert!(info.iterations <= 3, "{info:?}");
    assert!(residual(&a, &x, &b) < 1e-21);
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let (a, points) = grid_matrix::<3>([12, 12, 24]);
    let symbolic = Arc::new(SymbolicCholesky::with_coordinates(a.pattern(), &points));
    let b: Vec<f64> = (0..3 * a.dim()).map(|i| (0.3 * i as f64).cos()).collect();
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut x = b.clone();
            CholeskyFactor::<f64, 3>::factor(&symbolic, &a)
                .unwrap()
                .solve_many(&mut x, 3);
            let mut y = b[..a.dim()].to_vec();
            CholeskyFactor::<f32, 3>::factor(&symbolic, &a)
                .unwrap()
                .solve_in_place(&mut y);
            x.extend(y);
            x.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        })
    };
    let one = solve(1);
    for threads in [2, 3, 2] {
        assert!(one == solve(threads), "{threads} threads");
    }
}

#[test]
fn an_indefinite_matrix_is_named_by_its_row_and_the_factor_recovers() {
    let (good, points) = grid_matrix::<3>([5, 5, 5]);
    let symbolic = Arc::new(SymbolicCholesky::with_coordinates(good.pattern(), &points));
    let mut factor = CholeskyFactor::<f64, 3>::factor(&symbolic, &good).unwrap();
    let mut bad = good.clone();
    let k = bad.pattern().diagonal(17);
    bad.values_mut()[k][1][1] = -50.0;
    // The pivot that fails is the first in elimination order, of row 17 or of a later neighbor.
    assert!(matches!(
        factor.refactor(&bad),
        Err(CholeskyError::NotPositiveDefinite { .. })
    ));
    let mut x = vec![1.0; good.dim()];
    factor.solve_in_place(&mut x);
    assert!(
        x.iter().any(|v| v.is_nan()),
        "a failed factor must not look like a good one"
    );
    factor.refactor(&good).unwrap();
    let b = vec![1.0; good.dim()];
    let mut x = b.clone();
    factor.solve_in_place(&mut x);
    assert!(residual(&good, &x, &b) < 1e-12);
}

#[test]
fn a_singular_matrix_is_refused_or_its_solution_is_huge() {
    // Neumann Laplacian: constants are in the null space; rounding decides the sign of the last pivot.
    let pattern = Arc::new(BlockPattern::from_adjacency(4, [(0, 1), (1, 2), (2, 3)]).unwrap());
    let mut a = BlockSymmetric::<1>::zeros(pattern.clone());
    for i in 0..4 {
        let k = pattern.diagonal(i);
        a.values_mut()[k] = [[if i == 0 || i == 3 { 1.0 } else { 2.0 }]];
        if i > 0 {
            a.values_mut()[k - 1] = [[-1.0]];
        }
    }
    let symbolic = Arc::new(SymbolicCholesky::new(&pattern));
    let outcome = CholeskyFactor::<f64, 1>::factor(&symbolic, &a);
    assert!(
        matches!(outcome, Err(CholeskyError::NotPositiveDefinite { .. })),
        "integers: the last pivot is exactly 0"
    );
}

#[test]
fn nan_infinity_and_overflow_are_named() {
    let (good, _) = grid_matrix::<2>([4, 4, 1]);
    let symbolic = Arc::new(SymbolicCholesky::new(good.pattern()));
    for value in [f64::NAN, f64::INFINITY] {
        let mut bad = good.clone();
        let k = bad.pattern().diagonal(9);
        bad.values_mut()[k][0][1] = value;
        assert_eq!(
            CholeskyFactor::<f64, 2>::factor(&symbolic, &bad).unwrap_err(),
            CholeskyError::NonFinite { block_row: 9 }
        );
    }
    let mut large = good.clone();
    let k = large.pattern().diagonal(3);
    large.values_mut()[k][0][0] = 1e39;
    assert!(CholeskyFactor::<f64, 2>::factor(&symbolic, &large).is_ok());
    assert_eq!(
        CholeskyFactor::<f32, 2>::factor(&symbolic, &large).unwrap_err(),
        CholeskyError::NonFinite { block_row: 3 }
    );
}

#[test]
fn empty_single_and_disconnected() {
    let empty = BlockSymmetric::<3>::zeros(Arc::new(BlockPattern::from_adjacency(0, []).unwrap()));
    let symbolic = Arc::new(SymbolicCholesky::new(empty.pattern()));
    CholeskyFactor::<f64, 3>::factor(&symbolic, &empty)
        .unwrap()
        .solve_in_place(&mut []);

    let mut one =
        BlockSymmetric::<2>::zeros(Arc::new(BlockPattern::from_adjacency(1, []).unwrap()));
    one.values_mut()[0] = [[4.0, 1.0], [1.0, 3.0]];
    let symbolic = Arc::new(SymbolicCholesky::new(one.pattern()));
    let mut x = [9.0, 5.0];
    CholeskyFactor::<f64, 2>::factor(&symbolic, &one)
        .unwrap()
        .solve_in_place(&mut x);
    assert!((x[0] - 2.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);

    // 500 separate pairs.
    let pairs = (0..500).map(|k| (2 * k, 2 * k + 1));
    let mut many =
        BlockSymmetric::<1>::zeros(Arc::new(BlockPattern::from_adjacency(1000, pairs).unwrap()));
    let mut rng = Lcg::new(3);
    for value in many.values_mut() {
        *value = [[0.5 * rng.next()]];
    }
    many.shift_diagonal(2.0);
    let symbolic = Arc::new(SymbolicCholesky::new(many.pattern()));
    let b = vec![1.0; 1000];
    let mut x = b.clone();
    CholeskyFactor::<f64, 1>::factor(&symbolic, &many)
        .unwrap()
        .solve_in_place(&mut x);
    assert!(residual(&many, &x, &b) < 1e-14);
}

#[test]
fn long_chains_stars_and_complete_graphs() {
    let chain: Vec<_> = (0..19_999).map(|i| (i, i + 1)).collect();
    let star: Vec<_> = (1..2_000).map(|i| (0, i)).collect();
    let complete: Vec<_> = (0..150).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
    for (blocks, pairs) in [(20_000, chain), (2_000, star), (150, complete)] {
        let pattern =
            Arc::new(BlockPattern::from_adjacency(blocks, pairs.iter().copied()).unwrap());
        let mut a = BlockSymmetric::<1>::zeros(pattern.clone());
        a.shift_diagonal(0.1);
        for &(i, j) in &pairs {
            let off = pattern.find(i.max(j), i.min(j)).unwrap();
            a.values_mut()[off][0][0] = -1.0;
            for k in [i, j] {
                let d = pattern.diagonal(k);
                a.values_mut()[d][0][0] += 1.0;
            }
        }
        let symbolic = Arc::new(SymbolicCholesky::new(&pattern));
        let b: Vec<f64> = (0..blocks).map(|i| (i as f64).sin()).collect();
        let mut x = b.clone();
        CholeskyFactor::<f64, 1>::factor(&symbolic, &a)
            .unwrap()
            .solve_in_place(&mut x);
        assert!(residual(&a, &x, &b) < 1e-11, "{blocks}");
        assert!(
            symbolic.fill() < 12 * pattern.stored(),
            "{blocks}: {}",
            symbolic.fill()
        );
    }
}

#[test]
fn another_pattern_is_refused() {
    let (a, _) = grid_matrix::<2>([4, 4, 1]);
    let (b, _) = grid_matrix::<2>([4, 5, 1]);
    let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
    assert!(matches!(
        CholeskyFactor::<f64, 2>::factor(&symbolic, &b),
        Err(CholeskyError::PatternMismatch { .. })
    ));
}

#[test]
fn a_pivot_that_rounding_made_no_number_is_not_positive() {
    // L₄₁L₃₁ and L₄₂L₃₂ overflow to ∞ and −∞, their sum is NaN and so is the last pivot.
    let pattern = Arc::new(BlockPattern::from_adjacency(1, []).unwrap());
    let mut a = BlockSymmetric::<4>::zeros(pattern.clone());
    let (u, v) = (9e153, 1e155);
    a.values_mut()[0] = [
        [1.0, 0.0, u, v],
        [0.0, 1.0, u, -v],
        [u, u, 1.7e308, 0.0],
        [v, -v, 0.0, 1e308],
    ];
    let symbolic = Arc::new(SymbolicCholesky::new(&pattern));
    assert_eq!(
        CholeskyFactor::<f64, 4>::factor(&symbolic, &a).unwrap_err(),
        CholeskyError::NotPositiveDefinite {
            block_row: 0,
            axis: 3
        }
    );
}
