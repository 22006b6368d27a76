//! The largest eigenvalue of `D⁻¹A`.

use super::matrix::LevelMatrix;
use super::precision::LevelScalar;

/// Lanczos steps; the estimate is then low by a few percent, which the margin makes up for.
const STEPS: usize = 12;
const MARGIN: f64 = 1.1;

/// An upper estimate of the largest eigenvalue of `D⁻¹A`, `D` the block diagonal: Lanczos' method, as
/// the coefficients of conjugate gradients, from a fixed start. `None` where a direction of negative
/// curvature or a number that is not finite turns up.
pub(super) fn largest_eigenvalue<T: LevelScalar, const D: usize>(
    matrix: &LevelMatrix<T, D>,
) -> Option<f64> {
    let n = matrix.rows.len();
    let mut r = start::<T, D>(n);
    let mut z = vec![[T::default(); D]; n];
    let mut p = z.clone();
    let mut ap = z.clone();
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let (mut rz, mut alpha, mut beta) = (0.0, 1.0, 0.0);
    for step in 0..STEPS {
        matrix.apply_inverse_diagonal(&r, &mut z);
        let new = dot(&r, &z);
        if step > 0 {
            beta = new / rz;
            if !(new > 1e-10 * rz) {
                break;
            }
            beside.push(beta.sqrt() / alpha);
        }
        if !(new > 0.0 && new.is_finite()) {
            return None;
        }
        rz = new;
        let b = T::narrow(beta);
        for (p, z) in p.iter_mut().zip(&z) {
            for c in 0..D {
                p[c] = z[c] + b * p[c];
            }
        }
        matrix.apply(&p, &mut ap);
        let curvature = dot(&p, &ap);
        if !(curvature > 0.0 && curvature.is_finite()) {
            return None;
        }
        let before = if step > 0 { beta / alpha } else { 0.0 };
        alpha = rz / curvature;
        diagonal.push(1.0 / alpha + before);
        let a = T::narrow(alpha);
        for (r, ap) in r.iter_mut().zip(&ap) {
            for c in 0..D {
                r[c] -= a * ap[c];
            }
        }
    }
    beside.truncate(diagonal.len() - 1);
    Some(MARGIN * largest_of_tridiagonal(&diagonal, &beside))
}

/// Numbers in (−1, 1) without a pattern, the same everywhere (Knuth's MMIX generator).
fn start<T: LevelScalar, const D: usize>(n: usize) -> Vec<[T; D]> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        T::narrow((state >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    };
    (0..n).map(|_| std::array::from_fn(|_| next())).collect()
}

fn dot<T: LevelScalar, const D: usize>(a: &[[T; D]], b: &[[T; D]]) -> f64 {
    let mut lanes = [0.0; D];
    for (a, b) in a.iter().zip(b) {
        for c in 0..D {
            lanes[c] += a[c].widen() * b[c].widen();
        }
    }
    lanes.iter().sum()
}

/// By bisection on the signs of the pivots of `T − λ I` (Sturm).
fn largest_of_tridiagonal(diagonal: &[f64], beside: &[f64]) -> f64 {
    let at = |k: usize| beside.get(k).copied().unwrap_or(0.0).abs();
    let left = |k: usize| if k > 0 { at(k - 1) } else { 0.0 };
    let ends = diagonal
        .iter()
        .enumerate()
        .map(|(k, d)| d + at(k) + left(k));
    let mut high = ends.fold(0.0_f64, f64::max);
    let mut low = diagonal.iter().fold(0.0_f64, |m, d| m.max(*d));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let mut pivot = -1.0;
        let all_below = (0..diagonal.len()).all(|k| {
            let coupling = left(k);
            pivot = diagonal[k] - middle - coupling * coupling / pivot;
            pivot < 0.0
        });
        if all_below {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::{MARGIN, largest_eigenvalue, largest_of_tridiagonal};
    use crate::block_matrix::{BlockPattern, BlockSymmetric};
    use crate::multigrid::matrix::LevelMatrix;
    use crate::multigrid::rows::Rows;
    use std::sync::Arc;

    #[test]
    fn the_second_difference_has_the_eigenvalue_of_its_closed_form() {
        for n in 1..20 {
            let angle = std::f64::consts::PI * n as f64 / (n + 1) as f64;
            let found = largest_of_tridiagonal(&vec![2.0; n], &vec![-1.0; n - 1]);
            assert!(
                (found - (2.0 - 2.0 * angle.cos())).abs() < 1e-12,
                "{n}: {found}"
            );
        }
    }
    /// As many steps as rows find all of the spectrum: 1 − cos(π k/(n + 1)) of a chain.
    #[test]
    fn a_chain_of_few_rows_has_the_eigenvalue_of_its_closed_form() {
        for n in [1_usize, 2, 3, 7, 10] {
            let pattern = BlockPattern::from_adjacency(n, (1..n).map(|i| (i - 1, i))).unwrap();
            let pattern = Arc::new(pattern);
            let mut chain = BlockSymmetric::<1>::zeros(pattern.clone());
            chain.values_mut().fill([[-3.0]]);
            (0..n).for_each(|i| chain.values_mut()[pattern.diagonal(i)] = [[6.0]]);
            let mut level = LevelMatrix::<f64, 1>::new(Rows::new(&pattern));
            level.update(&chain, 1.0).unwrap();
            let angle = std::f64::consts::PI * n as f64 / (n + 1) as f64;
            let exact = MARGIN * (1.0 - angle.cos());
            let found = largest_eigenvalue(&level).unwrap();
            assert!((found - exact).abs() < 1e-9, "{n}: {found} {exact}");
        }
        const { assert!(MARGIN > 1.05) };
    }
}
