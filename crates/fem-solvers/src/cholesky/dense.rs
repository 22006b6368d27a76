//! Dense kernels of one front.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor as llt;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The precision of a factor: `f64`, or `f32` with half the memory and twice the speed.
pub trait FactorScalar:
    faer::traits::RealField + Copy + Send + Sync + sealed::Sealed + 'static
{
    /// Rounds.
    fn from_f64(value: f64) -> Self;
    /// Widens.
    fn to_f64(self) -> f64;
}

impl FactorScalar for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
}

impl FactorScalar for f32 {
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

/// Eliminates the first `columns` of a front of `height` rows: `panel` becomes the columns of `L`,
/// `update` (column-major, lower half, `height − columns` squared) loses `L₂₁ L₂₁ᵀ`.
///
/// `Err` is the column whose pivot is not positive.
pub(super) fn eliminate<T: FactorScalar>(
    panel: &mut [T],
    height: usize,
    columns: usize,
    update: &mut [T],
) -> Result<(), usize> {
    let rows = height - columns;
    let panel = MatMut::from_column_major_slice_mut(panel, height, columns);
    let (mut pivot, mut below) = panel.split_at_row_mut(columns);
    let mut memory = MemBuffer::new(llt::cholesky_in_place_scratch::<T>(
        columns,
        Par::Seq,
        Default::default(),
    ));
    llt::cholesky_in_place(
        pivot.rb_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|llt::LltError::NonPositivePivot { index }| index)?;
    // Never trust a return alone: a NaN pivot must not pass.
    for j in 0..columns {
        let d = pivot[(j, j)].to_f64();
        if !(d > 0.0 && d.is_finite()) {
            return Err(j);
        }
    }
    if rows > 0 {
        triangular_solve::solve_lower_triangular_in_place(
            pivot.rb(),
            below.rb_mut().transpose_mut(),
            Par::Seq,
        );
        triangular::matmul(
            MatMut::from_column_major_slice_mut(update, rows, rows),
            BlockStructure::TriangularLower,
            Accum::Add,
            below.rb(),
            BlockStructure::Rectangular,
            below.rb().transpose(),
            BlockStructure::Rectangular,
            T::from_f64(-1.0),
            Par::Seq,
        );
    }
    Ok(())
}

/// `x ← L₁₁⁻¹ x`, then `z ← z − L₂₁ x`.
pub(super) fn forward<T: FactorScalar>(
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
pub(super) fn backward<T: FactorScalar>(
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
