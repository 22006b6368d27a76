//! Preconditioned conjugate gradients.

use crate::operator::{LinearOperator, Preconditioner, Structure};
use crate::vector::{axpy, dot, first_non_finite, norm, norm_inf, step, turn};
use thiserror::Error;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PcgParams {
    /// Stop when `‖b − A x‖ ≤ relative_tolerance · ‖b‖`; `b = 0` is replaced by the residual of the
    /// first guess.
    pub relative_tolerance: f64,
    /// … or when `‖b − A x‖ ≤ absolute_tolerance`, in the unit of `b`.
    pub absolute_tolerance: f64,
    /// Give up after this many products with `A`.
    pub max_iterations: usize,
    /// Give up when this many iterations in a row did not lower the smallest residual so far.
    pub stagnation_window: usize,
}

impl Default for PcgParams {
    fn default() -> Self {
        Self {
            relative_tolerance: 1e-10,
            absolute_tolerance: 0.0,
            max_iterations: 10_000,
            stagnation_window: 1_000,
        }
    }
}

/// What a converged solve took.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PcgInfo {
    /// Products with the operator, not counting the one for a non-zero first guess.
    pub iterations: usize,
    /// `‖b − A x‖ / ‖b‖` by the recurrence; for `b = 0` over the residual of the first guess.
    pub relative_residual: f64,
}

/// Why a solve ended without a solution. `x` holds the last iterate.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PcgError {
    /// The operator does not claim what this solver needs.
    #[error(
        "conjugate gradients need an operator that claims to be {needed:?}, this one claims {found:?}"
    )]
    Refused {
        /// The weakest claim that would do.
        needed: Structure,
        /// What the operator claims.
        found: Structure,
    },
    /// A tolerance that is negative or no finite number.
    #[error("{what} is {value}, it must be finite and not negative")]
    Tolerance {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A slice does not have the operator's length.
    #[error("{what} has length {found}, the operator has dimension {expected}")]
    Dimension {
        /// Which slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The operator's dimension.
        expected: usize,
    },
    /// `pᵀAp ≤ 0`: the operator is not positive definite.
    #[error(
        "iteration {iteration}: curvature {curvature:e} is not positive, the matrix is not positive definite"
    )]
    NegativeCurvature {
        /// Iteration that met it, from 0.
        iteration: usize,
        /// `pᵀAp / pᵀp`.
        curvature: f64,
        /// The direction `p`.
        direction: Vec<f64>,
    },
    /// `rᵀM⁻¹r ≤ 0`: the preconditioner is not positive definite.
    #[error("iteration {iteration}: the preconditioner is not positive definite")]
    Preconditioner {
        /// Iteration, from 0.
        iteration: usize,
    },
    /// A NaN or an infinity.
    #[error("iteration {iteration}: {what} holds a value that is not finite at index {index}")]
    NonFinite {
        /// Iteration, from 0.
        iteration: usize,
        /// Which vector.
        what: &'static str,
        /// First bad index.
        index: usize,
    },
    /// The residual stopped falling.
    #[error("stagnated after {iterations} iterations at relative residual {relative_residual:e}")]
    Stagnated {
        /// Iterations done.
        iterations: usize,
        /// Smallest relative residual reached.
        relative_residual: f64,
    },
    /// Too many iterations.
    #[error("not converged after {iterations} iterations: relative residual {relative_residual:e}")]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Relative residual of the last iterate.
        relative_residual: f64,
    },
    /// A semidefinite system without a solution: `b` has a part in the null space.
    #[error(
        "iteration {iteration}: the right-hand side has a part of relative size {relative_residual:e} in the null space"
    )]
    Inconsistent {
        /// Iteration that met the null space.
        iteration: usize,
        /// Relative residual there.
        relative_residual: f64,
    },
}

