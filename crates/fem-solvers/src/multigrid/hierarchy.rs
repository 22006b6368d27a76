//! All levels together.

use super::entry::{Entry, Several};
use super::level::Level;
use super::near_kernel::NearKernel;
use super::precision::LevelScalar;
use super::rows::Rows;
use crate::block_matrix::{BlockPattern, BlockSymmetric};
use crate::cholesky::{CholeskyFactor, SymbolicCholesky};
use crate::operator::{MatrixPreconditioner, Preconditioner};
use crate::preconditioner::PreconditionerError;
use crate::vector::norm_inf;
use std::sync::Arc;

/// How a hierarchy is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultigridParams {
    /// Couplings below this share of the rows' own size do not bring rows together, in [0, 1).
    pub strength: f64,
    /// Degree of the smoothing polynomial before and after each coarse correction, 1 or more.
    pub smoothing_degree: usize,
    /// Block rows from which on the coarse matrix is factored.
    pub coarsest: usize,
}

impl Default for MultigridParams {
    fn default() -> Self {
        Self {
            strength: 0.02,
            smoothing_degree: 2,
            coarsest: 400,
        }
    }
}

/// What a hierarchy looks like.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MultigridInfo {
    /// Block rows of each level, the finest first.
    pub rows: Vec<usize>,
    /// Scalars in the matrices of all levels, both halves, over those of the finest.
    pub operator_complexity: f64,
}

/// Levels are no longer worth their while when they shrink by less than this.
const SLOWEST: f64 = 0.7;
const MOST_LEVELS: usize = 20;
/// The smallest share of a diagonal entry that may be left as a pivot of the coarsest matrix.
const SINGULAR: f64 = 1e-12;

/// A smoothed-aggregation hierarchy: one V-cycle is `z ≈ A⁻¹ r`.
///
/// `D` is the size of the matrix' blocks, `K` the number of vectors of its near kernel and the size of
/// the coarse blocks. Aggregates and patterns are kept from [update](MatrixPreconditioner::update) to
/// update as long as the pattern stays; values are always new. After an update that failed it is
/// unusable until another succeeds.
#[derive(Clone, Debug)]
pub struct Multigrid<const D: usize, const K: usize, T = f32> {
    params: MultigridParams,
    kernel: NearKernel,
    made: Option<Hierarchy<T, D, K>>,
    usable: bool,
}

#[derive(Clone, Debug)]
struct Hierarchy<T, const D: usize, const K: usize> {
    pattern: Arc<BlockPattern>,
    /// What all matrices are multiplied by, except the one that is factored.
    scale: f64,
    fine: Level<T, D, K>,
    coarse: Vec<Level<T, K, K>>,
    bottom: CholeskyFactor<f64, K>,
}

impl<T: LevelScalar, const D: usize, const K: usize> Hierarchy<T, D, K> {
    fn build(
        matrix: &BlockSymmetric<D>,
        kernel: &NearKernel,
        params: &MultigridParams,
    ) -> Result<Self, PreconditionerError> {
        let kernel = kernel.blocks::<D, K>(matrix.pattern().blocks())?;
        let scale = scale_of(matrix);
        let mut fine = Level::new(matrix, params)?;
        let mut kernel = fine.update(0, scale, matrix, &kernel)?;
        let mut coarse: Vec<Level<T, K, K>> = Vec::new();
        loop {
            let last = coarse.last().map_or(&fine.coarse, |level| &level.coarse);
            let rows = last.pattern().blocks();
            if rows <= params.coarsest || coarse.len() + 1 >= MOST_LEVELS {
                break;
            }
            let mut level = Level::new(last, params)?;
            if level.aggregates.count() as f64 > SLOWEST * rows as f64
                || level.aggregates.count() == 0
            {
                break;
            }
            kernel = level.update(coarse.len() + 1, scale, last, &kernel)?;
            coarse.push(level);
        }
        let last = coarse.last().map_or(&fine.coarse, |level| &level.coarse);
        let symbolic = Arc::new(SymbolicCholesky::new(last.pattern()));
        let mut made = Self {
            pattern: matrix.pattern().clone(),
            scale,
            bottom: CholeskyFactor::allocate(&symbolic),
            fine,
            coarse,
        };
        made.factor_bottom()?;
        Ok(made)
    }

