//! What a solve promises, checked by other sums than its own: in tests [`Newton`], [`solve_renewing`] and
//! [`solve_walking`] stand for those of the crates, and trust no `Ok`.
#![allow(dead_code)] // Crates share this file.

use fem_assembly::{
    Assembly, Evaluations, Quasistatic, RenewedSolution, RenewingError, WalkError, WalkedSolution,
};
use fem_solvers::{
    ContinuationParams, DescentDirection, HessianProjection, NewtonError, NewtonInfo, NewtonParams,
    NonlinearProblem, StopReason,
};
use std::ops::{Deref, DerefMut};

/// A solver whose every `Ok` is checked.
pub struct Newton<'d, const D: usize> {
    inner: fem_solvers::Newton<'d, D>,
    evaluated: Evaluations,
}

impl<'d, const D: usize> Newton<'d, D> {
    pub fn new(problem: &Quasistatic<'_, D>) -> Self {
        Self::of(fem_solvers::Newton::new(problem))
    }

    pub fn with_direction(
        problem: &Quasistatic<'_, D>,
        direction: impl DescentDirection<D> + 'd,
    ) -> Self {
        Self::of(fem_solvers::Newton::with_direction(problem, direction))
    }

    fn of(inner: fem_solvers::Newton<'d, D>) -> Self {
        let evaluated = Evaluations::default();
        Self { inner, evaluated }
    }

    #[track_caller]
    pub fn solve(
        &mut self,
        problem: &Quasistatic<'_, D>,
        x: &mut [f64],
        params: &NewtonParams,
    ) -> Result<NewtonInfo, NewtonError> {
        let solved = self.inner.solve(problem, x, params);
        self.evaluated = problem.assembly().evaluations();
        if let Ok(info) = &solved {
            kept(problem, x, params, info.stop);
        }
        solved
    }

    /// What the body had evaluated when the last solve ended, before it was checked.
    pub fn evaluated(&self) -> Evaluations {
        self.evaluated
    }
}

impl<'d, const D: usize> Deref for Newton<'d, D> {
    type Target = fem_solvers::Newton<'d, D>;
    fn deref(&self) -> &Self::Target {
        &self.inner
    }
}

impl<const D: usize> DerefMut for Newton<'_, D> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.inner
    }
}

#[track_caller]
pub fn solve_renewing<const D: usize>(
    assembly: &mut Assembly<D>,
    newton: &mut Newton<'_, D>,
    start: Vec<[f64; D]>,
    controls: &[f64],
    params: &NewtonParams,
) -> Result<RenewedSolution<D>, RenewingError<D>> {
    let solved = fem_assembly::solve_renewing(assembly, newton, start, controls, params);
    newton.evaluated = assembly.evaluations();
    if let Ok(done) = &solved {
        let stop = done.info.expect("a solve").stop;
        came_to_rest(assembly, &done.positions, controls, params, stop);
    }
    solved
}

#[track_caller]
pub fn solve_walking<const D: usize>(
    assembly: &mut Assembly<D>,
    newton: &mut Newton<'_, D>,
    from: Vec<[f64; D]>,
    to: &[[f64; D]],
    controls: &[f64],
    params: &NewtonParams,
    walk: &ContinuationParams,
) -> Result<WalkedSolution<D>, WalkError<D>> {
    let walked = fem_assembly::solve_walking(assembly, newton, from, to, controls, params, walk);
    newton.evaluated = assembly.evaluations();
    if let Ok(there) = &walked {
        // Nobody says which test was met: the weakest promise.
        let stop = StopReason::Rounding;
        came_to_rest(assembly, &there.positions, controls, params, stop);
    }
    walked
}

/// [`kept`] of a body, its stencils those that it holds.
#[track_caller]
pub fn came_to_rest<const D: usize>(
    assembly: &Assembly<D>,
    positions: &[[f64; D]],
    controls: &[f64],
    params: &NewtonParams,
    stop: StopReason,
) {
    let problem = Quasistatic::new(assembly, positions.to_vec(), controls.to_vec()).unwrap();
    kept(&problem, &problem.unknowns(), params, stop);
}

/// Fails unless every force that is left at `x` is what [`NewtonInfo::stop`] allows: node by node in the
/// order of the terms, without the rows and chunks that the solver summed, and with products instead of
/// a matrix for the rounding.
#[track_caller]
pub fn kept<const D: usize>(
    problem: &Quasistatic<'_, D>,
    x: &[f64],
    params: &NewtonParams,
    stop: StopReason,
) {
    let assembly = problem.assembly();
    let positions = problem.positions(x).unwrap();
    let at = assembly
        .configuration(&positions, problem.controls())
        .unwrap();
    let left = assembly
        .dofs()
        .gather(&assembly.forces_everywhere(at))
        .unwrap();
    let prescribed = prescribed_axes(problem, x);
    let scales = problem.gradient_scales(x);
    // Another order of the sums has another rounding: twice the floor.
    let floor = rounding(problem, x);
    for (i, force) in left.iter().enumerate().filter(|(i, _)| !prescribed[*i]) {
        let scale = params.reference.or_else(|| Some(scales.as_ref()?[i]));
        let share = params.relative_gradient_tolerance * scale.unwrap_or(0.0);
        let allowed = match stop {
            StopReason::Gradient => params.gradient_tolerance,
            StopReason::RelativeGradient => params.gradient_tolerance.max(share),
            StopReason::Rounding => params.gradient_tolerance.max(share).max(floor[i]),
            _ => f64::INFINITY,
        };
        assert!(
            force.abs() <= allowed + floor[i],
            "{force:e} N left of unknown {i}, {allowed:e} N promised by {stop:?}"
        );
    }
}

/// Axes of partly free nodes that are prescribed: their force is a reaction.
fn prescribed_axes<const D: usize>(problem: &Quasistatic<'_, D>, x: &[f64]) -> Vec<bool> {
    let moved: Vec<f64> = x.iter().map(|x| x + 1.0).collect();
    let back = problem
        .assembly()
        .dofs()
        .gather(&problem.positions(&moved).unwrap())
        .unwrap();
    // A solve may leave rounding in what it does not move.
    back.iter()
        .zip(x)
        .map(|(b, x)| (b - x).abs() < 0.5)
        .collect()
}

/// 4 ε times Σⱼ |Kᵢⱼ| |xⱼ| over the dense matrix, and 4 ε Σ |forces|.
fn rounding<const D: usize>(problem: &Quasistatic<'_, D>, x: &[f64]) -> Vec<f64> {
    let own = problem.gradient_rounding(x).unwrap();
    let pattern = problem.pattern().unwrap();
    let mut matrix = fem_solvers::BlockSymmetric::<D>::zeros(pattern.clone());
    problem.hessian(x, HessianProjection::None, &mut matrix);
    let mut sums = vec![0.0; x.len()];
    for row in 0..pattern.blocks() {
        for (k, &column) in (pattern.row_start()[row]..).zip(pattern.row(row)) {
            for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                let (r, c) = (D * row + i, D * column as usize + j);
                let entry = matrix.values()[k][i][j].abs();
                sums[r] += entry * x[c].abs();
                if row != column as usize {
                    sums[c] += entry * x[r].abs();
                }
            }
        }
    }
    let floor = |(own, sum): (&f64, f64)| own.max(4.0 * f64::EPSILON * sum);
    own.iter().zip(sums).map(floor).collect()
}
