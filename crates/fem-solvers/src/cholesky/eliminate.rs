//! Elimination of the columns of one front.

use super::dense::FactorScalar;
use super::half::{Half, STRIP};
use super::pool::Pool;
use crate::parallel::{each, join};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor as llt;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;

/// Columns eliminated at a time in a wide front.
const PANEL: usize = 256;
/// Narrowest last panel.
const NARROW: usize = 64;
/// Multiplications above which work is split in two tasks. The split depends on sizes alone and
/// every part runs on one thread, so that the bits do not depend on the number of threads.
const SPLIT: usize = 40_000_000;
/// Rows of a tile, which stays in the second cache.
const TILE: usize = 192;
/// Columns of the factors of a product at a time.
const DEPTH: usize = 512;
/// Columns up to which a triangular solve goes a few columns at a time.
const WIDE: usize = 128;
const FEW: usize = 8;
/// Rows up to which a square is subtracted a few columns at a time, with what is above the diagonal.
const SMALL: usize = 256;
const SMALL_STRIP: usize = 24;

/// Eliminates the first `columns` of a front of `height` rows: `panel` becomes the columns of `L`,
/// `update`, the [`Half`] of the other rows, becomes `−L₂₁ L₂₁ᵀ`.
///
/// `Err` is the column whose pivot is not positive.
pub(super) fn eliminate<T: FactorScalar>(
    panel: &mut [T],
    height: usize,
    columns: usize,
    update: &mut [T],
    pool: &Pool<T>,
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
            let rest = cut(rest.split_at_row_mut(width).1);
            subtract_squares(rest, Accum::Add, below.rb(), pool);
        }
        begin += width;
    }
    let half = Half {
        rows: height - columns,
    };
    if columns == 0 {
        update.fill(T::from_f64(0.0));
    } else if half.rows > 0 {
        let below = panel.rb().split_at_row(columns).1;
        subtract_squares(cut_half(half, update), Accum::Replace, below, pool);
    }
    Ok(())
}

/// The strips of a matrix, each without the rows above its first column.
fn cut<T>(mut matrix: MatMut<'_, T>) -> Vec<MatMut<'_, T>> {
    let mut strips = Vec::with_capacity(matrix.ncols().div_ceil(STRIP));
    while matrix.ncols() > STRIP {
        let (strip, rest) = matrix.split_at_col_mut(STRIP);
        strips.push(strip);
        matrix = rest.split_at_row_mut(STRIP).1;
    }
    strips.push(matrix);
    strips
}

/// The strips of a half.
fn cut_half<T>(half: Half, mut values: &mut [T]) -> Vec<MatMut<'_, T>> {
    let of = |columns: Range<usize>| {
        let (rows, width) = (half.rows - columns.start, columns.len());
        let (strip, rest) = std::mem::take(&mut values).split_at_mut(rows * width);
        values = rest;
        MatMut::from_column_major_slice_mut(strip, rows, width)
    };
    half.strips().map(of).collect()
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

/// `B ← B L⁻ᵀ`.
fn solve_rows<T: FactorScalar>(l: MatRef<'_, T>, b: MatMut<'_, T>) {
    let rows = b.nrows();
    if rows <= TILE {
        return solve_tile(l, b);
    }
    let parallel = rows * l.nrows() * l.nrows() > SPLIT;
    let (top, bottom) = b.split_at_row_mut(half_of(rows, TILE));
    join_if(parallel, || solve_rows(l, top), || solve_rows(l, bottom));
}

/// Half of a length, in whole parts.
fn half_of(length: usize, part: usize) -> usize {
    (length / 2).next_multiple_of(part)
}

fn join_if(parallel: bool, a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if parallel {
        join(a, b);
    } else {
        a();
        b();
    }
}

/// `B ← B L⁻ᵀ` for rows that stay in the second cache.
fn solve_tile<T: FactorScalar>(l: MatRef<'_, T>, mut b: MatMut<'_, T>) {
    let columns = b.ncols();
    if b.nrows() == 0 {
        return;
    }
    if columns > WIDE {
        let half = half_of(columns, WIDE);
        let (mut left, mut right) = b.split_at_col_mut(half);
        solve_tile(l.submatrix(0, 0, half, half), left.rb_mut());
        let (below, corner) = l.split_at_row(half).1.split_at_col(half);
        subtract(right.rb_mut(), Accum::Add, left.rb(), below.transpose());
        return solve_tile(corner, right);
    }
    for begin in (0..columns).step_by(FEW) {
        let few = FEW.min(columns - begin);
        let (left, right) = b.rb_mut().split_at_col_mut(begin);
        let mut own = right.subcols_mut(0, few);
        if begin > 0 {
            let row = l.submatrix(begin, 0, few, begin);
            subtract(own.rb_mut(), Accum::Add, left.rb(), row.transpose());
        }
        solve_lower_triangular_in_place(
            l.submatrix(begin, begin, few, few),
            own.transpose_mut(),
            Par::Seq,
        );
    }
}

/// `C ← C − A B`, or `−A B`.
fn subtract<T: FactorScalar>(c: MatMut<'_, T>, accum: Accum, a: MatRef<'_, T>, b: MatRef<'_, T>) {
    matmul(c, accum, a, b, T::from_f64(-1.0), Par::Seq);
}

/// [`subtract_square`] for each strip of a matrix.
fn subtract_squares<T: FactorScalar>(
    strips: Vec<MatMut<'_, T>>,
    accum: Accum,
    a: MatRef<'_, T>,
    pool: &Pool<T>,
) {
    let rows = a.nrows();
    let with_rows = |c: MatMut<'_, T>| {
        let below = a.split_at_row(rows - c.nrows()).1;
        subtract_square(c, accum, below, pool);
    };
    if rows * rows * a.ncols() > SPLIT {
        each(strips, with_rows);
    } else {
        strips.into_iter().for_each(with_rows);
    }
}

