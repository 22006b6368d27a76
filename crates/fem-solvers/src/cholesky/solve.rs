//! Solving with the factor, for one or many right-hand sides.

use super::dense::{FactorScalar, backward, forward};
use super::elimination_tree::NO_PARENT;
use super::factor::CholeskyFactor;
use super::symbolic::Supernode;
use faer::{MatMut, MatRef};

impl<T: FactorScalar, const D: usize> CholeskyFactor<T, D> {
    /// `x ← A⁻¹ x`.
    ///
    /// # Panics
    /// If `x` is not as long as the matrix.
    pub fn solve_in_place(&self, x: &mut [f64]) {
        self.solve_many(x, 1);
    }

    /// `X ← A⁻¹ X` for `ncols` right-hand sides, column-major, as one block solve.
    ///
    /// # Panics
    /// If `x` does not hold `ncols` columns as long as the matrix.
    pub fn solve_many(&self, x: &mut [f64], ncols: usize) {
        let n = self.symbolic.dim();
        assert!(
            x.len() == n * ncols,
            "{} values are not {ncols} columns of length {n}",
            x.len()
        );
        if n == 0 || ncols == 0 {
            return;
        }
        let order = self.symbolic.permutation.order();
        let mut y = vec![T::from_f64(0.0); n * ncols];
        for (y, x) in y.chunks_mut(n).zip(x.chunks(n)) {
            for (new, &old) in order.iter().enumerate() {
                for r in 0..D {
                    y[D * new + r] = T::from_f64(x[D * old as usize + r]);
                }
            }
        }
        self.forward_all(&mut y, ncols);
        self.backward_all(&mut y, ncols);
        for (y, x) in y.chunks(n).zip(x.chunks_mut(n)) {
            for (new, &old) in order.iter().enumerate() {
                for r in 0..D {
                    x[D * old as usize + r] = y[D * new + r].to_f64();
                }
            }
        }
    }

    fn panel(&self, node: &Supernode) -> &[T] {
        &self.panels[node.panel..node.panel + D * D * node.height() * node.width()]
    }

    fn forward_all(&self, y: &mut [T], ncols: usize) {
        let n = self.symbolic.dim();
        for node in &self.symbolic.supernodes {
            let (columns, rows) = (D * node.width(), D * node.rows.len());
            let mut z = vec![T::from_f64(0.0); rows * ncols];
            let x = MatMut::from_column_major_slice_mut(y, n, ncols)
                .subrows_mut(D * node.columns.start, columns);
            forward(
                self.panel(node),
                columns + rows,
                columns,
                x,
                MatMut::from_column_major_slice_mut(&mut z, rows, ncols),
            );
            if rows == 0 {
                continue;
            }
            for (y, z) in y.chunks_mut(n).zip(z.chunks(rows)) {
                for (k, &row) in node.rows.iter().enumerate() {
                    for r in 0..D {
                        y[D * row as usize + r] += z[D * k + r];
                    }
                }
            }
        }
        debug_assert!(
            self.symbolic
                .supernodes
                .last()
                .is_none_or(|s| s.parent == NO_PARENT)
        );
    }

    fn backward_all(&self, y: &mut [T], ncols: usize) {
        let n = self.symbolic.dim();
        for node in self.symbolic.supernodes.iter().rev() {
            let (columns, rows) = (D * node.width(), D * node.rows.len());
            let mut z = vec![T::from_f64(0.0); rows * ncols];
            if rows > 0 {
                for (y, z) in y.chunks(n).zip(z.chunks_mut(rows)) {
                    for (k, &row) in node.rows.iter().enumerate() {
                        z[D * k..D * k + D]
                            .copy_from_slice(&y[D * row as usize..D * row as usize + D]);
                    }
                }
            }
            let x = MatMut::from_column_major_slice_mut(y, n, ncols)
                .subrows_mut(D * node.columns.start, columns);
            backward(
                self.panel(node),
                columns + rows,
                columns,
                x,
                MatRef::from_column_major_slice(&z, rows, ncols),
            );
        }
    }
}
