//! Δx and λ of eq. 15 and 16, by conjugate gradients on the penalized system.

use super::{ConstrainedProblem, Constraints};
use crate::float::worse;
use fem_solvers::{
    AssumedPositiveDefinite, Descent, DescentDirection, DescentOutcome, LinearOperator,
    NewtonFailure, NewtonSystem, PcgError, PcgParams, Preconditioner, Structure, pcg,
    pcg_semidefinite,
};

/// Most rounds of refinement: relaxed systems take two or three, each gains exact ones some digits.
const ROUNDS: usize = 30;
/// The penalized system's stiffness over the energy's, for exact constraints.
const EXACT_STIFFNESS: f64 = 1e3;

/// Newton's directions.
pub(super) struct KktDirection<'a, P> {
    pub problem: &'a P,
    pub constraints: Constraints,
    /// Where the steps started.
    pub iterates: &'a mut Vec<Vec<f64>>,
}

impl<P: ConstrainedProblem> DescentDirection<1> for KktDirection<'_, P> {
    fn direction(
        &mut self,
        system: &mut NewtonSystem<'_, 1>,
        dx: &mut [f64],
    ) -> Result<Descent, NewtonFailure> {
        let x = system.at();
        if self.iterates.last().is_none_or(|last| last != x) {
            self.iterates.push(x.to_vec());
        }
        let step = kkt_step(self.problem, self.constraints, x)?;
        dx.copy_from_slice(&step.dx);
        Ok(Descent::iterated(DescentOutcome::Found, step.iterations))
    }
}

/// The solution of one KKT system.
#[derive(Clone, Debug, PartialEq)]
pub struct KktStep {
    /// Δx.
    pub dx: Vec<f64>,
    /// λ.
    pub lambda: Vec<f64>,
    /// Iterations of conjugate gradients.
    pub iterations: usize,
}

/// Δx and λ at x.
///
/// The elimination of λ costs digits as κ grows, and is not exact where the constraints are. What is
/// missing comes by refining on the residuals of eq. 15 or 16 itself, where κ appears only as 1/η.
pub(super) fn kkt_step<P: ConstrainedProblem>(
    problem: &P,
    constraints: Constraints,
    x: &[f64],
) -> Result<KktStep, PcgError> {
    let (n, m) = (problem.unknowns(), problem.constraints());
    let (mut g, mut c) = (vec![0.0; n], vec![0.0; m]);
    problem.gradient(x, &mut g);
    problem.constraint(x, &mut c);
    let (stiffness, softness) = match constraints {
        Constraints::Relaxed { stiffness } => (stiffness, 1.0 / stiffness),
        Constraints::Exact => (exact_stiffness(problem, x), 0.0),
    };
    let system = Penalized::new(problem, x, stiffness);
    let (mut dx, mut lambda) = (vec![0.0; n], vec![0.0; m]);
    let (mut Hdx, mut pull, mut Gdx) = (vec![0.0; n], vec![0.0; n], vec![0.0; m]);
    let (mut iterations, mut change) = (0, f64::INFINITY);
    let size = x.iter().fold(0.0, |m, x| worse(m, x.abs()));
    for _ in 0..ROUNDS {
        // r1 = −∇E − ∇²E Δx + ∇cᵀλ,  r2 = c + ∇c Δx − λ/η
        problem.hessian(x, &dx, &mut Hdx);
        problem.jacobian_transpose(&lambda, &mut pull);
        problem.jacobian(&dx, &mut Gdx);
        let r2: Vec<f64> = (0..m)
            .map(|j| c[j] + Gdx[j] + softness * lambda[j])
            .collect();
        let mut rhs: Vec<f64> = (0..n).map(|i| pull[i] - g[i] - Hdx[i]).collect();
        problem.jacobian_transpose(&r2, &mut pull);
        for i in 0..n {
            rhs[i] -= stiffness * pull[i];
        }
        let (correction, taken) = system.solve(&rhs)?;
        iterations += taken;
        problem.jacobian(&correction, &mut Gdx);
        let (mut largest, mut moved) = (size, 0.0);
        for i in 0..n {
            dx[i] += correction[i];
            moved = worse(moved, correction[i].abs());
            largest = worse(largest, dx[i].abs());
        }
        // A step of nothing but zeros has nothing to refine.
        change = if moved == 0.0 { 0.0 } else { moved / largest };
        for j in 0..m {
            lambda[j] -= stiffness * (r2[j] + Gdx[j]);
        }
        if change <= 1e-15 {
            break;
        }
    }
    // Rounding of the residuals keeps the last digits moving.
    if !(change <= 1e-10) {
        return Err(PcgError::NotConverged {
            iterations,
            relative_residual: change,
        });
    }
    Ok(KktStep {
        dx,
        lambda,
        iterations,
    })
}

