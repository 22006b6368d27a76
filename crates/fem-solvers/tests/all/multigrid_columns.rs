//! Many right-hand sides on one hierarchy, against a factor.

use super::multigrid::{Bar, bar, dot, load, made, params, rigid};
use fem_solvers::{
    BlockSymmetric, CholeskyFactor, LinearOperator, MatrixPreconditioner, Multigrid, PcgError,
    SolveManyParams, SymbolicCholesky,
};
use std::sync::Arc;

fn to(energy_tolerance: f64) -> SolveManyParams {
    SolveManyParams {
        energy_tolerance,
        ..SolveManyParams::default()
    }
}

fn factored(matrix: &BlockSymmetric<3>, mut columns: Vec<f64>) -> Vec<f64> {
    let symbolic = Arc::new(SymbolicCholesky::new(matrix.pattern()));
    let factor = CholeskyFactor::<f64, 3>::factor(&symbolic, matrix).unwrap();
    let count = columns.len() / matrix.dim();
    factor.solve_many(&mut columns, count);
    columns
}

/// √vᵀAv.
fn size(matrix: &BlockSymmetric<3>, v: &[f64]) -> f64 {
    let mut product = vec![0.0; v.len()];
    matrix.apply(v, &mut product);
    dot(v, &product).sqrt()
}

/// The largest error of a column in the norm of the matrix, over its own size.
fn largest_error(matrix: &BlockSymmetric<3>, found: &[f64], exact: &[f64]) -> f64 {
    let n = matrix.dim();
    let columns = found.chunks(n).zip(exact.chunks(n));
    let of = |(x, exact): (&[f64], &[f64])| {
        let off: Vec<f64> = x.iter().zip(exact).map(|(a, b)| a - b).collect();
        size(matrix, &off) / size(matrix, exact)
    };
    columns.map(of).fold(0.0, f64::max)
}

#[test]
fn the_tolerance_is_what_the_error_is_and_no_more_is_done() {
    let bar = bar(4, true);
    let (hierarchy, n) = (made::<f32>(&bar), bar.matrix.dim());
    // Together, alone, together and two alone, two together.
    for count in [8, 1, 10, 11] {
        let b = load(n * count, 5);
        let exact = factored(&bar.matrix, b.clone());
        let mut before = 0;
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            let mut x = b.clone();
            let solved = hierarchy.solve_many(&bar.matrix, &mut x, count, &to(tolerance));
            let solved = solved.unwrap();
            let error = largest_error(&bar.matrix, &x, &exact);
            assert!(error <= tolerance, "{count}: {error:e} of {tolerance:e}");
            assert!(
                error > 1e-4 * tolerance,
                "{count}: {error:e} of {tolerance:e}"
            );
            // Below that the factor's own rounding shows.
            let told = solved.error > 0.1 * error || tolerance < 1e-9;
            assert!(
                solved.error <= tolerance && told,
                "{:e} {error:e}",
                solved.error
            );
            assert!(solved.iterations > before && solved.iterations <= 40 * count);
            before = solved.iterations;
        }
    }
}

#[test]
fn columns_differ_in_size_and_some_are_zero() {
    let bar = bar(2, true);
    let (hierarchy, n) = (made::<f32>(&bar), bar.matrix.dim());
    let mut b = load(n * 5, 7);
    let sizes = [1.0, 1e-200, 0.0, 1e200, 1e-9];
    for (column, size) in b.chunks_mut(n).zip(sizes) {
        column.iter_mut().for_each(|v| *v *= size);
    }
    let mut x = b.clone();
    let zero: usize = {
        let mut none = vec![0.0; 3 * n];
        let solved = hierarchy.solve_many(&bar.matrix, &mut none, 3, &to(1e-9));
        assert!(none.iter().all(|v| *v == 0.0));
        solved.unwrap().iterations
    };
    assert_eq!(zero, 0);
    hierarchy
        .solve_many(&bar.matrix, &mut x, 5, &to(1e-9))
        .unwrap();
    let exact = factored(&bar.matrix, b);
    for (k, size) in sizes.into_iter().enumerate() {
        let own = k * n..(k + 1) * n;
        if size == 0.0 {
            assert!(x[own].iter().all(|v| *v == 0.0));
            continue;
        }
        let scaled = |v: &[f64]| v[own.clone()].iter().map(|v| v / size).collect::<Vec<_>>();
        assert!(largest_error(&bar.matrix, &scaled(&x), &scaled(&exact)) <= 1e-9);
    }
}

#[test]
fn the_bits_do_not_depend_on_the_threads() {
    let bar = bar(8, true);
    let solved: Vec<Vec<f64>> = [1, 2, 3]
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let mut x = load(bar.matrix.dim() * 9, 11);
                let hierarchy = made::<f32>(&bar);
                hierarchy
                    .solve_many(&bar.matrix, &mut x, 9, &to(1e-6))
                    .unwrap();
                x
            })
        })
        .into();
    assert!(solved[0] == solved[1] && solved[0] == solved[2]);
}

/// The matrix of a bar with one direction of negative curvature, with the hierarchy of the bar itself:
/// springs that push two ends apart.
fn pushed(bar: &Bar, by: f64) -> BlockSymmetric<3> {
    let mut matrix = bar.matrix.clone();
    let last = matrix.pattern().blocks() - 1;
    let place = matrix.pattern().diagonal(last);
    for r in 0..3 {
        matrix.values_mut()[place][r][r] -= by;
    }
    matrix
}