/// `C ← C − A A₁ᵀ`, or `−A A₁ᵀ`, on and below the diagonal of `C` (`p × q`, `p ≥ q`), with `A₁` the
/// first `q` rows of `A`.
fn subtract_square<T: FactorScalar>(
    mut c: MatMut<'_, T>,
    mut accum: Accum,
    a: MatRef<'_, T>,
    pool: &Pool<T>,
) {
    let (p, q) = (c.nrows(), c.ncols());
    if p <= SMALL {
        return subtract_small(c, accum, a);
    }
    let mut transposed = pool.take(q * a.ncols().min(DEPTH));
    for begin in (0..a.ncols()).step_by(DEPTH) {
        let a = a.subcols(begin, DEPTH.min(a.ncols() - begin));
        let (a_square, a_below) = a.split_at_row(q);
        let depth = a.ncols();
        let transposed = &mut transposed[..depth * q];
        let mut right = MatMut::from_column_major_slice_mut(transposed, depth, q);
        right.copy_from(a_square.transpose());
        let (square, below) = c.rb_mut().split_at_row_mut(q);
        triangular::matmul(
            square,
            BlockStructure::TriangularLower,
            accum,
            a_square,
            BlockStructure::Rectangular,
            right.rb(),
            BlockStructure::Rectangular,
            T::from_f64(-1.0),
            Par::Seq,
        );
        subtract_tiles(below, accum, a_below, right.rb());
        accum = Accum::Add;
    }
}

/// [`subtract_square`] of few rows.
fn subtract_small<T: FactorScalar>(mut c: MatMut<'_, T>, accum: Accum, a: MatRef<'_, T>) {
    let (p, q) = (c.nrows(), c.ncols());
    for begin in (0..q).step_by(SMALL_STRIP) {
        let few = SMALL_STRIP.min(q - begin);
        let strip = c.rb_mut().submatrix_mut(begin, begin, p - begin, few);
        let a = a.split_at_row(begin).1;
        subtract(strip, accum, a, a.subrows(0, few).transpose());
    }
}

/// [`subtract`], by rows.
fn subtract_tiles<T: FactorScalar>(
    c: MatMut<'_, T>,
    accum: Accum,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
) {
    let rows = c.nrows();
    if rows <= TILE {
        return subtract(c, accum, a, b);
    }
    let parallel = rows * c.ncols() * a.ncols() > SPLIT;
    let (top, bottom) = c.split_at_row_mut(half_of(rows, TILE));
    let (a_top, a_bottom) = a.split_at_row(top.nrows());
    join_if(
        parallel,
        || subtract_tiles(top, accum, a_top, b),
        || subtract_tiles(bottom, accum, a_bottom, b),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever was in memory, `panel` and `update` of a front are those of the textbook.
    fn agrees<T: FactorScalar>(columns: usize, rows: usize, tolerance: f64) {
        let height = columns + rows;
        let entry = |i: usize, j: usize| {
            let far = ((i * 7 + j * 3) as f64).sin() / height as f64;
            if i == j { 3.0 + far } else { far }
        };
        let nothing = T::from_f64(f64::NAN);
        let mut panel = vec![nothing; height * columns];
        let mut l = vec![vec![0.0; columns]; height];
        for j in 0..columns {
            for i in j..height {
                panel[j * height + i] = T::from_f64(entry(i, j));
                let inner: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                let rest = entry(i, j) - inner;
                l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
            }
        }
        let half = Half { rows };
        let mut update = vec![nothing; half.len()];
        let pool = Pool::new();
        pool.take(rows * columns).fill(nothing);
        let outcome = eliminate(&mut panel, height, columns, &mut update, &pool);
        assert_eq!(outcome, Ok(()));
        let close = |found: T, expected: f64| (found.to_f64() - expected).abs() < tolerance;
        for j in 0..columns {
            for i in j..height {
                assert!(
                    close(panel[j * height + i], l[i][j]),
                    "{columns} + {rows}: L at {i}, {j}"
                );
            }
        }
        for j in 0..rows {
            for i in j..rows {
                let products = l[columns + i].iter().zip(&l[columns + j]);
                let expected: f64 = products.map(|(a, b)| -a * b).sum();
                let found = update[half.diagonal(j) + i - j];
                assert!(
                    close(found, expected),
                    "{columns} + {rows}: update at {i}, {j}"
                );
            }
        }
    }

    #[test]
    fn a_front_loses_its_columns_whatever_its_size() {
        let wide = PANEL + NARROW + 1;
        for (columns, rows) in [
            (0, 3),
            (1, 0),
            (5, 7),
            (30, SMALL),
            (30, SMALL + 1),
            (WIDE + 1, TILE + 5),
            (wide, 2 * STRIP + 3),
            (wide + PANEL, 10),
            (DEPTH + 1, SMALL + 9),
        ] {
            agrees::<f64>(columns, rows, 1e-13);
            agrees::<f32>(columns, rows, 1e-5);
        }
    }

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