    fn is_for(&self, matrix: &BlockSymmetric<D>) -> bool {
        Arc::ptr_eq(&self.pattern, matrix.pattern()) || *self.pattern == **matrix.pattern()
    }

    fn refresh(
        &mut self,
        matrix: &BlockSymmetric<D>,
        kernel: &NearKernel,
    ) -> Result<(), PreconditionerError> {
        let kernel = kernel.blocks::<D, K>(matrix.pattern().blocks())?;
        self.scale = scale_of(matrix);
        let scale = self.scale;
        let mut kernel = self.fine.update(0, scale, matrix, &kernel)?;
        let mut above = &self.fine.coarse;
        for (k, level) in self.coarse.iter_mut().enumerate() {
            kernel = level.update(k + 1, scale, above, &kernel)?;
            above = &level.coarse;
        }
        self.factor_bottom()
    }

    fn factor_bottom(&mut self) -> Result<(), PreconditionerError> {
        let level = self.coarse.len() + 1;
        let last = self.coarse.last().map_or(&self.fine.coarse, |l| &l.coarse);
        self.bottom
            .refill(last)
            .map_err(|_| PreconditionerError::NegativeCurvature { level })?;
        if self.bottom.weakest_pivot(last) > SINGULAR {
            Ok(())
        } else {
            Err(PreconditionerError::NegativeCurvature { level })
        }
    }

    fn correct<V: Entry<T>>(&self, depth: usize, b: &mut [[V; K]], x: &mut [[V; K]]) {
        match self.coarse.get(depth) {
            Some(level) => {
                let found = level.cycle(b, |b, x| self.correct(depth + 1, b, x));
                x.copy_from_slice(&found);
            }
            None => {
                let (b, x) = (b.as_flattened(), x.as_flattened_mut());
                let column = |k| b.iter().map(move |v: &V| v.number(k).widen());
                let mut wide: Vec<f64> = (0..V::NUMBERS).flat_map(column).collect();
                self.bottom.solve_many(&mut wide, V::NUMBERS);
                for (k, column) in wide.chunks_exact(x.len().max(1)).enumerate() {
                    for (x, wide) in x.iter_mut().zip(column) {
                        x.set(k, T::narrow(wide / self.scale));
                    }
                }
            }
        }
    }
}

/// A power of two that makes the largest diagonal entry about one, so that squares fit `f32`.
fn scale_of<const D: usize>(matrix: &BlockSymmetric<D>) -> f64 {
    let largest = norm_inf(&matrix.diagonal());
    if largest > 0.0 && largest.is_finite() {
        (-largest.log2().floor()).clamp(-1000.0, 1000.0).exp2()
    } else {
        1.0
    }
}

impl<T: LevelScalar, const D: usize, const K: usize> Multigrid<D, K, T> {
    /// Nothing yet but what the next [`update`](MatrixPreconditioner::update) needs beside the matrix.
    pub fn new(kernel: NearKernel, params: MultigridParams) -> Self {
        Self {
            params,
            kernel,
            made: None,
            usable: false,
        }
    }

    /// The near kernel from the next update on; aggregates stay.
    pub fn set_near_kernel(&mut self, kernel: NearKernel) {
        self.kernel = kernel;
    }

    /// Makes the next update look for aggregates again.
    pub fn forget(&mut self) {
        self.made = None;
    }

    /// Whether it was made for a matrix with this pattern, with values that served.
    pub fn fits(&self, matrix: &BlockSymmetric<D>) -> bool {
        self.usable && self.made.as_ref().is_some_and(|made| made.is_for(matrix))
    }

