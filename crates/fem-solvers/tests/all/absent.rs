//! Systems from which single scalars are missing, against dense solves of what is left.

use crate::common::{Lcg, grid_matrix, max_abs, random_matrix};
use crate::promise::{Newton, Summed};
use fem_solvers::{
    AssumedPositiveDefinite, BlockIc0, BlockJacobi, BlockPattern, BlockSymmetric, CholeskyError,
    CholeskyFactor, FactorScalar, HessianProjection, LinearOperator, LinearSolver,
    MatrixPreconditioner, Multigrid, MultigridParams, NearKernel, NewtonParams, NonlinearProblem,
    PatternError, PcgParams, Permutation, Preconditioner, PreconditionerChoice, RefineError,
    RefineParams, SymbolicCholesky, pcg,
};
use std::sync::Arc;

/// A matrix of the same values without some scalars, with numbers in their places that nobody may read.
fn without<const D: usize>(
    full: &BlockSymmetric<D>,
    absent: &[(usize, usize)],
) -> BlockSymmetric<D> {
    leaving(full, absent, [f64::NAN, -1e8, 1e200])
}

fn leaving<const D: usize>(
    full: &BlockSymmetric<D>,
    absent: &[(usize, usize)],
    nonsense: [f64; 3],
) -> BlockSymmetric<D> {
    let pattern = BlockPattern::clone(full.pattern());
    let pattern = Arc::new(pattern.with_absent(absent.iter().copied()).unwrap());
    let mut a = BlockSymmetric::<D>::zeros(pattern.clone());
    a.values_mut().copy_from_slice(full.values());
    for row in 0..pattern.blocks() {
        for k in pattern.row_start()[row]..pattern.row_start()[row + 1] {
            let column = pattern.columns()[k] as usize;
            for r in 0..D {
                for c in 0..D {
                    if absent.contains(&(row, r)) || absent.contains(&(column, c)) {
                        a.values_mut()[k][r][c] = nonsense[(k + r + c) % 3];
                    }
                }
            }
        }
    }
    a
}

/// One scalar in five, and one whole block in seven.
fn some<const D: usize>(seed: u64, blocks: usize) -> Vec<(usize, usize)> {
    let mut rng = Lcg::new(seed);
    let mut absent = Vec::new();
    for row in 0..blocks {
        let whole = rng.below(7) == 0;
        absent.extend(
            (0..D)
                .filter(|_| whole || rng.below(5) == 0)
                .map(|k| (row, k)),
        );
    }
    absent
}

fn is_absent<const D: usize>(absent: &[(usize, usize)], place: usize) -> bool {
    absent.contains(&(place / D, place % D))
}

/// Solutions of the system of the scalars that are there, 0 in the places of the others.
fn dense<const D: usize>(
    a: &BlockSymmetric<D>,
    absent: &[(usize, usize)],
    b: &[f64],
    columns: usize,
) -> Vec<f64> {
    let n = a.dim();
    let there: Vec<usize> = (0..n).filter(|&p| !is_absent::<D>(absent, p)).collect();
    let (all, m) = (a.to_dense(), there.len());
    let reduced = nalgebra::DMatrix::from_fn(m, m, |i, j| all[there[i] * n + there[j]]);
    let right = nalgebra::DMatrix::from_fn(m, columns, |i, c| b[c * n + there[i]]);
    let solved = reduced.cholesky().expect("positive definite").solve(&right);
    let mut x = vec![0.0; n * columns];
    for (i, place) in there.iter().enumerate() {
        for c in 0..columns {
            x[c * n + place] = solved[(i, c)];
        }
    }
    x
}

/// Numbers for the scalars that are there, and what no solve may touch for the others.
fn right_hand_sides<const D: usize>(
    n: usize,
    absent: &[(usize, usize)],
    columns: usize,
) -> Vec<f64> {
    let nonsense = [f64::NAN, 1e300, f64::INFINITY];
    (0..n * columns)
        .map(|i| match is_absent::<D>(absent, i % n) {
            true => nonsense[i % 3],
            false => (0.7 * i as f64).sin(),
        })
        .collect()
}

fn with_threads<R: Send>(threads: usize, f: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(f)
}

fn solved<T: FactorScalar, const D: usize>(
    symbolic: &Arc<SymbolicCholesky<D>>,
    a: &BlockSymmetric<D>,
    b: &[f64],
    columns: usize,
) -> Vec<f64> {
    let mut x = b.to_vec();
    let factor = CholeskyFactor::<T, D>::factor(symbolic, a).unwrap();
    factor.solve_many(&mut x, columns);
    x
}