/// A stiffness that makes the constraints' part of the penalized system the larger one by far.
fn exact_stiffness<P: ConstrainedProblem>(problem: &P, x: &[f64]) -> f64 {
    let largest = |stiffness: f64| {
        let mut diagonal = vec![0.0; x.len()];
        problem.diagonal(x, stiffness, &mut diagonal);
        diagonal.into_iter().fold(0.0, worse)
    };
    let energy = largest(0.0);
    // With a stiffness this large next to nothing of the energy is left in the diagonal.
    let much = 1e12 * if energy > 0.0 { energy } else { 1.0 };
    let of_constraints = largest(much) / much;
    EXACT_STIFFNESS * energy / of_constraints
}

/// The λ for which ∇E − ∇cᵀλ is smallest.
pub(super) fn multipliers_of<P: ConstrainedProblem>(
    problem: &P,
    gradient: &[f64],
) -> Result<Vec<f64>, PcgError> {
    let mut rhs = vec![0.0; problem.constraints()];
    problem.jacobian(gradient, &mut rhs);
    normal_solve(problem, &rhs)
}

/// Moves x to the nearest point with c(x) = 0.
pub(super) fn nearest<P: ConstrainedProblem>(problem: &P, x: &mut [f64]) -> Result<(), PcgError> {
    let mut pull = vec![0.0; x.len()];
    // The second round takes away what the first left by its tolerance.
    for _ in 0..2 {
        let mut c = vec![0.0; problem.constraints()];
        problem.constraint(x, &mut c);
        let lambda = normal_solve(problem, &c)?;
        problem.jacobian_transpose(&lambda, &mut pull);
        for (x, pull) in x.iter_mut().zip(&pull) {
            *x -= pull;
        }
    }
    Ok(())
}

/// (∇c ∇cᵀ) λ = rhs; constraints may depend on each other.
fn normal_solve<P: ConstrainedProblem>(problem: &P, rhs: &[f64]) -> Result<Vec<f64>, PcgError> {
    let mut lambda = vec![0.0; rhs.len()];
    let ones = vec![1.0; rhs.len()];
    pcg_semidefinite(
        &Normal(problem),
        &ones,
        rhs,
        &mut lambda,
        &accurate(rhs.len()),
    )?;
    Ok(lambda)
}

fn accurate(unknowns: usize) -> PcgParams {
    PcgParams {
        relative_tolerance: 1e-10,
        max_iterations: 20 * unknowns + 100,
        ..PcgParams::default()
    }
}

/// ∇c ∇cᵀ.
struct Normal<'a, P>(&'a P);
impl<P: ConstrainedProblem> LinearOperator for Normal<'_, P> {
    fn dim(&self) -> usize {
        self.0.constraints()
    }
    fn structure(&self) -> Structure {
        Structure::SymmetricPositiveSemidefinite
    }
    fn apply(&self, d: &[f64], y: &mut [f64]) {
        let mut pull = vec![0.0; self.0.unknowns()];
        self.0.jacobian_transpose(d, &mut pull);
        self.0.jacobian(&pull, y);
    }
}

/// ∇²E + κ ∇cᵀ∇c at x.
struct Penalized<'a, P> {
    problem: &'a P,
    x: &'a [f64],
    stiffness: f64,
    diagonal: Jacobi,
}

impl<'a, P: ConstrainedProblem> Penalized<'a, P> {
    fn new(problem: &'a P, x: &'a [f64], stiffness: f64) -> Self {
        let mut diagonal = vec![0.0; x.len()];
        problem.diagonal(x, stiffness, &mut diagonal);
        Self {
            problem,
            x,
            stiffness,
            diagonal: Jacobi(diagonal),
        }
    }

    /// The solution and the iterations it took.
    fn solve(&self, rhs: &[f64]) -> Result<(Vec<f64>, usize), PcgError> {
        let mut solution = vec![0.0; rhs.len()];
        // Definite where E is convex, which is the problem's promise and not known here.
        let system = AssumedPositiveDefinite(self);
        let params = accurate(rhs.len());
        let info = pcg(&system, &self.diagonal, rhs, &mut solution, &params)?;
        Ok((solution, info.iterations))
    }
}

impl<P: ConstrainedProblem> LinearOperator for Penalized<'_, P> {
    fn dim(&self) -> usize {
        self.problem.unknowns()
    }
    fn structure(&self) -> Structure {
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

struct Jacobi(Vec<f64>);
impl Preconditioner for Jacobi {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for ((z, r), d) in z.iter_mut().zip(r).zip(&self.0) {
            *z = r / d;
        }
    }
}