/// Solves `A x = b`, `A` symmetric positive definite, from the first guess in `x`.
///
/// `b = 0` is answered with `x = 0` at once. `b` may have any size that `f64` has: sums of squares
/// neither vanish nor overflow.
///
/// With [`Identity`](crate::Identity) these are the plain conjugate gradients of document 000, Algorithm 1.
///
/// # Errors
/// Refuses an operator that does not claim [`Structure::SymmetricPositiveDefinite`]; otherwise see
/// [`PcgError`]. After an error `x` holds the last iterate.
///
/// ```
/// use fem_solvers::{pcg, BlockPattern, BlockSymmetric, Identity, PcgParams, Structure};
/// let pattern = BlockPattern::from_adjacency(2, [(0, 1)]).unwrap();
/// let mut a = BlockSymmetric::<1>::zeros(pattern.into());
/// a.values_mut().copy_from_slice(&[[[2.0]], [[-1.0]], [[2.0]]]);
/// let a = a.claiming(Structure::SymmetricPositiveDefinite);
/// let mut x = [0.0; 2];
/// pcg(&a, &Identity, &[1.0, 0.0], &mut x, &PcgParams::default()).unwrap();
/// assert!((x[0] - 2.0 / 3.0).abs() < 1e-12 && (x[1] - 1.0 / 3.0).abs() < 1e-12);
/// ```
pub fn pcg(
    op: &(impl LinearOperator + ?Sized),
    precond: &(impl Preconditioner + ?Sized),
    b: &[f64],
    x: &mut [f64],
    params: &PcgParams,
) -> Result<PcgInfo, PcgError> {
    let needed = Structure::SymmetricPositiveDefinite;
    if op.structure() != needed {
        return Err(PcgError::Refused {
            needed,
            found: op.structure(),
        });
    }
    iterate(op, precond, b, x, params, NullSpace::Excluded)
}

/// Solves `A x = b`, `A` symmetric positive semidefinite and `b` in its range, with Jacobi scaling.
///
/// `diagonal` is that of `A`; where it is zero, the row is empty and the unknown keeps its first
/// guess. Of the many solutions the one found differs from the first guess by no part of the null
/// space (in the scaled inner product), for `b = 0` too.
///
/// # Errors
/// Refuses an operator that claims neither definiteness nor semidefiniteness;
/// [`PcgError::Inconsistent`] when `b` is not in the range; otherwise see [`PcgError`].
pub fn pcg_semidefinite(
    op: &(impl LinearOperator + ?Sized),
    diagonal: &[f64],
    b: &[f64],
    x: &mut [f64],
    params: &PcgParams,
) -> Result<PcgInfo, PcgError> {
    let found = op.structure();
    if !matches!(
        found,
        Structure::SymmetricPositiveDefinite | Structure::SymmetricPositiveSemidefinite
    ) {
        return Err(PcgError::Refused {
            needed: Structure::SymmetricPositiveSemidefinite,
            found,
        });
    }
    if diagonal.len() != op.dim() {
        return Err(PcgError::Dimension {
            what: "the diagonal",
            found: diagonal.len(),
            expected: op.dim(),
        });
    }
    if let Some(index) = first_non_finite(diagonal) {
        return Err(PcgError::NonFinite {
            iteration: 0,
            what: "the diagonal",
            index,
        });
    }
    if let Some(index) = diagonal.iter().position(|&d| d < 0.0) {
        let mut direction = vec![0.0; op.dim()];
        direction[index] = 1.0;
        return Err(PcgError::NegativeCurvature {
            iteration: 0,
            curvature: diagonal[index],
            direction,
        });
    }
    let jacobi = DiagonalScaling(diagonal);
    iterate(op, &jacobi, b, x, params, NullSpace::Allowed { diagonal })
}

struct DiagonalScaling<'a>(&'a [f64]);

impl Preconditioner for DiagonalScaling<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for ((z, r), d) in z.iter_mut().zip(r).zip(self.0) {
            *z = if *d > 0.0 { r / d } else { 0.0 };
        }
    }
}

#[derive(Clone, Copy)]
enum NullSpace<'a> {
    Excluded,
    Allowed { diagonal: &'a [f64] },
}

