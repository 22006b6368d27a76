//! b3: paths of full Gauss-Newton steps.

use super::compare::{PATH, Record, apart, largest_difference};
use super::input::{FiberStretch, SceneError};
use super::rig::{B0, parameters};
use crate::numbers::norm;
use crate::promise::Rig;
use crate::report::Report;
use crate::shared::read_json;
use face_rig::rig::{Direction, Equilibrium, Parameters};
use fem_solvers::{Damping, GaussNewtonParams, LeastSquares, StepMethod, gauss_newton};
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct B3 {
    #[serde(rename = "deviatoric")]
    stretch: FiberStretch,
    runs: Vec<Run>,
}

#[derive(Deserialize)]
struct Run {
    name: String,
    nodes: Vec<usize>,
    target: Vec<[f64; 3]>,
    w_orthogonality: f64,
    w_activation: f64,
    theta_start: Vec<f64>,
    path: Vec<Step>,
}

impl Run {
    /// |x* − x| over the nodes seen.
    fn distance(&self, rig: &Rig) -> f64 {
        let x = rig.equilibrium().positions();
        let pairs = self.nodes.iter().zip(&self.target);
        let differences =
            pairs.flat_map(|(&node, target)| (0..3).map(move |i| (node, i, target[i])));
        norm(
            &differences
                .map(|(node, i, t)| x[node][i] - t)
                .collect::<Vec<f64>>(),
        )
    }
}

#[derive(Deserialize)]
struct Step {
    theta: Vec<f64>,
    data_residual_norm: f64,
}

/// ½ Σ |x* − x|² + w/2 (|M_cᵀM_c − I|² + |M_jᵀM_j − I|²) + w_a/2 |α|² as stacked residuals.
struct Fit<'a> {
    rig: &'a mut Rig,
    run: &'a Run,
    solved_at: Vec<f64>,
}

impl Fit<'_> {
    fn solve(&mut self, theta: &[f64]) -> Result<(), SceneError> {
        if self.solved_at != theta {
            let muscles = self.rig.muscles();
            let pose = Parameters::from_slice(theta).unwrap_or_else(|| Parameters::rest(muscles));
            self.rig.solve(&pose)?;
            self.solved_at = theta.to_vec();
        }
        Ok(())
    }

    /// Where M_c and M_j begin in θ.
    fn matrices(&self) -> [usize; 2] {
        let muscles = self.rig.muscles();
        [muscles, muscles + 12]
    }
}

impl LeastSquares for Fit<'_> {
    type Error = SceneError;
    fn residuals(&self) -> usize {
        3 * self.run.nodes.len() + 18 + self.rig.muscles()
    }
    fn parameters(&self) -> usize {
        self.rig.muscles() + 24
    }
    fn residual(&mut self, theta: &[f64], r: &mut [f64]) -> Result<(), SceneError> {
        self.solve(theta)?;
        let x = self.rig.equilibrium().positions();
        let (data, priors) = r.split_at_mut(3 * self.run.nodes.len());
        for (k, &node) in self.run.nodes.iter().enumerate() {
            for i in 0..3 {
                data[3 * k + i] = x[node][i] - self.run.target[k][i];
            }
        }
        let weight = self.run.w_orthogonality.sqrt();
        for (which, first) in self.matrices().into_iter().enumerate() {
            let M = &theta[first..first + 9];
            for i in 0..3 {
                for j in 0..3 {
                    let product: f64 = (0..3).map(|k| M[3 * k + i] * M[3 * k + j]).sum();
                    let unit = if i == j { 1.0 } else { 0.0 };
                    priors[9 * which + 3 * i + j] = weight * (product - unit);
                }
            }
        }
        for (prior, alpha) in priors[18..].iter_mut().zip(theta) {
            *prior = self.run.w_activation.sqrt() * alpha;
        }
        Ok(())
    }
    fn jacobian(&mut self, theta: &[f64], j: &mut [f64]) -> Result<(), SceneError> {
        self.solve(theta)?;
        let (rows, data) = (self.residuals(), 3 * self.run.nodes.len());
        let directions = Direction::all(self.rig.muscles());
        let columns = self.rig.sensitivity()?.columns(&directions)?;
        j.fill(0.0);
        for (k, column) in columns.iter().enumerate() {
            for (n, &node) in self.run.nodes.iter().enumerate() {
                j[k * rows + 3 * n..][..3].copy_from_slice(&column[node]);
            }
        }
        let weight = self.run.w_orthogonality.sqrt();
        for (which, first) in self.matrices().into_iter().enumerate() {
            for (a, b) in (0..9).map(|n| (n / 3, n % 3)) {
                let at = (first + 3 * a + b) * rows + data + 9 * which;
                // ∂(MᵀM)ᵢⱼ/∂M_ab = δ_ib M_aj + δ_jb M_ai
                for k in 0..3 {
                    j[at + 3 * b + k] += weight * theta[first + 3 * a + k];
                    j[at + 3 * k + b] += weight * theta[first + 3 * a + k];
                }
            }
        }
        for k in 0..self.rig.muscles() {
            j[k * rows + data + 18 + k] = self.run.w_activation.sqrt();
        }
        Ok(())
    }
}

