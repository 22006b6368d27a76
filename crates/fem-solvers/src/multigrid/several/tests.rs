//! What a look at the residual must not pass.

use super::iterate::{Iterate, System};
use super::solve;
use super::{SolveManyInfo, SolveManyParams};
use crate::pcg::PcgError;

/// `A` and `M` are diagonals, the latter a cycle times a number.
struct Diagonal {
    matrix: Vec<f64>,
    cycle: f64,
}

impl<const B: usize> System<B> for Diagonal {
    fn product(&self, x: &[[f64; B]], y: &mut [[f64; B]]) {
        for ((y, x), a) in y.iter_mut().zip(x).zip(&self.matrix) {
            *y = x.map(|x| a * x);
        }
    }

    fn cycle(&self, r: &[[f64; B]], z: &mut [[f64; B]]) {
        for (z, r) in z.iter_mut().zip(r) {
            *z = r.map(|r| self.cycle * r);
        }
    }
}

fn stretched(cycle: f64) -> Diagonal {
    Diagonal {
        matrix: (1..=20).map(f64::from).collect(),
        cycle,
    }
}

/// After iterations on a sound cycle, a residual that another one gives no positive size.
#[test]
fn a_residual_without_a_positive_size_is_an_error() {
    let b: Vec<[f64; 2]> = (0..20).map(|k| [0.0, 1.0 + 0.1 * f64::from(k)]).collect();
    for unsound in [-1.0, 0.0] {
        let mut iterate = Iterate::new(b.clone());
        assert!(iterate.run(&stretched(1.0), 1e-3, 100).unwrap());
        let iteration = iterate.longest();
        assert!((4..20).contains(&iteration));
        let looked = iterate.look(&stretched(unsound), &b, 1e-3);
        assert_eq!(looked, Err(PcgError::Preconditioner { iteration }));
    }
    // A column of zeros has none either, and is exact.
    let mut iterate = Iterate::new(b.clone());
    assert!(iterate.run(&stretched(1.0), 1e-3, 100).unwrap());
    let error = iterate.look(&stretched(1.0), &b, 1e-3).unwrap();
    assert!(error > 1e-7 && error <= 1e-3, "{error:e}");
}

/// Twenty entries of 1e307 are numbers, and so are all products with them, but not their sum.
#[test]
fn an_energy_that_overflows_measures_no_error() {
    let tiny = Diagonal {
        matrix: (0..20)
            .map(|k| (1.0 + 1e-3 * f64::from(k)) * 1e-307)
            .collect(),
        cycle: 1e200,
    };
    let solved = |columns: &mut [f64]| solve::<1>(&tiny, columns, 20, &SolveManyParams::default());
    let error = solved(&mut [1.0; 20]).unwrap_err();
    let of_energy = matches!(&error, PcgError::NonFinite { what, .. } if what.contains("energy"));
    assert!(of_energy, "{error}");
    // An entry alone has an energy.
    let mut one = [0.0; 20];
    one[3] = 1.0;
    solved(&mut one).unwrap();
    assert!((one[3] * tiny.matrix[3] - 1.0).abs() < 1e-9);
}

/// The first step after a look goes along the residual that it took, as from any start.
#[test]
fn a_column_starts_again_from_where_it_stands() {
    let system = stretched(1.0);
    let b: Vec<[f64; 1]> = (0..20).map(|k| [1.0 + 0.1 * f64::from(k)]).collect();
    let mut iterate = Iterate::new(b.clone());
    assert!(iterate.run(&system, 1e-3, 100).unwrap());
    let before = iterate.x.clone();
    // It takes another right-hand side for its own.
    let other: Vec<[f64; 1]> = b.iter().rev().copied().collect();
    assert!(iterate.look(&system, &other, 1e-3).unwrap() > 0.1);
    let most = iterate.longest() + 1;
    assert!(!iterate.run(&system, 1e-3, most).unwrap());
    let ax = before.iter().zip(&system.matrix).map(|(x, a)| a * x[0]);
    let r: Vec<f64> = other.iter().zip(ax).map(|(b, ax)| b[0] - ax).collect();
    let curvature = r.iter().zip(&system.matrix).map(|(r, a)| a * r * r);
    let alpha = r.iter().map(|r| r * r).sum::<f64>() / curvature.sum::<f64>();
    for ((x, before), r) in iterate.x.iter().zip(&before).zip(&r) {
        assert!((x[0] - before[0] - alpha * r).abs() < 1e-12);
    }
    // What its last iterations gained before says nothing now.
    assert!(iterate.run(&system, 1e-3, 100).unwrap());
    let exact = |(b, a): (&[f64; 1], &f64)| b[0] / a;
    let exact: Vec<f64> = other.iter().zip(&system.matrix).map(exact).collect();
    let energy = |v: &mut dyn Iterator<Item = f64>| {
        v.zip(&system.matrix).map(|(v, a)| a * v * v).sum::<f64>()
    };
    let off = energy(&mut exact.iter().zip(&iterate.x).map(|(e, x)| e - x[0]));
    let share = (off / energy(&mut exact.iter().copied())).sqrt();
    assert!(share < 3e-3, "{share:e}");
}

/// Four iterations from each start, however little the last ones gained.
#[test]
fn an_estimate_takes_four_iterations_from_every_start() {
    let system = stretched(1.0);
    let b: Vec<[f64; 1]> = (0..20).map(|k| [1.0 + 0.1 * f64::from(k)]).collect();
    let mut iterate = Iterate::new(b.clone());
    assert!(iterate.run(&system, 1e-3, 100).unwrap());
    let first = iterate.longest();
    // To go on, it is asked for more.
    assert!(iterate.look(&system, &b, 1e-12).unwrap() > 1e-12);
    assert!(iterate.run(&system, 1e-3, 100).unwrap());
    assert_eq!(iterate.longest(), first + 4);
}

#[test]
fn the_largest_error_of_all_columns_is_told() {
    let of = |iterations, error| SolveManyInfo { iterations, error };
    assert_eq!(of(3, 0.5).and(of(4, 0.2)), of(7, 0.5));
    assert_eq!(of(3, 0.1).and(of(4, 0.2)), of(7, 0.2));
}
