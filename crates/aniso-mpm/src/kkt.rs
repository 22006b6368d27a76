//! Relaxed KKT systems for linear constraints (document 001, section 4.3).
//!
//! The problem is min E(x) with c(x) = 0 and constant ∇c. The document adds (1/η) I to the lower
//! right block of the KKT matrix (eq. 16) and asks for η → −∞. Here the same number is a positive
//! stiffness κ = −η: eliminating λ = η (c + ∇c Δx) from eq. 16 leaves
//!
//! ```text
//! (∇²E + κ ∇cᵀ∇c) Δx = −(∇E + κ ∇cᵀ c),
//! ```
//!
//! Newton's method on the penalty function E + κ/2 |c|² (eq. 20). That system is symmetric
//! positive definite where the KKT matrix is only quasi-definite, so conjugate gradients solve
//! it; with a negative κ (a positive η) it would reward violated constraints.

use crate::error::{MpmError, positive, same_length};
use crate::float::worse;
use fem_solvers::{
    AssumedPositiveDefinite, LinearOperator, PcgError, PcgParams, Preconditioner, Structure, pcg,
};

/// A convex energy with linear constraints.
pub trait ConstrainedProblem {
    /// Number of unknowns.
    fn unknowns(&self) -> usize;
    /// Number of constraints.
    fn constraints(&self) -> usize;
    /// ∇E(x).
    fn gradient(&self, x: &[f64], g: &mut [f64]);
    /// y = ∇²E(x) d.
    fn hessian(&self, x: &[f64], d: &[f64], y: &mut [f64]);
    /// The diagonal of ∇²E(x) + κ ∇cᵀ∇c, or anything positive close to it.
    fn diagonal(&self, x: &[f64], stiffness: f64, diagonal: &mut [f64]);
    /// c(x).
    fn constraint(&self, x: &[f64], c: &mut [f64]);
    /// y = ∇c d.
    fn jacobian(&self, d: &[f64], y: &mut [f64]);
    /// y = ∇cᵀ λ.
    fn jacobian_transpose(&self, lambda: &[f64], y: &mut [f64]);
}

/// How hard the constraints are and when to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxedKkt {
    /// κ = −η > 0; the constraint is met to O(1/κ).
    pub stiffness: f64,
    /// Stop when |Δx| ≤ tolerance (1 + |x|), in the largest component.
    pub tolerance: f64,
    /// Give up after this many Newton steps.
    pub max_iterations: usize,
}

/// A minimizer of the relaxed problem.
#[derive(Clone, Debug, PartialEq)]
pub struct KktSolution {
    /// x*.
    pub x: Vec<f64>,
    /// λ* = η c(x*) = −κ c(x*), eq. 18, as the last KKT system gave it (κ c would lose digits).
    pub lambda: Vec<f64>,
    /// Every iterate, the start included.
    pub iterates: Vec<Vec<f64>>,
}

impl RelaxedKkt {
    /// Full Newton steps on eq. 16 from `x`.
    ///
    /// # Errors
    /// A stiffness that is not positive, a start of the wrong length, a linear solve that failed (a
    /// gradient or constraint that is not a number makes it fail), or no convergence.
    pub fn solve(
        &self,
        problem: &impl ConstrainedProblem,
        x: &[f64],
    ) -> Result<KktSolution, MpmError> {
        positive("stiffness of the relaxed constraints", self.stiffness)?;
        let (n, m) = (problem.unknowns(), problem.constraints());
        same_length("start of the relaxed KKT system", x.len(), n)?;
        let mut x = x.to_vec();
        let mut iterates = vec![x.clone()];
        let (mut g, mut c) = (vec![0.0; n], vec![0.0; m]);
        let (mut size, mut target) = (f64::INFINITY, self.tolerance);
        for iteration in 0..self.max_iterations {
            problem.gradient(&x, &mut g);
            problem.constraint(&x, &mut c);
            let step = self.newton_step(problem, &x, &g, &c);
            let (dx, lambda) = step.map_err(|error| MpmError::Solve {
                system: "relaxed KKT",
                message: format!("Newton step {iteration}: {error}"),
            })?;
            size = 0.0;
            let mut scale = 1.0f64;
            for i in 0..n {
                x[i] += dx[i];
                size = worse(size, dx[i].abs());
                scale = worse(scale, x[i].abs());
            }
            iterates.push(x.clone());
            target = self.tolerance * scale;
            if size <= target {
                return Ok(KktSolution {
                    x,
                    lambda,
                    iterates,
                });
            }
        }
        Err(MpmError::Newton {
            system: "relaxed KKT",
            reason: "has not converged",
            iterations: self.max_iterations,
            change: size,
            tolerance: target,
            last: x,
        })
    }