#[test]
fn what_does_not_converge_or_is_not_definite_is_an_error() {
    let bar = bar(4, true);
    let (hierarchy, n) = (made::<f32>(&bar), bar.matrix.dim());
    for count in [1, 4] {
        let solve = |matrix: &BlockSymmetric<3>, params: SolveManyParams| {
            let mut x = load(n * count, 13);
            hierarchy.solve_many(matrix, &mut x, count, &params)
        };
        let few = SolveManyParams {
            max_iterations: 5,
            ..to(1e-9)
        };
        assert!(matches!(
            solve(&bar.matrix, few),
            Err(PcgError::NotConverged { iterations: 5, relative_residual }) if relative_residual > 1e-9
        ));
        // Below what rounding leaves.
        let exact = SolveManyParams {
            max_iterations: 100,
            ..to(1e-18)
        };
        assert!(matches!(
            solve(&bar.matrix, exact),
            Err(PcgError::NotConverged { .. })
        ));
        assert!(matches!(
            solve(&pushed(&bar, 10.0), to(1e-9)),
            Err(PcgError::NegativeCurvature { .. })
        ));
        assert!(matches!(
            solve(&bar.matrix, to(f64::NAN)),
            Err(PcgError::Tolerance { .. })
        ));
        let mut bad = load(n * count, 17);
        bad[n * count - 1] = f64::NAN;
        assert!(matches!(
            hierarchy.solve_many(&bar.matrix, &mut bad, count, &to(1e-9)),
            Err(PcgError::NonFinite { index, .. }) if index == n * count - 1
        ));
        assert!(matches!(
            hierarchy.solve_many(&bar.matrix, &mut bad[1..], count, &to(1e-9)),
            Err(PcgError::Dimension { .. })
        ));
        // Of no matrix yet, and of another.
        let none: Multigrid<3, 6> = Multigrid::new(rigid(&bar.points), params());
        let other = made::<f32>(&super::multigrid::bar(2, true));
        for unfit in [none, other] {
            let mut x = load(n * count, 13);
            let error = unfit.solve_many(&bar.matrix, &mut x, count, &to(1e-9));
            assert!(matches!(error, Err(PcgError::Preconditioner { .. })));
        }
    }
}

#[test]
fn a_block_of_more_columns_than_memory_has_is_of_another_length() {
    let bar = bar(2, true);
    let (hierarchy, n) = (made::<f32>(&bar), bar.matrix.dim());
    assert_eq!(n % 8, 0);
    // The first product wraps around to 0.
    for count in [usize::MAX / 8 + 1, usize::MAX] {
        let solved = hierarchy.solve_many(&bar.matrix, &mut [], count, &to(1e-9));
        assert!(matches!(solved, Err(PcgError::Dimension { found: 0, .. })));
    }
}

#[test]
fn a_solution_beyond_every_number_is_an_error() {
    let bar = bar(2, true);
    let mut soft = bar.matrix.clone();
    let values = soft.values_mut().as_flattened_mut().as_flattened_mut();
    values.iter_mut().for_each(|v| *v *= 1e-6);
    let mut hierarchy: Multigrid<3, 6> = Multigrid::new(rigid(&bar.points), params());
    hierarchy.update(&soft).unwrap();
    let n = soft.dim();
    // Alone, together, and the last one of those together.
    for (count, large) in [(1, 0), (4, 0), (4, 3)] {
        let mut x = load(n * count, 23);
        x[large * n..][..n].iter_mut().for_each(|v| *v *= 1e305);
        let error = hierarchy.solve_many(&soft, &mut x, count, &to(1e-9));
        let error = error.unwrap_err();
        let found =
            matches!(&error, PcgError::NonFinite { what: "the solution", index, .. } if *index < n);
        assert!(found, "{error}");
    }
    let mut x = load(n, 23);
    x.iter_mut().for_each(|v| *v *= 1e290);
    hierarchy.solve_many(&soft, &mut x, 1, &to(1e-9)).unwrap();
}

#[test]
fn an_absent_scalar_is_zero_whatever_stands_there() {
    let bar = bar(2, true);
    let pattern = bar.matrix.pattern();
    let absent = [(3, 1), (7, 0)];
    let pattern = Arc::new((**pattern).clone().with_absent(absent).unwrap());
    let mut matrix = BlockSymmetric::<3>::zeros(pattern);
    matrix.values_mut().copy_from_slice(bar.matrix.values());
    matrix.fill_padding();
    let mut hierarchy: Multigrid<3, 6> = Multigrid::new(rigid(&bar.points), params());
    hierarchy.update(&matrix).unwrap();
    let n = matrix.dim();
    let mut b = load(n * 4, 19);
    b.iter_mut().step_by(n).for_each(|v| *v = 3.0);
    for column in b.chunks_mut(n) {
        column[10] = 1e9;
    }
    let exact = factored(&matrix, b.clone());
    hierarchy
        .solve_many(&matrix, &mut b, 4, &to(1e-10))
        .unwrap();
    for (x, exact) in b.chunks(n).zip(exact.chunks(n)) {
        assert!(x[10] == 0.0 && x[21] == 0.0);
        assert!(x.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-8));
    }
}

/// By counts: a factor of a small matrix is cheaper than one solve, one of a larger matrix dearer than that
/// but cheaper than eight.
#[test]
fn a_factor_is_cheaper_for_many_right_hand_sides() {
    let cheaper = |n: usize, count: usize| {
        let bar = bar(n, true);
        let symbolic = SymbolicCholesky::new(bar.matrix.pattern());
        Multigrid::<3, 6>::solves_cheaper_than(&symbolic, count)
    };
    assert!(!cheaper(4, 1) && cheaper(16, 1) && !cheaper(16, 8) && !cheaper(16, 1_000));
}
