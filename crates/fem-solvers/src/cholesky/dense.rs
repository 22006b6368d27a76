//! Dense kernels of one front.

use crate::parallel::join;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor as llt;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

mod sealed {
    use faer::{MatMut, MatRef};

    /// What is done with a scalar in a front. Each method has a body for `f32` and one for `f64`, so
    /// that faer's kernels are compiled with this crate and not with every crate that factors.
    pub trait Sealed: faer::traits::RealField {
        fn eliminate(
            panel: &mut [Self],
            height: usize,
            columns: usize,
            update: &mut [Self],
        ) -> Result<(), usize>;
        fn forward(
            panel: &[Self],
            height: usize,
            columns: usize,
            x: MatMut<'_, Self>,
            z: MatMut<'_, Self>,
        );
        fn backward(
            panel: &[Self],
            height: usize,
            columns: usize,
            x: MatMut<'_, Self>,
            z: MatRef<'_, Self>,
        );
    }
}

macro_rules! compiled_here {
    ($scalar:ty) => {
        impl sealed::Sealed for $scalar {
            fn eliminate(
                panel: &mut [Self],
                height: usize,
                columns: usize,
                update: &mut [Self],
            ) -> Result<(), usize> {
                eliminate(panel, height, columns, update)
            }
            fn forward(
                panel: &[Self],
                height: usize,
                columns: usize,
                x: MatMut<'_, Self>,
                z: MatMut<'_, Self>,
            ) {
                forward(panel, height, columns, x, z);
            }
            fn backward(
                panel: &[Self],
                height: usize,
                columns: usize,
                x: MatMut<'_, Self>,
                z: MatRef<'_, Self>,
            ) {
                backward(panel, height, columns, x, z);
            }
        }
    };
}
compiled_here!(f32);
compiled_here!(f64);

/// The precision of a factor: `f64`, or `f32` with half the memory and twice the speed.
pub trait FactorScalar: Copy + Send + Sync + sealed::Sealed + 'static {
    /// A pivot that is no more than this share of its diagonal entry is rounding: the matrix is
    /// singular. 0 where a factor is a preconditioner, whose user sees what it is worth.
    const SINGULAR: f64;
    /// Rounds.
    fn from_f64(value: f64) -> Self;
    /// Widens.
    fn to_f64(self) -> f64;
}

impl FactorScalar for f64 {
    const SINGULAR: f64 = 256.0 * f64::EPSILON;
    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
}

