//! What a solve promises, summed again by other loops than its own: in scenes [`Newton`] and [`Rig`]
//! stand for those of the crates, and trust no `Ok`.

use crate::scenes::SceneError;
use face_rig::rig::{Equilibrium, Parameters, RigError, RigParams, Sensitivity};
use fem_assembly::{Assembly, AssemblyError, Quasistatic};
use fem_solvers::{
    BlockSymmetric, HessianProjection, NewtonInfo, NewtonParams, NonlinearProblem, StopReason,
};
use std::ops::Deref;

/// A solver whose every `Ok` is checked.
pub struct Newton(fem_solvers::Newton<'static, 3>);

impl Newton {
    /// For problems with this pattern.
    pub fn new(problem: &Quasistatic<'_, 3>) -> Self {
        Self(fem_solvers::Newton::new(problem))
    }

    /// As that of the crate.
    ///
    /// # Errors
    /// As there; [`SceneError::Unbalanced`] where a force is left that was promised not to be.
    pub fn solve(
        &mut self,
        problem: &Quasistatic<'_, 3>,
        x: &mut [f64],
        params: &NewtonParams,
    ) -> Result<NewtonInfo, SceneError> {
        let info = self.0.solve(problem, x, params)?;
        balanced(problem, x, params, info.stop)?;
        Ok(info)
    }
}

/// A rig whose every pose is checked.
pub struct Rig(face_rig::rig::Rig);

impl Rig {
    /// As that of the crate.
    ///
    /// # Errors
    /// As there.
    pub fn new(assembly: Assembly<3>, jaw: &[usize], params: RigParams) -> Result<Self, RigError> {
        face_rig::rig::Rig::new(assembly, jaw, params).map(Self)
    }

    /// As that of the crate.
    ///
    /// # Errors
    /// As there; [`SceneError::Unbalanced`] where a force is left that was promised not to be.
    pub fn solve(&mut self, pose: &Parameters) -> Result<(), SceneError> {
        let at = self.0.solve(pose)?;
        let (z, pose) = (at.in_cranium_frame.clone(), at.parameters.clone());
        let controls = self.0.energy_controls(&pose);
        let problem = Quasistatic::new(self.0.assembly(), z, controls)?;
        // A rig does not say which test its last solve met: the weakest promise.
        let stop = StopReason::Rounding;
        balanced(&problem, &problem.unknowns(), &self.0.params().newton, stop)
    }

    /// As that of the crate.
    ///
    /// # Errors
    /// As there.
    pub fn sensitivity(&mut self) -> Result<Sensitivity<'_>, RigError> {
        self.0.sensitivity()
    }

    /// As that of the crate.
    ///
    /// # Errors
    /// As there.
    pub fn start_from(&mut self, equilibrium: Equilibrium) -> Result<(), RigError> {
        self.0.start_from(equilibrium)
    }
}

impl Deref for Rig {
    type Target = face_rig::rig::Rig;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

/// Forces node by node in the order of the terms, without the rows and chunks that the solver summed.
fn balanced(
    problem: &Quasistatic<'_, 3>,
    x: &[f64],
    params: &NewtonParams,
    stop: StopReason,
) -> Result<(), SceneError> {
    let positions = problem.positions(x)?;
    let assembly = problem.assembly();
    let at = assembly.configuration(&positions, problem.controls())?;
    let everywhere = assembly.forces_everywhere(at);
    for (left, allowed) in left(problem, x, &everywhere, params, stop)? {
        if !(left <= allowed) {
            return Err(SceneError::Unbalanced { left, allowed });
        }
    }
    Ok(())
}

/// The forces `everywhere` that are left at the free unknowns, and what of each a stop allows (N); NaN of
/// a test that promises no force. Where nobody says which test was met, [`StopReason::Rounding`] is the
/// weakest promise.
///
/// # Errors
/// When there is no force for each node.
pub fn left(
    problem: &Quasistatic<'_, 3>,
    x: &[f64],
    everywhere: &[[f64; 3]],
    params: &NewtonParams,
    stop: StopReason,
) -> Result<Vec<(f64, f64)>, AssemblyError> {
    let dofs = problem.assembly().dofs();
    let left = dofs.gather(everywhere)?;
    let (floor, scales) = (rounding(problem, x), problem.gradient_scales(x));
    let is_free = |i: &usize| !dofs.is_prescribed(dofs.node_of_row()[i / 3] as usize, i % 3);
    let of = |i: usize| {
        let scale = params.reference.or_else(|| Some(scales.as_ref()?[i]));
        let share = params.relative_gradient_tolerance * scale.unwrap_or(0.0);
        let share = params.gradient_tolerance.max(share);
        let promised = match stop {
            StopReason::Gradient => params.gradient_tolerance,
            StopReason::RelativeGradient => share,
            StopReason::Rounding => share.max(floor[i]),
            // A step tolerance promises no force.
            _ => f64::NAN,
        };
        // Another order of the sums has another rounding.
        (left[i].abs(), promised + floor[i])
    };
    Ok((0..left.len()).filter(is_free).map(of).collect())
}

/// 4 ε times Σⱼ |Kᵢⱼ| |xⱼ|, and what the problem says of its own sums, whichever is larger (N).
fn rounding(problem: &Quasistatic<'_, 3>, x: &[f64]) -> Vec<f64> {
    let pattern = problem.assembly().pattern();
    let mut matrix = BlockSymmetric::<3>::zeros(pattern.clone());
    problem.hessian(x, HessianProjection::None, &mut matrix);
    let mut sums = vec![0.0; x.len()];
    for row in 0..pattern.blocks() {
        for (k, &column) in (pattern.row_start()[row]..).zip(pattern.row(row)) {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let (r, c) = (3 * row + i, 3 * column as usize + j);
                let entry = matrix.values()[k][i][j].abs();
                sums[r] += entry * x[c].abs();
                if row != column as usize {
                    sums[c] += entry * x[r].abs();
                }
            }
        }
    }
    let own = problem.gradient_rounding(x);
    let own = own.unwrap_or_else(|| vec![0.0; x.len()]);
    let floor = |(own, sum): (f64, f64)| own.max(4.0 * f64::EPSILON * sum);
    own.into_iter().zip(sums).map(floor).collect()
}