/// b3: θ and the residual norm along every path.
///
/// # Errors
/// If a file can't be used or a pose has no equilibrium.
pub fn b3(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    let face: B0 = read_json(&folder.join("b0_rig_mesh.json"))?;
    let scene: B3 = read_json(&folder.join("b3_gauss_newton.json"))?;
    let mut rig = face.mini_rig(scene.stretch)?;
    let rest = rig.equilibrium().clone();
    let mut left_out = 0;
    for run in &scene.runs {
        rig.start_from(rest.clone())?;
        left_out += compare_path(run, &mut rig, &rest, report)?;
    }
    limit(left_out, report);
    Ok(())
}

/// Poses of the nine paths that are known to have several equilibria.
const SEVERAL_EQUILIBRIA: usize = 3;

/// More poses left out than are known to have several equilibria break the comparison.
fn limit(left_out: usize, report: &mut Report) {
    if left_out > SEVERAL_EQUILIBRIA {
        report.broken(format!(
            "scene b3: {left_out} poses were left out for several equilibria; {SEVERAL_EQUILIBRIA} \
             are known to have them"
        ));
    }
}

/// Step by step along one path. A pose that is shown to have several equilibria cannot be compared,
/// nor the step from it: the path is then taken up again at the reference's next pose. Returns how
/// many there were.
fn compare_path(
    run: &Run,
    rig: &mut Rig,
    rest: &Equilibrium,
    report: &mut Report,
) -> Result<usize, SceneError> {
    let mut left_out = 0;
    let mut record = Record {
        report,
        scene: "scene b3",
        category: run.name.clone(),
        id: String::new(),
    };
    let mut theta = run.theta_start.clone();
    for (k, step) in run.path.iter().enumerate() {
        record.id = format!("step {k}");
        record.error("θ", largest_difference(&theta, &step.theta), PATH);
        let pose = parameters(&theta)?;
        rig.solve(&pose)?;
        let error = (run.distance(rig) - step.data_residual_norm).abs();
        let next = run.path.get(k + 1);
        if !(error <= PATH)
            && let Some(apart) = another_equilibrium(rig, rest, &pose)?
        {
            record.report.note(format!(
                "scene b3, {}, step {k}: not comparable, the pose has several equilibria, two of \
                 them {apart:.2} m apart",
                run.name
            ));
            left_out += 1;
            if let Some(next) = next {
                theta.clone_from(&next.theta);
            }
            continue;
        }
        record.error("residual", error, PATH);
        if next.is_some() {
            take_one_step(run, rig, &mut theta);
        }
    }
    Ok(left_out)
}

/// A full Gauss-Newton step.
fn take_one_step(run: &Run, rig: &mut Rig, theta: &mut [f64]) {
    let params = GaussNewtonParams {
        method: StepMethod::Qr,
        damping: Damping::None,
        max_iterations: 1,
        step_tolerance: 0.0,
        cost_tolerance: 0.0,
        ..GaussNewtonParams::default()
    };
    let mut fit = Fit {
        solved_at: theta.to_vec(),
        rig,
        run,
    };
    // One step is not to converge; a step that could not be taken leaves θ, which is compared.
    let _ = gauss_newton(&mut fit, theta, &params);
}

/// How far another equilibrium of the rig's pose is from the one it holds, meters, if a few other
/// starts lead to one. The rig keeps its own.
fn another_equilibrium(
    rig: &mut Rig,
    rest: &Equilibrium,
    pose: &Parameters,
) -> Result<Option<f64>, SceneError> {
    let own = rig.equilibrium().clone();
    let mut found = None;
    for share in [0.0, 0.5, 1.0] {
        // The rest shape, carried along with the jaw by some share.
        let carried = rest.in_cranium_frame.iter().map(|&x| {
            let moved = pose.jaw.apply(x);
            std::array::from_fn(|i| x[i] + share * (moved[i] - x[i]))
        });
        rig.start_from(Equilibrium {
            parameters: pose.clone(),
            in_cranium_frame: carried.collect(),
        })?;
        if rig.solve(pose).is_ok() {
            let apart = apart(&rig.equilibrium().in_cranium_frame, &own.in_cranium_frame);
            if apart > 1e-3 {
                found = Some(apart);
                break;
            }
        }
    }
    rig.start_from(own)?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fourth_pose_left_out_breaks_the_comparison() {
        let mut report = Report::default();
        limit(3, &mut report);
        assert!(report.passed());
        limit(4, &mut report);
        assert!(!report.passed());
    }
}