impl FactorScalar for f32 {
    const SINGULAR: f64 = 0.0;
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

/// Columns eliminated at a time in a wide front.
const PANEL: usize = 512;
/// Multiplications above which an update is split in two tasks. The split depends on sizes alone and
/// every part runs on one thread, so that the bits do not depend on the number of threads.
const SPLIT: usize = 40_000_000;
/// Narrowest part worth a task.
const NARROW: usize = 128;

/// Eliminates the first `columns` of a front of `height` rows: `panel` becomes the columns of `L`,
/// `update` (column-major, lower half, `height − columns` squared) loses `L₂₁ L₂₁ᵀ`.
///
/// `Err` is the column whose pivot is not positive.
fn eliminate<T: FactorScalar>(
    panel: &mut [T],
    height: usize,
    columns: usize,
    update: &mut [T],
) -> Result<(), usize> {
    let mut panel = MatMut::from_column_major_slice_mut(panel, height, columns);
    let mut begin = 0;
    while begin < columns {
        let left = columns - begin;
        let width = if left <= PANEL + NARROW { left } else { PANEL };
        let trailing = panel
            .rb_mut()
            .submatrix_mut(begin, begin, height - begin, left);
        let (current, rest) = trailing.split_at_col_mut(width);
        let (mut pivot, mut below) = current.split_at_row_mut(width);
        factor_pivot(pivot.rb_mut()).map_err(|k| begin + k)?;
        solve_rows(pivot.rb(), below.rb_mut());
        if left > width {
            subtract_square(rest.split_at_row_mut(width).1, below.rb());
        }
        begin += width;
    }
    let rows = height - columns;
    if rows > 0 {
        let below = panel.rb().split_at_row(columns).1;
        subtract_square(
            MatMut::from_column_major_slice_mut(update, rows, rows),
            below,
        );
    }
    Ok(())
}

/// `A = L Lᵀ` in place, lower half.
///
/// faer tests every pivot `a` where it is made, `a > 0` and `√a` finite, and stores `a · (1/√a)`, which
/// is then positive and finite too. A second test here could not fail; that the first one stays is
/// pinned below.
fn factor_pivot<T: FactorScalar>(mut pivot: MatMut<'_, T>) -> Result<(), usize> {
    let n = pivot.nrows();
    let scratch = llt::cholesky_in_place_scratch::<T>(n, Par::Seq, Default::default());
    llt::cholesky_in_place(
        pivot.rb_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map(|_| ())
    .map_err(|llt::LltError::NonPositivePivot { index }| index)
}

/// `B ← B L⁻ᵀ`, by rows.
fn solve_rows<T: FactorScalar>(l: MatRef<'_, T>, mut b: MatMut<'_, T>) {
    let rows = b.nrows();
    if rows == 0 {
        return;
    }
    if rows * l.nrows() * l.nrows() > SPLIT && rows >= 2 * NARROW {
        let (top, bottom) = b.split_at_row_mut(rows / 2);
        join(|| solve_rows(l, top), || solve_rows(l, bottom));
    } else {
        triangular_solve::solve_lower_triangular_in_place(l, b.rb_mut().transpose_mut(), Par::Seq);
    }
}

/// `C ← C − A A₁ᵀ` on and below the diagonal of `C` (`p × q`, `p ≥ q`), with `A₁` the first `q` rows of `A`.
fn subtract_square<T: FactorScalar>(c: MatMut<'_, T>, a: MatRef<'_, T>) {
    let (p, q) = (c.nrows(), c.ncols());
    if p * q * a.ncols() > SPLIT && q >= 2 * NARROW {
        let half = q / 2;
        let (left, right) = c.split_at_col_mut(half);
        let right = right.split_at_row_mut(half).1;
        join(
            || subtract_square(left, a),
            || subtract_square(right, a.split_at_row(half).1),
        );
        return;
    }
    let (square, below) = c.split_at_row_mut(q);
    let (a_square, a_below) = a.split_at_row(q);
    let minus_one = T::from_f64(-1.0);
    triangular::matmul(
        square,
        BlockStructure::TriangularLower,
        Accum::Add,
        a_square,
        BlockStructure::Rectangular,
        a_square.transpose(),
        BlockStructure::Rectangular,
        minus_one,
        Par::Seq,
    );
    if p > q {
        matmul::matmul(
            below,
            Accum::Add,
            a_below,
            a_square.transpose(),
            minus_one,
            Par::Seq,
        );
    }
}

/// `x ← L₁₁⁻¹ x`, then `z ← z − L₂₁ x`.
fn forward<T: FactorScalar>(
    panel: &[T],
    height: usize,
    columns: usize,
    mut x: MatMut<'_, T>,
    z: MatMut<'_, T>,
) {
    let (pivot, below) =
        MatRef::from_column_major_slice(panel, height, columns).split_at_row(columns);
    triangular_solve::solve_lower_triangular_in_place(pivot, x.rb_mut(), Par::Seq);
    if height > columns {
        matmul::matmul(z, Accum::Add, below, x.rb(), T::from_f64(-1.0), Par::Seq);
    }
}

/// `x ← L₁₁⁻ᵀ (x − L₂₁ᵀ z)`.
fn backward<T: FactorScalar>(
    panel: &[T],
    height: usize,
    columns: usize,
    mut x: MatMut<'_, T>,
    z: MatRef<'_, T>,
) {
    let (pivot, below) =
        MatRef::from_column_major_slice(panel, height, columns).split_at_row(columns);
    if height > columns {
        matmul::matmul(
            x.rb_mut(),
            Accum::Add,
            below.transpose(),
            z,
            T::from_f64(-1.0),
            Par::Seq,
        );
    }
    triangular_solve::solve_upper_triangular_in_place(pivot.transpose(), x, Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four times the identity with one other pivot: narrow, vectorized and blocked kernels.
    fn refuses<T: FactorScalar>(bad: f64) {
        for n in [1, 2, 7, 33, 130, 300] {
            for at in [0, n / 2, n - 1] {
                let mut a = vec![T::from_f64(0.0); n * n];
                for k in 0..n {
                    a[k * n + k] = T::from_f64(if k == at { bad } else { 4.0 });
                }
                let pivot = MatMut::from_column_major_slice_mut(&mut a, n, n);
                assert_eq!(factor_pivot(pivot), Err(at), "{bad} at {at} of {n}");
            }
        }
    }

    #[test]
    fn a_pivot_that_is_no_positive_finite_number_is_refused() {
        for bad in [f64::INFINITY, f64::NAN, 0.0, -0.0, -1e-300, -1.0] {
            refuses::<f64>(bad);
            refuses::<f32>(bad);
        }
    }

    #[test]
    fn the_smallest_and_the_largest_pivot_leave_a_positive_finite_root() {
        for (a, tolerance) in [(f64::from_bits(1), 1e-10), (f64::MAX, 1e-15)] {
            let mut pivot = [a];
            let view = MatMut::from_column_major_slice_mut(&mut pivot, 1, 1);
            assert_eq!(factor_pivot(view), Ok(()));
            assert!((pivot[0] / a.sqrt() - 1.0).abs() < tolerance, "{pivot:?}");
        }
    }
}
