//! What a step on a KKT system must lower.

use super::direction::multipliers_of;
use super::{ConstrainedProblem, Constraints};
use crate::float::worse;
use fem_solvers::{HessianProjection, NonlinearProblem};

/// E + κ/2 |c|² (eq. 20) or, with exact constraints, E on the points that meet them.
pub(super) struct Penalty<'a, P> {
    pub problem: &'a P,
    pub constraints: Constraints,
}

impl<P: ConstrainedProblem> Penalty<'_, P> {
    fn stiffness(&self) -> f64 {
        match self.constraints {
            Constraints::Exact => 0.0,
            Constraints::Relaxed { stiffness } => stiffness,
        }
    }

    fn constraint(&self, x: &[f64]) -> Vec<f64> {
        let mut c = vec![0.0; self.problem.constraints()];
        self.problem.constraint(x, &mut c);
        c
    }

    /// y += a ∇cᵀ λ.
    fn pull(&self, a: f64, lambda: &[f64], y: &mut [f64]) {
        let mut pull = vec![0.0; y.len()];
        self.problem.jacobian_transpose(lambda, &mut pull);
        for (y, pull) in y.iter_mut().zip(&pull) {
            *y += a * pull;
        }
    }
}

impl<P: ConstrainedProblem> NonlinearProblem<1> for Penalty<'_, P> {
    fn blocks(&self) -> usize {
        self.problem.unknowns()
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let energy = self.problem.energy(x);
        match self.constraints {
            Constraints::Exact => energy,
            Constraints::Relaxed { stiffness } => {
                let squares: f64 = self.constraint(x).iter().map(|c| c * c).sum();
                energy + 0.5 * stiffness * squares
            }
        }
    }

    /// With exact constraints only the part along them: ∇E − ∇cᵀλ with the λ that leaves least.
    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        self.problem.gradient(x, g);
        match self.constraints {
            Constraints::Relaxed { stiffness } => self.pull(stiffness, &self.constraint(x), g),
            Constraints::Exact => match multipliers_of(self.problem, g) {
                Ok(lambda) => self.pull(-1.0, &lambda, g),
                // Newton's method stops at a gradient that is not a number and says so.
                Err(_) => g.fill(f64::NAN),
            },
        }
    }

    fn hessian_vector(&self, x: &[f64], _: HessianProjection, d: &[f64], y: &mut [f64]) {
        self.problem.hessian(x, d, y);
        let mut along = vec![0.0; self.problem.constraints()];
        self.problem.jacobian(d, &mut along);
        self.pull(self.stiffness(), &along, y);
    }

    /// A few units in the last place of ∇E, ∇²E x, κ ∇cᵀ(∇c x) and κ ∇cᵀ(c − ∇c x).
    fn gradient_rounding(&self, x: &[f64]) -> Option<Vec<f64>> {
        let kappa = self.stiffness();
        let mut part = vec![0.0; x.len()];
        let largest = |part: &[f64]| part.iter().fold(0.0, |m, p| worse(m, p.abs()));
        self.problem.gradient(x, &mut part);
        let mut sum = largest(&part);
        self.problem.hessian(x, x, &mut part);
        sum += largest(&part);
        let mut along = vec![0.0; self.problem.constraints()];
        self.problem.jacobian(x, &mut along);
        let offset: Vec<f64> = self
            .constraint(x)
            .iter()
            .zip(&along)
            .map(|(c, along)| c - along)
            .collect();
        for part_of_c in [&along, &offset] {
            let mut part = vec![0.0; x.len()];
            self.pull(kappa, part_of_c, &mut part);
            sum += largest(&part);
        }
        Some(vec![8.0 * f64::EPSILON * sum; x.len()])
    }
}
