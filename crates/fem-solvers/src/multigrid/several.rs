//! Conjugate gradients for many right-hand sides, to an error in the norm of the matrix.

mod iterate;
mod product;
#[cfg(test)]
mod tests;

use self::iterate::{Iterate, System};
use self::product::product;
use super::hierarchy::Multigrid;
use super::precision::LevelScalar;
use super::rows::Rows;
use crate::block_matrix::BlockSymmetric;
use crate::cholesky::SymbolicCholesky;
use crate::newton::{FLOPS_PER_BYTE, bytes_of_an_iteration};
use crate::operator::{LinearOperator, Preconditioner};
use crate::pcg::{PcgError, power_of_two};
use crate::vector::{first_non_finite, norm_inf};

/// When [`Multigrid::solve_many`] stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveManyParams {
    /// Stop when the estimate of `‖x − A⁻¹b‖_A` is at most this part of `‖x‖_A`, `‖x‖_A² = xᵀAx`.
    pub energy_tolerance: f64,
    /// Give up after this many products with `A` for one right-hand side.
    pub max_iterations: usize,
}

impl Default for SolveManyParams {
    fn default() -> Self {
        Self {
            energy_tolerance: 1e-10,
            max_iterations: 1_000,
        }
    }
}

/// What the solves took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SolveManyInfo {
    /// Iterations of all right-hand sides together.
    pub iterations: usize,
    /// The largest `‖b − A x‖_M / ‖x‖_A` of them, by the residual itself, `M` one cycle.
    pub error: f64,
}

/// Right-hand sides that are solved together.
const TOGETHER: usize = 8;
/// Fewer than these are solved one by one.
const FEWEST: usize = 3;
/// Iterations' worth of a new hierarchy, and the iterations of a usual solve.
const SETUP: f64 = 12.0;
const USUAL_ITERATIONS: f64 = 60.0;
/// What an iteration of [`TOGETHER`] right-hand sides takes, over that of one.
const COST_TOGETHER: f64 = 3.0;
/// What one more right-hand side takes from a factor that is read in any case.
const COST_OF_NEXT: f64 = 0.09;
/// How often a column may go on from where its recurrence left the residual.
const RESTARTS: usize = 2;

impl<T: LevelScalar, const D: usize, const K: usize> Multigrid<D, K, T> {
    /// Whether a new hierarchy and `ncols` usual solves on it move fewer bytes than a factorization and
    /// its solves, four flops counted as a byte; counts, not clocks, so that a run can be repeated
    /// bit by bit.
    pub fn solves_cheaper_than(symbolic: &SymbolicCholesky<D>, ncols: usize) -> bool {
        let (full, rest) = (ncols / TOGETHER, ncols % TOGETHER);
        let tail = match rest {
            0 => 0.0,
            _ if rest < FEWEST => rest as f64,
            _ => COST_TOGETHER,
        };
        let iterations = SETUP + USUAL_ITERATIONS * (full as f64 * COST_TOGETHER + tail);
        let solves = 1.0 + COST_OF_NEXT * ncols as f64;
        let factor = symbolic.flops() / FLOPS_PER_BYTE + 16.0 * symbolic.fill() as f64 * solves;
        iterations * bytes_of_an_iteration(symbolic) < factor
    }

    /// `X ← A⁻¹ X` for `ncols` right-hand sides, column-major, by conjugate gradients on this hierarchy,
    /// which was made for `matrix` or one near it; where a scalar is absent, 0 in place of anything.
    ///
    /// The error of each column is measured in the norm of the matrix, by the sum of what its next four
    /// iterations gained (Hestenes and Stiefel 1952; Strakoš and Tichý 2002), and then by the residual
    /// itself, for the recurrence drifts away from it: a column whose residual is worse than its tolerance
    /// starts again from where it stands, twice at most. Eight columns are solved together, so that the
    /// matrices are read once for all of them. The bits do not depend on the number of threads; they
    /// do, within the tolerance, on which columns are asked for together.
    ///
    /// Negative curvature is met where the Krylov spaces of the right-hand sides see it: a matrix that
    /// is not positive definite may go unnoticed where they do not.
    ///
    /// # Errors
    /// The [`PcgError`] of the first columns solved together, in their order, of which one fails: what
    /// met its iterations first, of the leftmost column where several did in one; indices count the
    /// entries of that column, and which one it is is not told. [`PcgError::NotConverged`] has the most
    /// iterations and the largest `‖b − A x‖_M / ‖x‖_A` of the columns beside it, in place of the residual's
    /// own norm. [`PcgError::Preconditioner`] also where the hierarchy is not usable or made for another
    /// pattern, [`PcgError::NonFinite`] also where `f64` has no number for the solution or for `xᵀAx`.
    /// `x` is then unspecified.
    pub fn solve_many(
        &self,
        matrix: &BlockSymmetric<D>,
        x: &mut [f64],
        ncols: usize,
        params: &SolveManyParams,
    ) -> Result<SolveManyInfo, PcgError> {
        let n = matrix.dim();
        check(n, x, ncols, params)?;
        let mut info = SolveManyInfo::default();
        if n == 0 {
            return Ok(info);
        }
        let Some(rows) = self.rows_of(matrix) else {
            return Err(PcgError::Preconditioner { iteration: 0 });
        };
        let system = OfHierarchy {
            hierarchy: self,
            matrix,
            rows,
        };
        let absent: Vec<usize> = matrix.pattern().absent_places(D).collect();
        let clear = |x: &mut [f64]| {
            for column in x.chunks_exact_mut(n) {
                absent.iter().for_each(|&place| column[place] = 0.0);
            }
        };
        clear(x);
        for block in x.chunks_mut(n * TOGETHER) {
            if block.len() < n * FEWEST {
                for column in block.chunks_exact_mut(n) {
                    info = info.and(solve::<1>(&system, column, n, params)?);
                }
            } else {
                info = info.and(solve::<TOGETHER>(&system, block, n, params)?);
            }
        }
        // A near kernel that is not zero there leaves some.
        clear(x);
        Ok(info)
    }
}