    /// The rows of a matrix with the pattern that it was made for, if it is usable.
    pub(super) fn rows_of(&self, matrix: &BlockSymmetric<D>) -> Option<&Rows> {
        let made = self
            .made
            .as_ref()
            .filter(|made| self.usable && made.is_for(matrix));
        made.map(|made| &made.fine.matrix.rows)
    }

    /// What the last update made, `None` before and after one that failed.
    pub fn info(&self) -> Option<MultigridInfo> {
        let made = self.made.as_ref().filter(|_| self.usable)?;
        let mut rows = vec![made.fine.matrix.rows.len()];
        rows.extend(made.coarse.iter().map(|level| level.matrix.rows.len()));
        rows.push(made.bottom.symbolic().pattern().blocks());
        let fine = D * D * made.fine.matrix.rows.entries();
        let inner = made.coarse.iter().map(|level| level.matrix.rows.entries());
        let last = made.bottom.symbolic().pattern();
        let coarse: usize = inner.sum::<usize>() + 2 * last.stored() - last.blocks();
        Some(MultigridInfo {
            rows,
            operator_complexity: (fine + K * K * coarse) as f64 / fine.max(1) as f64,
        })
    }
}

impl<T: LevelScalar, const D: usize, const K: usize> Multigrid<D, K, T> {
    /// `Z ≈ A⁻¹ R` for `B` right-hand sides, the numbers of each place side by side: every matrix is read
    /// once for all of them.
    pub(super) fn apply_several<const B: usize>(&self, r: &[[f64; B]], z: &mut [[f64; B]]) {
        let Some(made) = self.made.as_ref().filter(|_| self.usable) else {
            z.fill([f64::NAN; B]);
            return;
        };
        let mut largest = [0.0_f64; B];
        for r in r {
            // A number that is not finite stays one in what follows.
            std::array::from_fn::<(), B, _>(|k| largest[k] = largest[k].max(r[k].abs()));
        }
        let scale = largest.map(|v| if v > 0.0 { v } else { 1.0 });
        let narrow = |r: &[f64; B]| Several(std::array::from_fn(|k| T::narrow(r[k] / scale[k])));
        let (blocks, _) = r.as_chunks::<D>();
        let mut b: Vec<[Several<T, B>; D]> = blocks
            .iter()
            .map(|block| std::array::from_fn(|c| narrow(&block[c])))
            .collect();
        let x = made.fine.cycle(&mut b, |b, x| made.correct(0, b, x));
        for (z, x) in z.iter_mut().zip(x.as_flattened()) {
            *z = std::array::from_fn(|k| scale[k] * made.scale * x.0[k].widen());
        }
    }
}

impl<T: LevelScalar, const D: usize, const K: usize> Preconditioner for Multigrid<D, K, T> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        let scale = norm_inf(r);
        let (Some(made), true, true) = (&self.made, self.usable, scale != 0.0) else {
            z.fill(if scale == 0.0 { 0.0 } else { f64::NAN });
            return;
        };
        let (blocks, _) = r.as_chunks::<D>();
        let mut b: Vec<[T; D]> = blocks
            .iter()
            .map(|block| block.map(|v| T::narrow(v / scale)))
            .collect();
        let x = made.fine.cycle(&mut b, |b, x| made.correct(0, b, x));
        for (z, x) in z.iter_mut().zip(x.as_flattened()) {
            *z = scale * made.scale * x.widen();
        }
    }
}

impl<T: LevelScalar, const D: usize, const K: usize> MatrixPreconditioner<D>
    for Multigrid<D, K, T>
{
    fn update(&mut self, matrix: &BlockSymmetric<D>) -> Result<(), PreconditionerError> {
        self.usable = false;
        match &mut self.made {
            Some(made) if made.is_for(matrix) => made.refresh(matrix, &self.kernel)?,
            _ => self.made = Some(Hierarchy::build(matrix, &self.kernel, &self.params)?),
        }
        self.usable = true;
        Ok(())
    }
}
