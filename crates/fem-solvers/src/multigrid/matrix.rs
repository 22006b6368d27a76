//! The matrix of one level and its products.

use super::entry::{Entry, LANES};
use super::precision::LevelScalar;
use super::rows::Rows;
use crate::block_matrix::BlockSymmetric;
use crate::parallel::map;
use crate::preconditioner::PreconditionerError;
use crate::small;
use fem_kinematics::{Kernel, dispatch};
use std::ops::{Range, SubAssign};

/// A symmetric matrix in both halves, times a power of two, with the inverse of its block diagonal.
#[derive(Clone, Debug)]
pub(super) struct LevelMatrix<T, const D: usize> {
    pub rows: Rows,
    /// Blocks by columns, and some zeros behind the last, for products read whole registers.
    values: Vec<T>,
    inverse: Vec<T>,
}

/// How far behind a block its reader looks.
#[inline(always)]
const fn reach(d: usize) -> usize {
    if d <= 4 {
        (d - 1) * d + 4
    } else {
        (d - 1) * d + LANES
    }
}

impl<T: LevelScalar, const D: usize> LevelMatrix<T, D> {
    pub fn new(rows: Rows) -> Self {
        const { assert!(D <= LANES) };
        Self {
            rows,
            values: Vec::new(),
            inverse: Vec::new(),
        }
    }

    /// Takes the values of `scale · matrix`.
    ///
    /// # Errors
    /// Names the first block that is not finite, or not positive definite on the diagonal.
    pub fn update(
        &mut self,
        matrix: &BlockSymmetric<D>,
        scale: f64,
    ) -> Result<(), PreconditionerError> {
        let (n, zero) = (self.rows.len(), T::narrow(0.0));
        self.inverse.resize(D * D * n + LANES, zero);
        let inverse = &mut self.inverse[..D * D * n];
        let tasks = self.rows.cut::<D, _>(inverse, |rows| D * D * rows.len());
        map::<_, _, Vec<Result<(), PreconditionerError>>>(tasks, |(rows, out)| {
            invert_diagonal(matrix, scale, rows, out)
        })
        .into_iter()
        .collect::<Result<(), _>>()?;
        let length = D * D * self.rows.entries();
        self.values.resize(length + LANES, zero);
        let values = &mut self.values[..length];
        self.rows.gather(
            matrix.values(),
            scale,
            values.as_chunks_mut().0.as_chunks_mut().0,
        );
        Ok(())
    }

    /// Every row's product with `x`, in a loop for each of `tasks`.
    fn each_row<V: Entry<T>, S: RowSink<V, D>>(&self, x: &[[V; D]], tasks: Vec<(Range<usize>, S)>) {
        let _: Vec<()> = map(tasks, |(rows, sink)| {
            dispatch(RowLoop {
                matrix: self,
                x,
                rows,
                sink,
            });
        });
    }

    #[inline(always)]
    fn row_product<V: Entry<T>>(&self, row: usize, x: &[[V; D]]) -> [V; D] {
        let mut sum = [V::default(); LANES];
        let entries = self.rows.entries_of(row);
        let columns = &self.rows.columns_of(row);
        for (entry, &j) in entries.zip(*columns) {
            let block = &self.values[D * D * entry..][..reach(D)];
            V::add_columns(&mut sum, block, &x[j as usize]);
        }
        std::array::from_fn(|r| sum[r])
    }

    #[inline(always)]
    fn solve_diagonal<V: Entry<T>>(&self, row: usize, x: &[V; D]) -> [V; D] {
        let mut sum = [V::default(); LANES];
        let block = &self.inverse[D * D * row..][..reach(D)];
        V::add_columns(&mut sum, block, x);
        std::array::from_fn(|r| sum[r])
    }

    /// `y = A x`.
    pub fn apply(&self, x: &[[T; D]], y: &mut [[T; D]]) {
        let tasks = self.rows.cut::<D, _>(y, Range::len);
        let task = |(rows, y)| (rows, Set(y));
        self.each_row(x, tasks.into_iter().map(task).collect());
    }

    /// `r −= A x`.
    pub fn subtract_product<V: Entry<T>>(&self, x: &[[V; D]], r: &mut [[V; D]]) {
        let tasks = self.rows.cut::<D, _>(r, Range::len);
        let task = |(rows, r)| (rows, Subtract(r));
        self.each_row(x, tasks.into_iter().map(task).collect());
    }

    /// `z = D⁻¹ r`.
    pub fn apply_inverse_diagonal(&self, r: &[[T; D]], z: &mut [[T; D]]) {
        for (row, (r, z)) in r.iter().zip(z).enumerate() {
            *z = self.solve_diagonal(row, r);
        }
    }

