//! The stiffness at a pose, ready to be solved with.

use super::{Equilibrium, MultigridUse, Rig};
use crate::rig::error::RigError;
use crate::rig::jacobian::{CountedSolver, Sensitivity};
use crate::stopwatch::Stopwatch;
use fem_assembly::Quasistatic;
use fem_solvers::{
    BlockPattern, BlockSymmetric, CholeskyFactor, HessianProjection, MatrixPreconditioner,
    Multigrid, MultigridParams, NonlinearProblem, PcgError, PreconditionerError, SolveManyInfo,
    SolveManyParams,
};
use std::sync::Arc;

#[cfg(test)]
mod tests;

/// A hierarchy of rigid motions.
type Hierarchy = Multigrid<3, 6>;

/// A pose with its stiffness: neighboring poses start from its prediction.
pub(super) struct Tangent {
    pub at: Equilibrium,
    /// What the energy was given there.
    pub energy: Vec<f64>,
    pub stiffness: Stiffness,
}

/// What K dx = f is solved with.
#[derive(Debug)]
pub(in crate::rig) enum Stiffness {
    Factored(CholeskyFactor<f64, 3>),
    Multilevel(Box<(BlockSymmetric<3>, Hierarchy)>),
}

impl Stiffness {
    fn multilevel(
        problem: &Quasistatic<'_, 3>,
        x: &[f64],
        pattern: &Arc<BlockPattern>,
    ) -> Result<Self, PreconditionerError> {
        let mut matrix = BlockSymmetric::zeros(pattern.clone());
        problem.hessian(x, HessianProjection::None, &mut matrix);
        matrix.fill_padding();
        let mut hierarchy = Hierarchy::new(problem.near_kernel(x), MultigridParams::default());
        hierarchy.update(&matrix)?;
        Ok(Self::Multilevel(Box::new((matrix, hierarchy))))
    }

    /// `X ← K⁻¹ X` for `count` columns, to this error in the norm of K where it is not a factor.
    pub fn solve_many(
        &self,
        block: &mut [f64],
        count: usize,
        tolerance: f64,
    ) -> Result<SolveManyInfo, RigError> {
        match self {
            Self::Factored(factor) => {
                factor.solve_many(block, count);
                Ok(SolveManyInfo::default())
            }
            Self::Multilevel(made) => {
                let (matrix, hierarchy) = &**made;
                let params = SolveManyParams {
                    energy_tolerance: tolerance,
                    ..SolveManyParams::default()
                };
                let solved = hierarchy.solve_many(matrix, block, count, &params);
                solved.map_err(|error| match error {
                    PcgError::NegativeCurvature { .. } => RigError::Unstable(error.into()),
                    PcgError::Preconditioner { .. } => RigError::Preconditioner(error),
                    error => RigError::Derivative(error),
                })
            }
        }
    }
}

impl Rig {
    /// The exact derivative at the last solved pose, for as many right-hand sides as there are numbers in
    /// a pose; see [`sensitivity_for`](Self::sensitivity_for).
    ///
    /// # Errors
    /// [`RigError::Unstable`] where the stiffness is not positive definite.
    pub fn sensitivity(&mut self) -> Result<Sensitivity<'_>, RigError> {
        let jaw = 12;
        self.sensitivity_for(self.muscles() + jaw + self.controls())
    }

    /// The derivative at the last solved pose, for about this many right-hand sides
    /// ([`JacobianRoute::right_hand_sides`](crate::rig::JacobianRoute::right_hand_sides)). The stiffness is factored once, here,
    /// or a multigrid hierarchy is made for it, as [`RigParams::multigrid`](super::RigParams::multigrid) says; what
    /// was made at this pose before serves again.
    ///
    /// # Errors
    /// [`RigError::Unstable`] where the stiffness is not positive definite. A factor always finds that out,
    /// here. Where a level of a hierarchy shows it, and what else keeps one from being made, a factor decides;
    /// with [`MultigridUse::Always`], which allows none, it is [`RigError::Hierarchy`]. The conjugate gradients
    /// find it later where the Krylov space of a right-hand side does; what none of them sees passes.
    pub fn sensitivity_for(
        &mut self,
        right_hand_sides: usize,
    ) -> Result<Sensitivity<'_>, RigError> {
        let begin = Stopwatch::start();
        let at = self.equilibrium.clone();
        self.renew(&at)?;
        self.ensure_tangent(&at, right_hand_sides)?;
        self.work.jacobian_time += begin.elapsed();
        let Self {
            assembly,
            jaw,
            controls,
            equilibrium,
            tangent,
            right_hand_sides,
            derivative_iterations,
            params,
            ..
        } = self;
        let tangent = tangent.as_ref().ok_or(RigError::NoTangent)?;
        let solver = CountedSolver {
            stiffness: &tangent.stiffness,
            tolerance: params.derivative_tolerance,
            right_hand_sides,
            iterations: derivative_iterations,
        };
        let energy = &tangent.energy;
        Ok(Sensitivity::new(
            assembly,
            jaw,
            controls,
            equilibrium,
            energy,
            solver,
        )?)
    }

    pub(super) fn ensure_tangent(
        &mut self,
        at: &Equilibrium,
        right_hand_sides: usize,
    ) -> Result<(), RigError> {
        if self.tangent.as_ref().is_some_and(|t| t.at == *at) {
            return Ok(());
        }
        // Its memory serves again.
        self.tangent = None;
        let energy = self.controls.of_energy(&at.parameters);
        let multilevel = self.iterates_for(right_hand_sides);
        let stiffness = self.stiffness_at(at, energy.clone(), multilevel)?;
        self.tangent = Some(Tangent {
            at: at.clone(),
            energy,
            stiffness,
        });
        Ok(())
    }

    /// A hierarchy where one is asked for; where it cannot be made, a factor unless
    /// [`MultigridUse::Always`].
    fn stiffness_at(
        &mut self,
        at: &Equilibrium,
        energy: Vec<f64>,
        multilevel: bool,
    ) -> Result<Stiffness, RigError> {
        let Self {
            assembly,
            newton,
            work,
            params,
            ..
        } = self;
        let problem = Quasistatic::new(assembly, at.in_cranium_frame.clone(), energy)?;
        let x = problem.unknowns();
        if multilevel {
            match Stiffness::multilevel(&problem, &x, assembly.pattern()) {
                Ok(made) => return Ok(made),
                Err(error) if params.multigrid == MultigridUse::Always => {
                    return Err(RigError::Hierarchy(error));
                }
                // A factor tells an unstable pose from what only the hierarchy cannot do.
                Err(_) => {}
            }
        }
        let factor = newton.factor_at(&problem, &x)?;
        work.factorizations += 1;
        Ok(Stiffness::Factored(factor))
    }

    /// Are this many right-hand sides solved for by conjugate gradients?
    fn iterates_for(&mut self, right_hand_sides: usize) -> bool {
        let cheaper = |symbolic| Hierarchy::solves_cheaper_than(symbolic, right_hand_sides);
        self.multigrid
            && (self.params.multigrid == MultigridUse::Always
                || self.newton.symbolic().is_some_and(|s| cheaper(s)))
    }
}