/// Both precisions, one and two threads, one and several right-hand sides.
fn check<const D: usize>(
    name: &str,
    full: &BlockSymmetric<D>,
    absent: &[(usize, usize)],
    columns: usize,
) -> Arc<SymbolicCholesky<D>> {
    let a = without(full, absent);
    let n = a.dim();
    let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
    assert_eq!(symbolic.unknowns(), n - absent.len(), "{name}");
    let b = right_hand_sides::<D>(n, absent, columns);
    let expected = dense(&a, absent, &b, columns);
    let size = max_abs(&expected);
    let double = solved::<f64, D>(&symbolic, &a, &b, columns);
    let single = solved::<f32, D>(&symbolic, &a, &b, columns);
    for (x, tolerance) in [(&double, 1e-10), (&single, 1e-3)] {
        for i in 0..n * columns {
            let close = (x[i] - expected[i]).abs() <= tolerance * size;
            assert!(close, "{name}: {} is not {} at {i}", x[i], expected[i]);
            assert!(!is_absent::<D>(absent, i % n) || x[i] == 0.0, "{name}: {i}");
        }
    }
    let first = solved::<f64, D>(&symbolic, &a, &b[..n], 1);
    for i in 0..n {
        assert!(
            (first[i] - expected[i]).abs() <= 1e-10 * size,
            "{name}: {i}"
        );
    }
    for threads in [1, 2] {
        let again = with_threads(threads, || {
            let mut x = solved::<f64, D>(&symbolic, &a, &b, columns);
            x.extend(solved::<f32, D>(&symbolic, &a, &b, columns));
            x
        });
        let bits = |x: &[f64]| x.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(
            bits(&again) == bits(&[double.clone(), single.clone()].concat()),
            "{name}"
        );
    }
    symbolic
}

#[test]
fn a_factor_of_what_is_left_agrees_with_a_dense_one() {
    for (seed, blocks, degree) in [(1, 1, 0), (2, 7, 2), (3, 40, 3), (4, 300, 2), (5, 150, 5)] {
        let name = format!("{blocks} blocks");
        check::<2>(
            &name,
            &random_matrix(seed, blocks, degree),
            &some::<2>(seed, blocks),
            3,
        );
        check::<3>(
            &name,
            &random_matrix(seed, blocks, degree),
            &some::<3>(seed, blocks),
            3,
        );
    }
}

/// Chains are merged into few supernodes, grids into many fronts of several tasks.
#[test]
fn chains_and_grids_too() {
    let chain = grid_matrix::<3>([400, 1, 1]).0;
    check::<3>("chain", &chain, &some::<3>(6, 400), 3);
    let grid = grid_matrix::<2>([12, 8, 8]).0;
    // Below this many numbers of the factor times columns a solve is one task.
    let columns = 12;
    let symbolic = check::<2>("grid", &grid, &some::<2>(7, 768), columns);
    let numbers = columns * symbolic.fill();
    assert!(numbers > 2 * 400_000, "{numbers}");
    // All of a plane of blocks, and one axis of the next one.
    let planes = (0..768).filter(|i| i % 12 < 2);
    let planes: Vec<_> = planes
        .flat_map(|i| (0..2 - i % 12).map(move |k| (i, k)))
        .collect();
    check::<2>("planes", &grid, &planes, 3);
}

#[test]
fn nothing_may_be_left_or_all() {
    let full = random_matrix::<3>(8, 30, 2);
    let all: Vec<_> = (0..30).flat_map(|i| (0..3).map(move |k| (i, k))).collect();
    check::<3>("none left", &full, &all, 3);
    check::<3>("one left", &full, &all[1..], 3);
    check::<3>("all left", &full, &[], 3);
}

/// Scalars past the size of the blocks may be absent: matrix and solution are those of a pattern that does
/// not name them, to the last bit.
#[test]
fn an_axis_that_blocks_do_not_have_is_not_missed() {
    let full = random_matrix::<3>(9, 60, 3);
    let pattern = BlockPattern::clone(full.pattern());
    let pattern = Arc::new(pattern.with_absent([(4, 3), (0, 7)]).unwrap());
    assert_eq!((pattern.unknowns(3), pattern.unknowns(4)), (180, 239));
    let mut other = BlockSymmetric::zeros(pattern.clone());
    other.values_mut().copy_from_slice(full.values());
    other.fill_padding();
    assert_eq!(other.values(), full.values());
    let b: Vec<f64> = (0..180).map(|i| (i as f64).cos()).collect();
    let of = |a: &BlockSymmetric<3>| {
        let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
        solved::<f64, 3>(&symbolic, a, &b, 1)
    };
    assert_eq!(of(&full), of(&other));
}

