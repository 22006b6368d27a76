//! b1, b2: poses of the mini face and their exact derivatives.

use super::assembled::tight;
use super::compare::{COLUMN, ENERGY, POSITION, Record, largest_difference};
use super::input::{Curve, FiberStretch, Mesh, NamedMaterial, SceneError};
use crate::numbers::{norm, worse};
use crate::promise::Rig;
use crate::report::Report;
use crate::shared::read_json;
use face_rig::rig::{Direction, Parameters, RigParams};
use fem_assembly::{AssemblyBuilder, Dofs, Fiber};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The mini face.
#[derive(Deserialize)]
pub(super) struct B0 {
    #[serde(flatten)]
    mesh: Mesh,
    cranium_nodes: Vec<usize>,
    jaw_nodes: Vec<usize>,
    muscles: Vec<Muscle>,
    material: BTreeMap<String, f64>,
    curve: Curve,
}

#[derive(Deserialize)]
struct Muscle {
    #[serde(rename = "sigma_max")]
    max_isometric_stress: f64,
    tets: Vec<usize>,
    #[serde(rename = "fibres")]
    fibers: Vec<[f64; 3]>,
}

impl B0 {
    pub(super) fn mini_rig(&self, stretch: FiberStretch) -> Result<Rig, SceneError> {
        let mesh = self.mesh.build()?;
        let prescribed: Vec<usize> = [&self.cranium_nodes[..], &self.jaw_nodes[..]].concat();
        let mut fibers = Vec::new();
        for (control, muscle) in self.muscles.iter().enumerate() {
            for (&element, &direction) in muscle.tets.iter().zip(&muscle.fibers) {
                fibers.push(Fiber {
                    element,
                    control,
                    direction,
                    max_isometric_stress: muscle.max_isometric_stress,
                    optimal_stretch: self.curve.lambda_ofl,
                });
            }
        }
        let flesh = NamedMaterial::flesh(&self.material);
        let builder = AssemblyBuilder::new(
            &mesh,
            Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed)?,
        )?;
        let law = self.curve.law(stretch.0)?;
        let assembly = flesh
            .add_to(builder, mesh.num_elements())?
            .fibers(law, self.muscles.len(), &fibers)?
            .build()?;
        // Forces are about 1e5 here; the inner equilibria must be better than the comparison.
        let mut params = RigParams::default();
        params.newton.relative_gradient_tolerance = tight().relative_gradient_tolerance;
        Ok(Rig::new(assembly, &self.jaw_nodes, params)?)
    }
}

#[derive(Deserialize)]
struct Poses {
    #[serde(rename = "deviatoric")]
    stretch: FiberStretch,
    cases: Vec<Pose>,
}

#[derive(Deserialize)]
struct Pose {
    name: String,
    theta: Vec<f64>,
    energy: f64,
    z: Vec<[f64; 3]>,
    x: Vec<[f64; 3]>,
    #[serde(default)]
    jacobian_columns: Vec<Vec<f64>>,
    column_norms: Vec<f64>,
    column_dot_x: Vec<f64>,
}

pub(super) fn parameters(theta: &[f64]) -> Result<Parameters, SceneError> {
    Parameters::from_slice(theta).ok_or_else(|| SceneError::Unknown {
        what: "pose",
        name: format!("{} numbers, fewer than 24", theta.len()),
    })
}

/// b1 and b2: x(θ), z(θ), dx/dθ for every column, and Jᵀ x by the adjoint.
///
/// # Errors
/// If a file can't be used or a pose has no equilibrium.
pub fn b1_b2(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    let face: B0 = read_json(&folder.join("b0_rig_mesh.json"))?;
    for (scene, file) in [
        ("scene b1", "b1_jacobian.json"),
        ("scene b2", "b2_jacobian_deviatoric.json"),
    ] {
        let poses: Poses = read_json(&folder.join(file))?;
        let mut rig = face.mini_rig(poses.stretch)?;
        for pose in &poses.cases {
            check_pose(scene, pose, &mut rig, report)?;
        }
    }
    Ok(())
}

fn check_pose(
    scene: &str,
    pose: &Pose,
    rig: &mut Rig,
    report: &mut Report,
) -> Result<(), SceneError> {
    let theta = parameters(&pose.theta)?;
    rig.solve(&theta)?;
    let z = rig.equilibrium().in_cranium_frame.clone();
    let energy = rig
        .assembly()
        .energy(rig.assembly().configuration(&z, &theta.activations)?);
    let mut record = Record {
        report,
        scene,
        category: pose.name.clone(),
        id: pose.name.clone(),
    };
    record.relative("energy", energy, pose.energy, ENERGY);
    record.absolute("z", &z, &pose.z, POSITION);
    record.absolute("x", &rig.equilibrium().positions(), &pose.x, POSITION);
    let directions = Direction::all(rig.muscles());
    let sensitivity = rig.sensitivity()?;
    let columns = sensitivity.columns(&directions)?;
    let adjoint = sensitivity.gradient(&pose.x, &directions)?;
    let size = norm(pose.x.as_flattened());
    for (k, column) in columns.iter().enumerate() {
        record.id = format!("column {k}");
        let column = column.as_flattened();
        if let Some(exact) = pose.jacobian_columns.get(k) {
            let largest = exact.iter().fold(0.0, |m, x| worse(m, x.abs()));
            let error = largest_difference(column, exact) / largest;
            record.error("columns", error, COLUMN);
        }
        let exact = pose.column_norms[k];
        record.relative("column norms", norm(column), exact, COLUMN);
        let error = (adjoint[k] - pose.column_dot_x[k]).abs() / (size * exact);
        record.error("adjoint", error, COLUMN);
    }
    Ok(())
}
