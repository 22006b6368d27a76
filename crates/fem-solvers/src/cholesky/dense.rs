//! Dense kernels of one front.

use super::eliminate::eliminate;
use super::pool::Pool;
use faer::linalg::{matmul, triangular_solve};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

mod sealed {
    use super::super::pool::Pool;
    use faer::{MatMut, MatRef};

    /// What is done with a scalar in a front. Each method has a body for `f32` and one for `f64`, so
    /// that faer's kernels are compiled with this crate and not with every crate that factors.
    pub trait Sealed: faer::traits::RealField {
        fn eliminate(
            panel: &mut [Self],
            height: usize,
            columns: usize,
            update: &mut [Self],
            pool: &Pool<Self>,
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
                pool: &Pool<Self>,
            ) -> Result<(), usize> {
                eliminate(panel, height, columns, update, pool)
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
pub trait FactorScalar: Copy + Default + Send + Sync + sealed::Sealed + 'static {
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