/// A full matrix is one front, whatever is missing from it: n³/3 operations, n (n + 1)/2 numbers.
#[test]
fn operations_and_numbers_of_a_factor_are_those_of_what_is_left() {
    let all = (0..9).flat_map(|i| (0..i).map(move |j| (i, j)));
    let pattern = BlockPattern::from_adjacency(9, all).unwrap();
    let absent = [(8, 0), (2, 1), (2, 2), (2, 0), (5, 2), (2, 1)];
    let pattern = Arc::new(pattern.with_absent(absent).unwrap());
    let symbolic = SymbolicCholesky::<3>::new(&pattern);
    assert_eq!((symbolic.dim(), symbolic.unknowns()), (27, 22));
    assert_eq!((symbolic.fronts(), symbolic.fill()), (1, 11 * 23));
    assert!((symbolic.flops() / (22.0_f64.powi(3) / 3.0) - 1.0).abs() < 1e-15);
}

/// The middle of a star that is not there couples nothing, even where it comes first.
#[test]
fn a_block_without_unknowns_makes_no_fill() {
    let star = BlockPattern::from_adjacency(20, (1..20).map(|i| (0, i))).unwrap();
    let star = Arc::new(star.with_absent((0..3).map(|k| (0, k))).unwrap());
    let order = Permutation::new((0..20).collect()).unwrap();
    let symbolic = SymbolicCholesky::<3>::with_permutation(&star, &order);
    assert_eq!((symbolic.fronts(), symbolic.fill()), (19, 19 * 6));
}

#[test]
fn a_pivot_that_is_not_positive_has_its_own_name() {
    let full = grid_matrix::<3>([5, 4, 3]).0;
    for (bad, axis) in [(0, 2), (17, 1), (59, 2)] {
        let absent: Vec<_> = (0..60).map(|i| (i, 0)).collect();
        let mut a = without(&full, &absent);
        let pattern = a.pattern().clone();
        // Coupled to nothing, so that no other pivot suffers.
        for row in 0..60 {
            for k in pattern.row_start()[row]..pattern.row_start()[row + 1] {
                let column = pattern.columns()[k] as usize;
                for m in 0..3 {
                    if row == bad {
                        a.values_mut()[k][axis][m] = 0.0;
                    }
                    if column == bad {
                        a.values_mut()[k][m][axis] = 0.0;
                    }
                }
            }
        }
        a.values_mut()[pattern.diagonal(bad)][axis][axis] = -1.0;
        let symbolic = Arc::new(SymbolicCholesky::new(&pattern));
        assert_eq!(
            CholeskyFactor::<f64, 3>::factor(&symbolic, &a).unwrap_err(),
            CholeskyError::NotPositiveDefinite {
                block_row: bad,
                axis
            }
        );
    }
}

#[test]
fn refinement_sees_only_what_is_there() {
    let full = grid_matrix::<3>([8, 8, 6]).0;
    let absent = some::<3>(10, 384);
    let mut a = without(&full, &absent);
    a.fill_padding();
    let symbolic = Arc::new(SymbolicCholesky::new(a.pattern()));
    let factor = CholeskyFactor::<f32, 3>::factor(&symbolic, &a).unwrap();
    let n = a.dim();
    let mut b = right_hand_sides::<3>(n, &absent, 1);
    let expected = dense(&a, &absent, &b, 1);
    let params = RefineParams {
        relative_tolerance: 1e-13,
        ..Default::default()
    };
    let mut x = vec![7.0; n];
    let info = factor.solve_refined(&a, &b, &mut x, &params).unwrap();
    assert!(info.iterations <= 3, "{info:?}");
    for i in 0..n {
        assert!(
            (x[i] - expected[i]).abs() < 1e-12 * max_abs(&expected),
            "{i}"
        );
    }
    let mut z = vec![7.0; n];
    Preconditioner::apply(&factor, &b, &mut z);
    for i in 0..n {
        assert!(
            (z[i] - expected[i]).abs() < 1e-4 * max_abs(&expected),
            "{i}"
        );
        assert!(
            !is_absent::<3>(&absent, i) || (x[i], z[i]) == (0.0, 0.0),
            "{i}"
        );
    }
    let there = (0..n).rfind(|&i| !is_absent::<3>(&absent, i)).unwrap();
    b[there] = f64::NAN;
    assert_eq!(
        factor.solve_refined(&a, &b, &mut x, &params),
        Err(RefineError::NonFinite { index: there })
    );
}

