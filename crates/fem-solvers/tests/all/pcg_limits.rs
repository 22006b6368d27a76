//! What conjugate gradients and their incomplete factors say at the edge: units, stagnation, shifts.

use crate::pcg::dense_product;
use fem_solvers::{
    BlockIc0, BlockPattern, BlockSymmetric, Identity, LinearOperator, PcgError, PcgParams,
    PreconditionerError, Structure, pcg,
};
use std::sync::Arc;

/// The second difference.
fn chain(n: usize) -> BlockSymmetric<1> {
    let pattern = BlockPattern::from_adjacency(n, (1..n).map(|i| (i - 1, i))).unwrap();
    let pattern = Arc::new(pattern);
    let mut a = BlockSymmetric::<1>::zeros(pattern.clone());
    a.values_mut().fill([[-1.0]]);
    (0..n).for_each(|i| a.values_mut()[pattern.diagonal(i)] = [[2.5]]);
    a.claiming(Structure::SymmetricPositiveDefinite)
}

/// The largest entry of b − A x.
fn left(a: &BlockSymmetric<1>, b: &[f64], x: &[f64]) -> f64 {
    let product = dense_product(a, x);
    b.iter()
        .zip(&product)
        .fold(0.0, |m, (b, p)| m.max((b - p).abs()))
}

#[test]
fn tolerances_have_the_unit_of_the_right_hand_side_however_small_or_large() {
    let a = chain(40);
    for unit in [1e-200, 1.0, 1e200] {
        let b: Vec<f64> = (0..40)
            .map(|i| unit * (1.0 + 0.1 * (i as f64).sin()))
            .collect();
        let absolute = PcgParams {
            relative_tolerance: 0.0,
            absolute_tolerance: 1e-3 * unit,
            ..PcgParams::default()
        };
        let mut x = vec![0.0; 40];
        pcg(&a, &Identity, &b, &mut x, &absolute).unwrap();
        let rest = left(&a, &b, &x) / unit;
        assert!(rest <= 1e-3 && rest > 1e-6, "{unit:e}: {rest:e}");
        // From nearly the solution: what is told is still a part of ‖b‖.
        x.iter_mut()
            .enumerate()
            .for_each(|(i, x)| *x *= 1.0 + 1e-4 * (3.0 * i as f64).sin());
        let relative = PcgParams {
            relative_tolerance: 1e-7,
            ..PcgParams::default()
        };
        let told = pcg(&a, &Identity, &b, &mut x, &relative)
            .unwrap()
            .relative_residual;
        let product = dense_product(&a, &x);
        let norm =
            |v: &mut dyn Iterator<Item = f64>| v.map(|v| (v / unit).powi(2)).sum::<f64>().sqrt();
        let rest = norm(&mut b.iter().zip(&product).map(|(b, p)| b - p));
        let part = rest / norm(&mut b.iter().copied());
        assert!(
            part <= 1e-7 && (told / part - 1.0).abs() < 1e-3,
            "{unit:e}: {told:e} {part:e}"
        );
    }
}

/// A residual of 1e-80 has a size, though its squares are far from those of the right-hand side.
#[test]
fn a_residual_far_below_the_right_hand_side_is_measured() {
    let a = chain(12);
    let deep = PcgParams {
        relative_tolerance: 1e-80,
        ..PcgParams::default()
    };
    let mut x = vec![0.0; 12];
    let info = pcg(&a, &Identity, &[1.0; 12], &mut x, &deep).unwrap();
    assert!(
        info.relative_residual <= 1e-80 && info.iterations < 100,
        "{info:?}"
    );
    assert!(left(&a, &[1.0; 12], &x) < 1e-15);
}

/// Turns what it is given by more than it keeps, and says that it is symmetric: residuals double.
struct Restless;

impl LinearOperator for Restless {
    fn dim(&self) -> usize {
        2
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.copy_from_slice(&[x[0] + 2.0 * x[1], x[1] - 2.0 * x[0]]);
    }
    fn structure(&self) -> Structure {
        Structure::SymmetricPositiveDefinite
    }
}

#[test]
fn a_residual_that_only_grows_is_stagnation_at_its_smallest() {
    for window in [1, 3, 8] {
        let params = PcgParams {
            stagnation_window: window,
            ..PcgParams::default()
        };
        let outcome = pcg(&Restless, &Identity, &[1.0, 0.0], &mut [0.0; 2], &params);
        let expected = PcgError::Stagnated {
            iterations: window,
            relative_residual: 1.0,
        };
        assert_eq!(outcome, Err(expected));
    }
    // A residual that falls each time is not given up after the first.
    let patient = PcgParams {
        stagnation_window: 1,
        ..PcgParams::default()
    };
    pcg(&chain(12), &Identity, &[1.0; 12], &mut [0.0; 12], &patient).unwrap();
}

/// (1 + s)² must exceed the square of the coupling; ten times that is no preconditioner any more.
#[test]
fn the_first_shift_that_suffices_is_taken_and_the_last_is_ten() {
    let shift = |coupling: f64| {
        let pattern = Arc::new(BlockPattern::from_adjacency(2, [(0, 1)]).unwrap());
        let mut a = BlockSymmetric::<1>::zeros(pattern);
        a.values_mut()
            .copy_from_slice(&[[[1.0]], [[coupling]], [[1.0]]]);
        BlockIc0::new(&a).map(|made| made.shift())
    };
    let near = |shift: f64, expected: f64| (shift - expected).abs() < 1e-12;
    for (coupling, expected) in [
        (0.9, 0.0),
        (1.0001, 1e-3),
        (1.004, 1e-2),
        (1.05, 0.1),
        (10.0, 10.0),
    ] {
        assert!(near(shift(coupling).unwrap(), expected), "{coupling}");
    }
    match shift(100.0) {
        Err(PreconditionerError::Breakdown { block: 1, shift }) => assert!(near(shift, 10.0)),
        other => panic!("{other:?}"),
    }
}