    /// Δx and λ of eq. 16 at x, by conjugate gradients on the penalized system.
    ///
    /// The elimination of λ costs digits as κ grows. They come back by refining on the residuals
    /// of eq. 16 itself, where κ appears only as 1/η.
    fn newton_step(
        &self,
        problem: &impl ConstrainedProblem,
        x: &[f64],
        g: &[f64],
        c: &[f64],
    ) -> Result<(Vec<f64>, Vec<f64>), PcgError> {
        let (n, m) = (g.len(), c.len());
        let eta = -self.stiffness;
        let mut diagonal = vec![0.0; n];
        problem.diagonal(x, self.stiffness, &mut diagonal);
        let system = Penalized {
            problem,
            x,
            stiffness: self.stiffness,
        };
        let preconditioner = Jacobi(diagonal);
        let params = PcgParams {
            relative_tolerance: 1e-10,
            max_iterations: 20 * n + 100,
            ..PcgParams::default()
        };
        let (mut dx, mut lambda) = (vec![0.0; n], vec![0.0; m]);
        let (mut Hdx, mut pull, mut Gdx) = (vec![0.0; n], vec![0.0; n], vec![0.0; m]);
        for _ in 0..5 {
            // r1 = −∇E − ∇²E Δx + ∇cᵀλ,  r2 = c + ∇c Δx − λ/η
            problem.hessian(x, &dx, &mut Hdx);
            problem.jacobian_transpose(&lambda, &mut pull);
            problem.jacobian(&dx, &mut Gdx);
            let r2: Vec<f64> = (0..m).map(|j| c[j] + Gdx[j] - lambda[j] / eta).collect();
            let mut rhs: Vec<f64> = (0..n).map(|i| pull[i] - g[i] - Hdx[i]).collect();
            problem.jacobian_transpose(&r2, &mut pull);
            for i in 0..n {
                rhs[i] += eta * pull[i];
            }
            let mut correction = vec![0.0; n];
            pcg(
                &AssumedPositiveDefinite(&system),
                &preconditioner,
                &rhs,
                &mut correction,
                &params,
            )?;
            problem.jacobian(&correction, &mut Gdx);
            let mut small = true;
            for i in 0..n {
                dx[i] += correction[i];
                small &= correction[i].abs() <= 1e-15 * (1.0 + dx[i].abs());
            }
            for j in 0..m {
                lambda[j] += eta * (r2[j] + Gdx[j]);
            }
            if small {
                break;
            }
        }
        Ok((dx, lambda))
    }
}

struct Jacobi(Vec<f64>);
impl Preconditioner for Jacobi {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for ((z, r), d) in z.iter_mut().zip(r).zip(&self.0) {
            *z = r / d;
        }
    }
}

/// ∇²E + κ ∇cᵀ∇c at x.
struct Penalized<'a, P> {
    problem: &'a P,
    x: &'a [f64],
    stiffness: f64,
}
impl<P: ConstrainedProblem> LinearOperator for Penalized<'_, P> {
    fn dim(&self) -> usize {
        self.problem.unknowns()
    }
    fn structure(&self) -> Structure {
        // Definite where E is convex, which is the problem's promise and not known here.
        Structure::Symmetric
    }
    fn apply(&self, d: &[f64], y: &mut [f64]) {
        self.problem.hessian(self.x, d, y);
        let mut c = vec![0.0; self.problem.constraints()];
        self.problem.jacobian(d, &mut c);
        let mut pull = vec![0.0; d.len()];
        self.problem.jacobian_transpose(&c, &mut pull);
        for (y, pull) in y.iter_mut().zip(&pull) {
            *y += self.stiffness * pull;
        }
    }
}