/// Neither the scale of a matrix nor the products of what is there know of the padding.
#[test]
fn padding_is_no_part_of_the_system() {
    let full = grid_matrix::<3>([5, 5, 4]).0;
    let absent = some::<3>(11, 100);
    let mut a = without(&full, &absent);
    a.fill_padding();
    let diagonal = a.diagonal();
    let (mut largest, mut means) = (0.0_f64, vec![1.0; 100]);
    for (row, mean) in means.iter_mut().enumerate() {
        let there = (0..3).filter(|&k| !absent.contains(&(row, k)));
        let own: Vec<f64> = there.map(|k| full.diagonal_block(row)[k][k]).collect();
        largest = own.iter().fold(largest, |m, v| m.max(*v));
        if !own.is_empty() {
            *mean = own.iter().sum::<f64>() / own.len() as f64;
        }
    }
    assert_eq!(max_abs(&diagonal), largest);
    for (found, mean) in a.mean_diagonals().iter().zip(&means) {
        assert!((found / mean - 1.0).abs() < 1e-15, "{found} is not {mean}");
    }
    let (dense, before) = (a.to_dense(), full.to_dense());
    for (i, j) in (0..300).flat_map(|i| (0..300).map(move |j| (i, j))) {
        let value = dense[300 * i + j];
        if i == j && is_absent::<3>(&absent, i) {
            assert!((value / means[i / 3] - 1.0).abs() < 1e-15, "{i}");
        } else if is_absent::<3>(&absent, i) || is_absent::<3>(&absent, j) {
            assert_eq!(value, 0.0, "({i}, {j})");
        } else {
            assert_eq!(value, before[300 * i + j], "({i}, {j})");
        }
    }
}

fn iterated(
    a: &BlockSymmetric<3>,
    preconditioner: &mut impl MatrixPreconditioner<3>,
    b: &[f64],
) -> Vec<f64> {
    preconditioner.update(a).unwrap();
    let mut x = vec![0.0; b.len()];
    let params = PcgParams {
        relative_tolerance: 1e-12,
        ..PcgParams::default()
    };
    pcg(
        &AssumedPositiveDefinite(a),
        &*preconditioner,
        b,
        &mut x,
        &params,
    )
    .unwrap();
    x
}

#[test]
fn preconditioners_of_blocks_leave_absent_places_alone() {
    let (full, points) = grid_matrix::<3>([8, 8, 8]);
    let absent = some::<3>(12, 512);
    let mut a = without(&full, &absent);
    a.fill_padding();
    let n = a.dim();
    let b: Vec<f64> = right_hand_sides::<3>(n, &absent, 1)
        .into_iter()
        .enumerate()
        .map(|(i, b)| if is_absent::<3>(&absent, i) { 0.0 } else { b })
        .collect();
    let expected = dense(&a, &absent, &b, 1);
    let fields = (0..3).map(|axis| {
        let of = |i: usize| f64::from(u8::from(i % 3 == axis && !is_absent::<3>(&absent, i)));
        (0..3 * points.len()).map(of).collect()
    });
    let kernel = NearKernel::new(fields.collect());
    let params = MultigridParams::default();
    let solutions = [
        iterated(&a, &mut BlockJacobi::default(), &b),
        iterated(&a, &mut BlockIc0::default(), &b),
        iterated(&a, &mut Multigrid::<3, 3>::new(kernel, params), &b),
    ];
    for (which, x) in solutions.iter().enumerate() {
        for i in 0..n {
            let close = (x[i] - expected[i]).abs() < 1e-9 * max_abs(&expected);
            assert!(close, "{which}: {i}");
            assert!(!is_absent::<3>(&absent, i) || x[i] == 0.0, "{which}: {i}");
        }
    }
}

#[test]
fn what_is_absent_belongs_to_the_pattern() {
    let whole = BlockPattern::from_adjacency(4, [(0, 1), (1, 3)]).unwrap();
    let cut = whole.clone().with_absent([(3, 1), (0, 0), (3, 1)]).unwrap();
    assert_ne!(whole, cut);
    assert_eq!(cut.absent(), [(0, 0), (3, 1)]);
    assert_eq!(
        (whole.unknowns(2), cut.unknowns(2), cut.unknowns(1)),
        (8, 6, 3)
    );
    assert_eq!(cut.extended([(2, 0)]).unwrap().absent(), cut.absent());
    assert_eq!(cut.clone().with_absent([]).unwrap(), whole);
    assert_eq!(
        whole.clone().with_absent([(1, 0), (4, 0)]),
        Err(PatternError::NoSuchRow { row: 4, blocks: 4 })
    );
    let symbolic = Arc::new(SymbolicCholesky::<2>::new(&Arc::new(whole)));
    let mut a = BlockSymmetric::<2>::zeros(Arc::new(cut));
    a.shift_diagonal(1.0);
    assert!(matches!(
        CholeskyFactor::<f64, 2>::factor(&symbolic, &a),
        Err(CholeskyError::PatternMismatch { .. })
    ));
}

