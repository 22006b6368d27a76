//! What a solve promises, checked by other sums than its own.

use fem_assembly::Quasistatic;
use fem_solvers::{HessianProjection, NewtonInfo, NewtonParams, NonlinearProblem, StopReason};

/// Fails unless every force that is left at `x` is what [`NewtonInfo::stop`] allows: node by node in the
/// order of the terms, without the rows and chunks that the solver summed, and with products instead of
/// a matrix for the rounding.
pub fn kept<const D: usize>(
    problem: &Quasistatic<'_, D>,
    x: &[f64],
    params: &NewtonParams,
    info: &NewtonInfo,
    what: &str,
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
        let allowed = match info.stop {
            StopReason::Gradient => params.gradient_tolerance,
            StopReason::RelativeGradient => params.gradient_tolerance.max(share),
            StopReason::Rounding => params.gradient_tolerance.max(share).max(floor[i]),
            _ => f64::INFINITY,
        };
        assert!(
            force.abs() <= allowed + floor[i],
            "{what}: {force:e} N left of unknown {i}, {allowed:e} N promised, {info:?}"
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
