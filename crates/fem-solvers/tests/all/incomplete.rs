//! The incomplete factor of bodies that are large enough to be taken from both ends.

use crate::common::{grid_matrix, max_abs};
use fem_solvers::{
    BlockIc0, BlockPattern, BlockSymmetric, LinearOperator, MatrixPreconditioner, Preconditioner,
};
use std::sync::Arc;

/// Blocks that are not symmetric, joined as said: where nothing fills in, the factor is exact.
fn joined<const D: usize>(
    blocks: usize,
    pairs: impl Iterator<Item = (usize, usize)>,
) -> BlockSymmetric<D> {
    let pattern = Arc::new(BlockPattern::from_adjacency(blocks, pairs).unwrap());
    let mut a = BlockSymmetric::<D>::zeros(pattern.clone());
    for (k, block) in a.values_mut().iter_mut().enumerate() {
        for r in 0..D {
            for c in 0..D {
                block[r][c] = 0.3 * ((1 + r + 3 * c) as f64 * (1 + k) as f64).sin();
            }
        }
    }
    for i in 0..blocks {
        let diagonal = pattern.diagonal(i);
        for r in 0..D {
            for c in 0..D {
                a.values_mut()[diagonal][r][c] = if r == c { 4.0 } else { 0.5 };
            }
        }
    }
    a
}

fn sines(length: usize) -> Vec<f64> {
    (0..length).map(|i| (0.7 * i as f64).sin()).collect()
}

fn applied<const D: usize>(m: &BlockIc0<D>, r: &[f64]) -> Vec<f64> {
    let mut z = vec![f64::NAN; r.len()];
    m.apply(r, &mut z);
    z
}

fn is_exact<const D: usize>(a: &BlockSymmetric<D>) {
    let r = sines(a.dim());
    let z = applied(&BlockIc0::new(a).unwrap(), &r);
    let mut back = vec![0.0; r.len()];
    a.apply(&z, &mut back);
    back.iter_mut().zip(&r).for_each(|(b, r)| *b -= r);
    assert!(max_abs(&back) < 1e-5, "{D}: {}", max_abs(&back));
}

#[test]
fn a_chain_from_both_ends_has_no_fill() {
    let chain = || (1..5_000).map(|i| (i - 1, i));
    is_exact(&joined::<1>(5_000, chain()));
    is_exact(&joined::<2>(5_000, chain()));
    is_exact(&joined::<3>(5_000, chain()));
    is_exact(&joined::<4>(5_000, chain()));
}

#[test]
fn a_numbering_that_joins_both_halves_everywhere_is_taken_as_it_is() {
    is_exact(&joined::<3>(5_000, (0..2_500).map(|i| (i, i + 2_500))));
}

#[test]
fn every_unit_gives_the_same_digits() {
    for blocks in [60, 5_000] {
        let a = joined::<3>(blocks, (1..blocks).map(|i| (i - 1, i)));
        let r = sines(a.dim());
        let plain = applied(&BlockIc0::new(&a).unwrap(), &r);
        for (matrix, vector) in [(300, -400), (-300, 400), (-500, -1000), (900, 100)] {
            let (of_matrix, of_vector) = (f64::from(matrix).exp2(), f64::from(vector).exp2());
            let mut scaled = a.clone();
            let entries = scaled.values_mut().iter_mut().flatten().flatten();
            entries.for_each(|v| *v *= of_matrix);
            let r: Vec<f64> = r.iter().map(|r| r * of_vector).collect();
            let z = applied(&BlockIc0::new(&scaled).unwrap(), &r);
            let expected: Vec<f64> = plain.iter().map(|z| z * of_vector / of_matrix).collect();
            assert_eq!(z, expected, "2^{matrix}, 2^{vector}");
        }
    }
}

#[test]
fn it_is_symmetric_and_has_the_same_bits_on_any_number_of_threads() {
    let (a, _) = grid_matrix::<3>([17, 17, 20]);
    let (u, v) = (sines(a.dim()), sines(2 * a.dim())[a.dim()..].to_vec());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut ic = BlockIc0::default();
            ic.update(&a).unwrap();
            (applied(&ic, &u), applied(&ic, &v))
        })
    };
    let (mu, mv) = on(1);
    assert_eq!((mu.clone(), mv.clone()), on(2));
    assert_eq!((mu.clone(), mv.clone()), on(3));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (vmu, umv) = (dot(&v, &mu), dot(&u, &mv));
    assert!((vmu - umv).abs() < 1e-5 * dot(&u, &mu), "{vmu} {umv}");
}
