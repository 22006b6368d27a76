//! Dense Householder QR with column pivoting (Businger & Golub 1965), column-major.

use crate::vector::{axpy, dot, norm};

/// `A P = Q R` of an `m × n` matrix; reflectors below the diagonal, `R` on and above it.
#[derive(Clone, Debug)]
pub(crate) struct PivotedQr {
    rows: usize,
    columns: usize,
    a: Vec<f64>,
    tau: Vec<f64>,
    pivots: Vec<usize>,
}

impl PivotedQr {
    /// Factors `a` (column-major, `rows × columns`), consuming it.
    pub fn new(mut a: Vec<f64>, rows: usize, columns: usize) -> Self {
        let steps = rows.min(columns);
        let mut pivots: Vec<usize> = (0..columns).collect();
        let mut tau = vec![0.0; steps];
        for k in 0..steps {
            let tail = |a: &[f64], j: usize| norm(&a[j * rows + k..(j + 1) * rows]);
            // First longest remaining column.
            let mut longest = (k, tail(&a, k));
            for j in k + 1..columns {
                let length = tail(&a, j);
                if length > longest.1 {
                    longest = (j, length);
                }
            }
            let (j, length) = longest;
            if j != k {
                let (left, right) = a.split_at_mut(j * rows);
                left[k * rows..(k + 1) * rows].swap_with_slice(&mut right[..rows]);
                pivots.swap(j, k);
            }
            if !(length > 0.0) {
                continue;
            }
            // H = I − τ v vᵀ with v₀ = 1 sends the column to −sign(a₀) ‖a‖ e₀.
            let (left, right) = a.split_at_mut((k + 1) * rows);
            let v = &mut left[k * rows + k..];
            let head = -length.copysign(v[0]);
            let scale = v[0] - head;
            tau[k] = -scale / head;
            v[1..].iter_mut().for_each(|x| *x /= scale);
            v[0] = head;
            for column in right.chunks_mut(rows) {
                let c = &mut column[k..];
                let s = tau[k] * (c[0] + dot(&v[1..], &c[1..]));
                c[0] -= s;
                axpy(-s, &v[1..], &mut c[1..]);
            }
        }
        Self {
            rows,
            columns,
            a,
            tau,
            pivots,
        }
    }

    /// Number of diagonal entries of `R` above `max(m, n) ε |R₀₀|`.
    pub fn rank(&self) -> usize {
        self.rank_of(self.rows)
    }

    /// The same where the rows are what is left of so many.
    pub fn rank_of(&self, rows: usize) -> usize {
        let r = |k: usize| self.a[k * self.rows + k].abs();
        let steps = self.tau.len();
        if steps == 0 || !(r(0) > 0.0) {
            return 0;
        }
        let tolerance = rows.max(self.columns) as f64 * f64::EPSILON * r(0);
        (0..steps).take_while(|&k| r(k) > tolerance).count()
    }

    /// Index of the column that was eliminated at step `k`.
    pub fn pivot(&self, k: usize) -> usize {
        self.pivots[k]
    }

    /// A minimizer of `‖A x − b‖` with zeros for the columns beyond the rank.
    pub fn least_squares(&self, b: &[f64]) -> Vec<f64> {
        let m = self.rows;
        let mut y = b.to_vec();
        for k in 0..self.tau.len() {
            let v = &self.a[k * m + k + 1..(k + 1) * m];
            let s = self.tau[k] * (y[k] + dot(v, &y[k + 1..]));
            y[k] -= s;
            axpy(-s, v, &mut y[k + 1..]);
        }
        let rank = self.rank();
        let mut x = vec![0.0; self.columns];
        for k in (0..rank).rev() {
            let value = y[k] / self.a[k * m + k];
            x[self.pivots[k]] = value;
            for i in 0..k {
                y[i] -= self.a[k * m + i] * value;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::PivotedQr;

    fn product(columns: &[[f64; 3]], x: &[f64]) -> [f64; 3] {
        std::array::from_fn(|i| columns.iter().zip(x).map(|(c, x)| c[i] * x).sum())
    }

    /// The third column is the sum of the others and the longest: it is taken first, one is left out,
    /// and what remains of b is at right angles to all three, whatever the unit.
    #[test]
    fn dependent_columns_are_left_out_in_every_unit() {
        let b = [1.0, 2.0, 3.0];
        for unit in [1.0, 1e-150, 1e150] {
            let columns = [[1.0, 1e-9, 0.0], [3.0, 1.0, 2.0], [4.0, 1.0 + 1e-9, 2.0]];
            let columns = columns.map(|c| c.map(|v| v * unit));
            let qr = PivotedQr::new(columns.as_flattened().to_vec(), 3, 3);
            assert_eq!((qr.rank(), qr.pivot(0)), (2, 2), "{unit:e}");
            let x = qr.least_squares(&b);
            assert_eq!(x.iter().filter(|x| **x == 0.0).count(), 1);
            let reached = product(&columns, &x);
            for column in columns {
                let left: f64 = (0..3).map(|i| column[i] / unit * (b[i] - reached[i])).sum();
                assert!(left.abs() < 1e-13, "{unit:e}: {left:e}");
            }
        }
        // A small column first must not hide a large one.
        let qr = PivotedQr::new(vec![1e-20, 0.0, 0.0, 0.0, 1.0, 0.0], 3, 2);
        assert_eq!((qr.rank(), qr.pivot(0)), (1, 1));
    }

    /// Nearly along the first axis the reflection goes to the far side, or all digits cancel.
    #[test]
    fn a_column_along_the_first_axis_keeps_its_digits() {
        for sign in [1.0, -1.0] {
            let qr = PivotedQr::new(vec![sign, 1e-9], 2, 1);
            let [x] = qr.least_squares(&[0.0, 1.0])[..] else {
                panic!("one unknown")
            };
            assert!((x / 1e-9 - 1.0).abs() < 1e-14, "{x:e}");
        }
    }
}
