//! Preconditioned conjugate gradients.

use crate::operator::{LinearOperator, Preconditioner, Structure};
use crate::vector::{axpy, dot, first_non_finite, norm};
use thiserror::Error;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PcgParams {
    /// Stop when `‖b − A x‖ ≤ relative_tolerance · ‖b‖`.
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
pub struct PcgInfo {
    /// Products with the operator, not counting the one for a non-zero first guess.
    pub iterations: usize,
    /// `‖b − A x‖ / ‖b‖` by the recurrence; 0 for `b = 0`.
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
/// With [`Identity`](crate::Identity) these are the plain conjugate gradients of doc 000, Algorithm 1.
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
/// space (in the scaled inner product).
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
    let n = op.dim();
    for (what, found) in [
        ("the right-hand side", b.len()),
        ("the first guess", x.len()),
    ] {
        if found != n {
            return Err(PcgError::Dimension {
                what,
                found,
                expected: n,
            });
        }
    }
    for (what, v) in [("the right-hand side", b), ("the first guess", &*x)] {
        if let Some(index) = first_non_finite(v) {
            return Err(PcgError::NonFinite {
                iteration: 0,
                what,
                index,
            });
        }
    }
    let b_norm = norm(b);
    if b_norm == 0.0 {
        x.fill(0.0);
        return Ok(PcgInfo {
            iterations: 0,
            relative_residual: 0.0,
        });
    }
    let target = (params.relative_tolerance * b_norm).max(params.absolute_tolerance);

    let mut r = b.to_vec();
    let mut ap = vec![0.0; n];
    if x.iter().any(|&v| v != 0.0) {
        op.apply(x, &mut ap);
        axpy(-1.0, &ap, &mut r);
    }
    let mut z = vec![0.0; n];
    let mut p = vec![0.0; n];
    let mut rz_old = 1.0;
    let mut r_norm = norm(&r);
    let (mut best, mut since_best) = (r_norm, 0);
    let mut iteration = 0;
    loop {
        if !r_norm.is_finite() {
            let index = first_non_finite(&r).unwrap_or(0);
            return Err(PcgError::NonFinite {
                iteration,
                what: "the residual",
                index,
            });
        }
        let relative_residual = r_norm / b_norm;
        if r_norm <= target {
            return Ok(PcgInfo {
                iterations: iteration,
                relative_residual,
            });
        }
        if iteration == params.max_iterations {
            return Err(PcgError::NotConverged {
                iterations: iteration,
                relative_residual,
            });
        }
        if r_norm < best {
            (best, since_best) = (r_norm, 0);
        } else {
            since_best += 1;
            if since_best > params.stagnation_window {
                return Err(PcgError::Stagnated {
                    iterations: iteration,
                    relative_residual: best / b_norm,
                });
            }
        }

        precond.apply(&r, &mut z);
        let rz = dot(&r, &z);
        if !rz.is_finite() {
            let index = first_non_finite(&z).unwrap_or(0);
            return Err(PcgError::NonFinite {
                iteration,
                what: "the preconditioned residual",
                index,
            });
        }
        if rz <= 0.0 {
            return Err(match null_space {
                NullSpace::Allowed { .. } => PcgError::Inconsistent {
                    iteration,
                    relative_residual,
                },
                NullSpace::Excluded => PcgError::Preconditioner { iteration },
            });
        }
        let beta = if iteration == 0 { 0.0 } else { rz / rz_old };
        for (p, z) in p.iter_mut().zip(&z) {
            *p = z + beta * *p;
        }
        op.apply(&p, &mut ap);
        let pap = dot(&p, &ap);
        if !pap.is_finite() {
            let index = first_non_finite(&ap).unwrap_or(0);
            return Err(PcgError::NonFinite {
                iteration,
                what: "the product A p",
                index,
            });
        }
        // In a semidefinite matrix a direction with no curvature left is the null space.
        if let NullSpace::Allowed { diagonal } = null_space {
            let scale: f64 = p.iter().zip(diagonal).map(|(p, d)| d * p * p).sum();
            if pap.abs() <= NULL_CURVATURE * scale {
                return Err(PcgError::Inconsistent {
                    iteration,
                    relative_residual,
                });
            }
        }
        if pap <= 0.0 {
            return Err(PcgError::NegativeCurvature {
                iteration,
                curvature: pap / dot(&p, &p),
                direction: p,
            });
        }
        let alpha = rz / pap;
        axpy(alpha, &p, x);
        axpy(-alpha, &ap, &mut r);
        rz_old = rz;
        r_norm = norm(&r);
        iteration += 1;
    }
}