    /// `z = factor · D⁻¹ r`, `x += z`.
    pub fn first_correction<V: Entry<T>>(
        &self,
        factor: T,
        r: &[[V; D]],
        z: &mut [[V; D]],
        x: &mut [[V; D]],
    ) {
        let tasks = self.rows.cut::<D, _>(z, Range::len).into_iter();
        let tasks = tasks.zip(self.rows.cut::<D, _>(x, Range::len));
        let _: Vec<()> = map(tasks.collect(), |((rows, z), (_, x))| {
            for ((row, z), x) in rows.zip(z).zip(x) {
                *z = self.solve_diagonal(row, &r[row]).map(|v| v * factor);
                for c in 0..D {
                    x[c] += z[c];
                }
            }
        });
    }

    /// `r −= A z`, `next = keep · z + factor · D⁻¹ r`, `x += next`, the matrix read once.
    pub fn correction<V: Entry<T>>(
        &self,
        (keep, factor): (T, T),
        z: &[[V; D]],
        r: &mut [[V; D]],
        next: &mut [[V; D]],
        x: &mut [[V; D]],
    ) {
        let tasks = self.rows.cut::<D, _>(r, Range::len).into_iter();
        let tasks = tasks.zip(self.rows.cut::<D, _>(next, Range::len));
        let tasks = tasks.zip(self.rows.cut::<D, _>(x, Range::len));
        let task = |(((rows, r), (_, next)), (_, x))| {
            let sink = Correct {
                matrix: self,
                factors: (keep, factor),
                z,
                r,
                next,
                x,
            };
            (rows, sink)
        };
        self.each_row(z, tasks.map(task).collect());
    }
}

/// The inverses of some diagonal blocks of `scale · matrix`, after a look at their rows.
fn invert_diagonal<T: LevelScalar, const D: usize>(
    matrix: &BlockSymmetric<D>,
    scale: f64,
    rows: Range<usize>,
    out: &mut [T],
) -> Result<(), PreconditionerError> {
    let start = matrix.pattern().row_start();
    for (block, out) in rows.zip(out.chunks_exact_mut(D * D)) {
        let row = &matrix.values()[start[block]..start[block + 1]];
        if row.iter().flatten().flatten().any(|v| !v.is_finite()) {
            return Err(PreconditionerError::NonFinite { block });
        }
        let inverse = small::inverse_positive_definite(matrix.diagonal_block(block))
            .ok_or(PreconditionerError::NotPositiveDefinite { block })?;
        for (out, value) in out.iter_mut().zip(inverse.as_flattened()) {
            *out = T::narrow(value / scale);
        }
    }
    Ok(())
}

/// What is done with the product of a row; `own` counts from the first row of the task.
trait RowSink<V, const D: usize>: Send {
    fn take(&mut self, own: usize, row: usize, product: [V; D]);
}

struct Set<'a, V, const D: usize>(&'a mut [[V; D]]);
struct Subtract<'a, V, const D: usize>(&'a mut [[V; D]]);
struct Correct<'a, T, V, const D: usize> {
    matrix: &'a LevelMatrix<T, D>,
    factors: (T, T),
    z: &'a [[V; D]],
    r: &'a mut [[V; D]],
    next: &'a mut [[V; D]],
    x: &'a mut [[V; D]],
}

impl<V: Send, const D: usize> RowSink<V, D> for Set<'_, V, D> {
    #[inline(always)]
    fn take(&mut self, own: usize, _: usize, product: [V; D]) {
        self.0[own] = product;
    }
}

impl<V: Send + Copy + SubAssign, const D: usize> RowSink<V, D> for Subtract<'_, V, D> {
    #[inline(always)]
    fn take(&mut self, own: usize, _: usize, product: [V; D]) {
        let r = &mut self.0[own];
        for c in 0..D {
            r[c] -= product[c];
        }
    }
}

impl<T: LevelScalar, V: Entry<T>, const D: usize> RowSink<V, D> for Correct<'_, T, V, D> {
    #[inline(always)]
    fn take(&mut self, own: usize, row: usize, product: [V; D]) {
        let r = &mut self.r[own];
        for c in 0..D {
            r[c] -= product[c];
        }
        let step = self.matrix.solve_diagonal(row, r);
        let (keep, factor) = self.factors;
        let (z, next, x) = (&self.z[row], &mut self.next[own], &mut self.x[own]);
        for c in 0..D {
            next[c] = z[c] * keep + step[c] * factor;
            x[c] += next[c];
        }
    }
}

struct RowLoop<'a, T, V, S, const D: usize> {
    matrix: &'a LevelMatrix<T, D>,
    x: &'a [[V; D]],
    rows: Range<usize>,
    sink: S,
}

impl<T: LevelScalar, V: Entry<T>, S: RowSink<V, D>, const D: usize> Kernel
    for RowLoop<'_, T, V, S, D>
{
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        for (own, row) in self.rows.enumerate() {
            let product = self.matrix.row_product(row, self.x);
            self.sink.take(own, row, product);
        }
    }
}
