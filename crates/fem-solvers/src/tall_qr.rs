//! The triangle that a tall matrix leaves of a least-squares problem.

use crate::parallel::map;
use fem_kinematics::{Kernel, dispatch};

/// Rows that are eliminated together: with a hundred or two columns they stay in a cache of their own.
const ROWS: usize = 256;
/// Numbers of a matrix that are worth a thread, and most threads' worth.
const WORTH: usize = 1 << 19;
const MOST: usize = 8;

/// `(R, c)` with `‖r + J d‖ = ‖c + R d‖` for every `d`, `J` with these `n` columns: `R` upper triangular,
/// column-major, `n + 1` rows a column.
///
/// Householder reflections of `[J r]`, a few rows at a time below the triangle of those before (Golub and
/// Van Loan, 12.5.3 in the third edition), so that each number of `J` is read from memory once and the rest
/// happens in a cache: 2 m n² flops, as for any QR. Runs of rows have triangles of their own, joined at
/// the end; the runs depend on the sizes alone.
pub(crate) fn triangle(columns: &[&[f64]], r: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (m, width) = (r.len(), columns.len() + 1);
    let runs = (m * width / WORTH).clamp(1, MOST);
    let run = |k: usize| {
        let mut upper = vec![0.0; width * width];
        let (mut begin, end) = (m * k / runs, m * (k + 1) / runs);
        while begin < end {
            let rows = ROWS.min(end - begin);
            let all = columns.iter().chain([&r]);
            let block: Vec<&[f64]> = all.map(|c| &c[begin..begin + rows]).collect();
            absorb(&mut upper, &mut block.concat(), rows);
            begin += rows;
        }
        upper
    };
    let parts: Vec<Vec<f64>> = map((0..runs).collect(), run);
    let mut parts = parts.into_iter();
    let mut upper = parts.next().unwrap_or_default();
    for mut part in parts {
        absorb(&mut upper, &mut part, width);
    }
    let right = upper.split_off((width - 1) * width);
    (upper, right)
}

/// Eliminates a block of rows, column-major, with an upper triangle above it.
fn absorb(upper: &mut [f64], block: &mut [f64], rows: usize) {
    let width = block.len() / rows;
    dispatch(Absorb {
        upper,
        block,
        rows,
        width,
    });
}

struct Absorb<'a> {
    upper: &'a mut [f64],
    block: &'a mut [f64],
    rows: usize,
    width: usize,
}

impl Kernel for Absorb<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (rows, width) = (self.rows, self.width);
        for k in 0..width {
            let (left, right) = self.block.split_at_mut((k + 1) * rows);
            let v = &mut left[k * rows..];
            let (head, below) = (self.upper[k * width + k], dot(v, v));
            if below == 0.0 {
                continue;
            }
            // H = I − τ w wᵀ, w = (1, v), sends (head, v) to −sign(head) of its length.
            let end = -(head * head + below).sqrt().copysign(head);
            let (first, tau) = (head - end, (end - head) / end);
            v.iter_mut().for_each(|v| *v /= first);
            self.upper[k * width + k] = end;
            let above = self.upper[(k + 1) * width..].chunks_exact_mut(width);
            for (column, above) in right.chunks_exact_mut(rows).zip(above) {
                let s = tau * (above[k] + dot(v, column));
                above[k] -= s;
                for (c, v) in column.iter_mut().zip(&*v) {
                    *c -= s * v;
                }
            }
        }
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<16>(), b.as_chunks::<16>());
    let mut lanes = [0.0; 16];
    for (a, b) in a.iter().zip(b) {
        for k in 0..16 {
            lanes[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::triangle;

    fn wave(k: usize) -> f64 {
        (1.3 * k as f64 + 0.2 * (k as f64).sqrt()).sin()
    }

    /// Entry (a, b) of [J r]ᵀ [J r].
    fn product(rows: usize, columns: &[&[f64]], a: usize, b: usize) -> f64 {
        (0..rows).map(|i| columns[a][i] * columns[b][i]).sum()
    }

    #[test]
    fn lengths_and_products_stay() {
        for (m, n) in [(1, 1), (7, 3), (3, 7), (257, 5), (1_000, 40), (60_000, 20)] {
            let j: Vec<f64> = (0..m * n).map(wave).collect();
            let r: Vec<f64> = (0..m).map(|k| wave(7 * k + 1)).collect();
            let (upper, right) = triangle(&j.chunks(m).collect::<Vec<_>>(), &r);
            assert_eq!((upper.len(), right.len()), ((n + 1) * n, n + 1));
            let mut before: Vec<&[f64]> = j.chunks(m).collect();
            let mut after: Vec<&[f64]> = upper.chunks(n + 1).collect();
            before.push(&r);
            after.push(&right);
            for a in 0..=n {
                assert!(after[a][a + 1..].iter().all(|&below| below == 0.0));
                for b in 0..=a {
                    let apart = product(m, &before, a, b) - product(n + 1, &after, a, b);
                    assert!(
                        apart.abs() < 1e-14 * m as f64 + 1e-13,
                        "{m} {n} {a} {b}: {apart:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn columns_that_are_equal_stay_equal() {
        let m = 900;
        let column: Vec<f64> = (0..m).map(wave).collect();
        let (upper, _) = triangle(&[&column, &column], &vec![1.0; m]);
        assert_eq!(upper[0], upper[3]);
        assert!(upper[4].abs() < 1e-13, "{:e}", upper[4]);
    }

    #[test]
    fn what_is_no_number_stays_none() {
        let mut j = vec![1.0; 600];
        j[500] = f64::NAN;
        let (upper, _) = triangle(&[&j], &vec![1.0; 600]);
        assert!(upper[0].is_nan());
    }
}