impl SolveManyInfo {
    fn and(self, other: Self) -> Self {
        Self {
            iterations: self.iterations + other.iterations,
            error: self.error.max(other.error),
        }
    }
}

fn check(n: usize, x: &[f64], ncols: usize, params: &SolveManyParams) -> Result<(), PcgError> {
    let value = params.energy_tolerance;
    if !(0.0..f64::INFINITY).contains(&value) {
        let what = "energy_tolerance";
        return Err(PcgError::Tolerance { what, value });
    }
    // No slice is as long as a product that saturates.
    let expected = n.saturating_mul(ncols);
    if x.len() != expected {
        return Err(PcgError::Dimension {
            what: "the block of right-hand sides",
            found: x.len(),
            expected,
        });
    }
    match first_non_finite(x) {
        None => Ok(()),
        Some(index) => Err(PcgError::NonFinite {
            iteration: 0,
            what: "the block of right-hand sides",
            index,
        }),
    }
}

struct OfHierarchy<'a, T, const D: usize, const K: usize> {
    hierarchy: &'a Multigrid<D, K, T>,
    matrix: &'a BlockSymmetric<D>,
    rows: &'a Rows,
}

impl<T: LevelScalar, const B: usize, const D: usize, const K: usize> System<B>
    for OfHierarchy<'_, T, D, K>
{
    fn product(&self, x: &[[f64; B]], y: &mut [[f64; B]]) {
        match B {
            1 => self.matrix.apply(x.as_flattened(), y.as_flattened_mut()),
            _ => product(self.rows, self.matrix, x, y),
        }
    }

    fn cycle(&self, r: &[[f64; B]], z: &mut [[f64; B]]) {
        match B {
            1 => self.hierarchy.apply(r.as_flattened(), z.as_flattened_mut()),
            _ => self.hierarchy.apply_several(r, z),
        }
    }
}

/// At most `B` columns, in place.
fn solve<const B: usize>(
    system: &impl System<B>,
    columns: &mut [f64],
    n: usize,
    params: &SolveManyParams,
) -> Result<SolveManyInfo, PcgError> {
    let (tolerance, most) = (params.energy_tolerance, params.max_iterations);
    // A power of two that makes the largest entry about one, so that squares keep their range.
    let mut scales = [1.0; B];
    for (scale, column) in scales.iter_mut().zip(columns.chunks_exact(n)) {
        *scale = power_of_two(norm_inf(column));
    }
    let mut b = vec![[0.0; B]; n];
    for (k, column) in columns.chunks_exact(n).enumerate() {
        for (b, value) in b.iter_mut().zip(column) {
            b[k] = scales[k] * value;
        }
    }
    let mut iterate = Iterate::new(b.clone());
    let mut error = f64::NAN;
    for _ in 0..=RESTARTS {
        let finished = iterate.run(system, tolerance, most)?;
        error = iterate.look(system, &b, tolerance)?;
        if error <= tolerance {
            let iterations = iterate.iterations();
            unscale(&iterate.x, &scales, columns, iterate.longest())?;
            return Ok(SolveManyInfo { iterations, error });
        }
        if !finished {
            break;
        }
    }
    Err(PcgError::NotConverged {
        iterations: iterate.longest(),
        relative_residual: error,
    })
}

/// Solutions of the right-hand sides as they were given; they may be too large for a number.
fn unscale<const B: usize>(
    x: &[[f64; B]],
    scales: &[f64; B],
    columns: &mut [f64],
    iteration: usize,
) -> Result<(), PcgError> {
    for (k, column) in columns.chunks_exact_mut(x.len()).enumerate() {
        for (value, x) in column.iter_mut().zip(x) {
            *value = x[k] / scales[k];
        }
        if let Some(index) = first_non_finite(column) {
            return Err(PcgError::NonFinite {
                iteration,
                what: "the solution",
                index,
            });
        }
    }
    Ok(())
}