/// Curvature, relative to that of the diagonal, below which a direction lies in the null space.
const NULL_CURVATURE: f64 = 1e-13;

fn iterate(
    op: &(impl LinearOperator + ?Sized),
    precond: &(impl Preconditioner + ?Sized),
    b: &[f64],
    x: &mut [f64],
    params: &PcgParams,
    null_space: NullSpace<'_>,
) -> Result<PcgInfo, PcgError> {
    check(op.dim(), b, x, params)?;
    if matches!(null_space, NullSpace::Excluded) && b.iter().all(|&v| v == 0.0) {
        x.fill(0.0);
        return Ok(PcgInfo {
            iterations: 0,
            relative_residual: 0.0,
        });
    }
    let mut state = Iterate::start(op, b, x);
    let reference = state.reference(b);
    let target =
        (params.relative_tolerance * reference).max(params.absolute_tolerance * state.scale);
    let (mut best, mut since_best) = (state.r_norm, 0);
    loop {
        let iterations = state.iteration;
        if !state.r_norm.is_finite() {
            return Err(state.non_finite("the residual", &state.r));
        }
        let relative = |norm: f64| if norm == 0.0 { 0.0 } else { norm / reference };
        let relative_residual = relative(state.r_norm);
        if state.r_norm <= target {
            return Ok(PcgInfo {
                iterations,
                relative_residual,
            });
        }
        if iterations == params.max_iterations {
            return Err(PcgError::NotConverged {
                iterations,
                relative_residual,
            });
        }
        if state.r_norm < best {
            (best, since_best) = (state.r_norm, 0);
        } else {
            since_best += 1;
            if since_best > params.stagnation_window {
                return Err(PcgError::Stagnated {
                    iterations,
                    relative_residual: relative(best),
                });
            }
        }
        state.turn(precond, null_space, relative_residual)?;
        state.advance(op, x, null_space, relative_residual)?;
    }
}

fn check(n: usize, b: &[f64], x: &[f64], params: &PcgParams) -> Result<(), PcgError> {
    for (what, value) in [
        ("relative_tolerance", params.relative_tolerance),
        ("absolute_tolerance", params.absolute_tolerance),
    ] {
        if !(0.0..f64::INFINITY).contains(&value) {
            return Err(PcgError::Tolerance { what, value });
        }
    }
    for (what, v) in [("the right-hand side", b), ("the first guess", x)] {
        if v.len() != n {
            return Err(PcgError::Dimension {
                what,
                found: v.len(),
                expected: n,
            });
        }
    }
    for (what, v) in [("the right-hand side", b), ("the first guess", x)] {
        if let Some(index) = first_non_finite(v) {
            return Err(PcgError::NonFinite {
                iteration: 0,
                what,
                index,
            });
        }
    }
    Ok(())
}

/// Residual and direction, both times a power of two that keeps their squares in range: it costs
/// no digit.
struct Iterate {
    scale: f64,
    r: Vec<f64>,
    r_norm: f64,
    z: Vec<f64>,
    p: Vec<f64>,
    ap: Vec<f64>,
    rz: f64,
    iteration: usize,
}

impl Iterate {
    fn start(op: &(impl LinearOperator + ?Sized), b: &[f64], x: &[f64]) -> Self {
        let n = b.len();
        let mut r = b.to_vec();
        let mut ap = vec![0.0; n];
        if x.iter().any(|&v| v != 0.0) {
            op.apply(x, &mut ap);
            axpy(-1.0, &ap, &mut r);
        }
        let scale = power_of_two(norm_inf(&r));
        r.iter_mut().for_each(|r| *r *= scale);
        Self {
            scale,
            r_norm: safe_norm(&r),
            r,
            z: vec![0.0; n],
            p: vec![0.0; n],
            ap,
            rz: 1.0,
            iteration: 0,
        }
    }