/// ½ xᵀ A x − bᵀ x of the scalars that are there; its Hessian holds anything where the others are.
struct Careless {
    given: BlockSymmetric<3>,
    padded: BlockSymmetric<3>,
    b: Vec<f64>,
}

impl Careless {
    fn new(full: &BlockSymmetric<3>, absent: &[(usize, usize)]) -> Self {
        let given = leaving(full, absent, [70.0, -1e5, 3.0]);
        let mut padded = given.clone();
        padded.fill_padding();
        let mut b: Vec<f64> = (0..given.dim()).map(|i| (0.3 * i as f64).sin()).collect();
        absent
            .iter()
            .for_each(|&(row, axis)| b[3 * row + axis] = 0.0);
        Self { given, padded, b }
    }

    /// A x, 0 where a scalar is absent.
    fn product(&self, x: &[f64]) -> Vec<f64> {
        let (mut there, mut product) = (x.to_vec(), vec![0.0; x.len()]);
        for &(row, axis) in self.given.pattern().absent() {
            there[3 * row + axis] = 0.0;
        }
        self.padded.apply(&there, &mut product);
        product
    }
}

impl NonlinearProblem<3> for Careless {
    fn blocks(&self) -> usize {
        self.given.pattern().blocks()
    }
    fn pattern(&self) -> Option<Arc<BlockPattern>> {
        Some(self.given.pattern().clone())
    }
    fn energy(&self, x: &[f64]) -> f64 {
        let product = self.product(x);
        let terms = x.iter().zip(&product).zip(&self.b);
        terms.map(|((x, ax), b)| x * (0.5 * ax - b)).sum()
    }
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        let product = self.product(x);
        (0..g.len()).for_each(|i| g[i] = product[i] - self.b[i]);
    }
    fn hessian(&self, _: &[f64], _: HessianProjection, out: &mut BlockSymmetric<3>) {
        out.values_mut().copy_from_slice(self.given.values());
    }
}

impl Summed<3> for Careless {
    fn terms(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let (dense, n) = (self.padded.to_dense(), x.len());
        let absent = self.given.pattern().absent();
        let is_there = |j: usize| !absent.contains(&(j / 3, j % 3));
        let row = |i: usize| {
            let there = (0..n).filter(|&j| is_there(i) && is_there(j));
            let terms = there.map(|j| dense[i * n + j] * x[j]);
            terms.chain([-self.b[i]]).collect()
        };
        (0..n).map(row).collect()
    }
}

#[test]
fn what_a_problem_leaves_in_absent_places_reaches_no_solver() {
    let full = grid_matrix::<3>([6, 5, 5]).0;
    let absent = some::<3>(13, 150);
    let problem = Careless::new(&full, &absent);
    let expected = dense(&problem.padded, &absent, &problem.b, 1);
    let pcg = |preconditioner| LinearSolver::Pcg {
        preconditioner,
        max_iterations: 500,
    };
    for linear_solver in [
        LinearSolver::Direct,
        pcg(PreconditionerChoice::Identity),
        pcg(PreconditionerChoice::BlockJacobi),
        pcg(PreconditionerChoice::BlockIc0),
    ] {
        let params = NewtonParams {
            linear_solver,
            gradient_tolerance: 1e-11,
            relative_gradient_tolerance: 0.0,
            ..NewtonParams::default()
        };
        let mut x = vec![0.5; 450];
        let mut newton = Newton::new(&problem);
        let info = newton.solve(&problem, &mut x, &params).unwrap();
        assert_eq!(info.projected_steps, 0, "{linear_solver:?}");
        for i in 0..450 {
            let right = if is_absent::<3>(&absent, i) {
                0.5
            } else {
                expected[i]
            };
            assert!((x[i] - right).abs() < 1e-9, "{linear_solver:?}: {i}");
        }
    }
}

#[test]
fn products_with_the_hessian_of_a_problem_are_padded_too() {
    let full = grid_matrix::<3>([4, 4, 4]).0;
    let absent = some::<3>(14, 64);
    let problem = Careless::new(&full, &absent);
    let (x, v) = (vec![0.0; 192], &problem.b);
    let mut y = vec![f64::NAN; 192];
    problem.hessian_vector(&x, HessianProjection::None, v, &mut y);
    assert_eq!(y, problem.product(v));
}