    /// What residuals are measured by: `‖b‖`, or the first residual when `b = 0`; scaled.
    fn reference(&self, b: &[f64]) -> f64 {
        if b.iter().all(|&v| v == 0.0) {
            self.r_norm
        } else {
            let own = power_of_two(norm_inf(b));
            let scaled: Vec<f64> = b.iter().map(|b| b * own).collect();
            norm(&scaled) * (self.scale / own)
        }
    }

    fn non_finite(&self, what: &'static str, v: &[f64]) -> PcgError {
        PcgError::NonFinite {
            iteration: self.iteration,
            what,
            index: first_non_finite(v).unwrap_or(0),
        }
    }

    /// The next direction: `z = M⁻¹ r`, `p ← z + β p`.
    fn turn(
        &mut self,
        precond: &(impl Preconditioner + ?Sized),
        null_space: NullSpace<'_>,
        relative_residual: f64,
    ) -> Result<(), PcgError> {
        precond.apply(&self.r, &mut self.z);
        let rz = dot(&self.r, &self.z);
        if !rz.is_finite() {
            return Err(self.non_finite("the preconditioned residual", &self.z));
        }
        let iteration = self.iteration;
        if rz <= 0.0 {
            return Err(match null_space {
                NullSpace::Allowed { .. } => PcgError::Inconsistent {
                    iteration,
                    relative_residual,
                },
                NullSpace::Excluded => PcgError::Preconditioner { iteration },
            });
        }
        let beta = if iteration == 0 { 0.0 } else { rz / self.rz };
        turn(beta, &self.z, &mut self.p);
        self.rz = rz;
        Ok(())
    }

    /// The step along it: `α = rᵀz / pᵀAp`, `x ← x + α p`, `r ← r − α A p`.
    fn advance(
        &mut self,
        op: &(impl LinearOperator + ?Sized),
        x: &mut [f64],
        null_space: NullSpace<'_>,
        relative_residual: f64,
    ) -> Result<(), PcgError> {
        op.apply(&self.p, &mut self.ap);
        let pap = dot(&self.p, &self.ap);
        if !pap.is_finite() {
            return Err(self.non_finite("the product A p", &self.ap));
        }
        // In a semidefinite matrix a direction with no curvature left is the null space.
        if let NullSpace::Allowed { diagonal } = null_space {
            let scale: f64 = self.p.iter().zip(diagonal).map(|(p, d)| d * p * p).sum();
            if pap.abs() <= NULL_CURVATURE * scale {
                return Err(PcgError::Inconsistent {
                    iteration: self.iteration,
                    relative_residual,
                });
            }
        }
        if pap <= 0.0 {
            return Err(PcgError::NegativeCurvature {
                iteration: self.iteration,
                curvature: pap / dot(&self.p, &self.p),
                direction: self.p.clone(),
            });
        }
        let alpha = self.rz / pap;
        let factors = (alpha, self.scale);
        let norm = step(factors, (&self.p, &self.ap), (x, &mut self.r)).sqrt();
        self.r_norm = if COMFORTABLE.contains(&norm) {
            norm
        } else {
            safe_norm(&self.r)
        };
        self.iteration += 1;
        Ok(())
    }
}

/// Largest entries whose squares and products with them are far from underflow and overflow.
const COMFORTABLE: std::ops::Range<f64> = 1e-60..1e60;

/// 1 for a vector of ordinary size, else the power of two that makes its largest entry about one.
pub(crate) fn power_of_two(largest: f64) -> f64 {
    if COMFORTABLE.contains(&largest) || !(largest > 0.0 && largest.is_finite()) {
        1.0
    } else {
        (-largest.log2().floor()).clamp(-1000.0, 1000.0).exp2()
    }
}

/// Euclidean norm that no square takes to zero or infinity.
fn safe_norm(v: &[f64]) -> f64 {
    let plain = norm(v);
    if COMFORTABLE.contains(&plain) {
        return plain;
    }
    let scale = power_of_two(norm_inf(v));
    let scaled: Vec<f64> = v.iter().map(|v| v * scale).collect();
    norm(&scaled) / scale
}
