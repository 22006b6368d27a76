//! a0: energy, forces and K dx of a given state. a1: the patch test. a2: the twisted bar.

use super::compare::{ENERGY, FORCE, POSITION, Record};
use super::input::{Mesh, NamedMaterial, SceneError};
use crate::promise::Newton;
use crate::report::Report;
use crate::shared::read_json;
use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use fem_solvers::{NewtonInfo, NewtonParams};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Newton down to rounding: the scenes are compared to 1e-9 and better.
pub fn tight() -> NewtonParams {
    NewtonParams {
        relative_gradient_tolerance: 1e-12,
        max_iterations: 400,
        ..NewtonParams::default()
    }
}

/// Solves and returns all positions.
pub(super) fn equilibrium(
    problem: &Quasistatic<'_, 3>,
) -> Result<(Vec<[f64; 3]>, NewtonInfo), SceneError> {
    let mut x = problem.unknowns();
    let info = Newton::new(problem).solve(problem, &mut x, &tight())?;
    Ok((problem.positions(&x)?, info))
}

#[derive(Deserialize)]
struct A0 {
    #[serde(flatten)]
    mesh: Mesh,
    dx: Vec<[f64; 3]>,
    states: BTreeMap<String, Vec<[f64; 3]>>,
    cases: Vec<A0Case>,
}

#[derive(Deserialize)]
struct A0Case {
    #[serde(flatten)]
    material: NamedMaterial,
    state: String,
    energy: f64,
    forces: Vec<[f64; 3]>,
    K_times_dx: Vec<[f64; 3]>,
}

/// a0: no equilibrium.
///
/// # Errors
/// If the file can't be used.
pub fn a0(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    let scene: A0 = read_json(&folder.join("a0_assembly.json"))?;
    let mesh = scene.mesh.build()?;
    for case in &scene.cases {
        let builder = AssemblyBuilder::new(&mesh, Dofs::all_free(mesh.nodes())?)?;
        let assembly = case
            .material
            .add_to(builder, mesh.num_elements())?
            .build()?;
        let x = &scene.states[&case.state];
        let mut record = Record {
            report,
            scene: "scene a0",
            category: format!("{} {}", case.material.material, case.state),
            id: case.state.clone(),
        };
        record.relative(
            "energy",
            assembly.energy(assembly.configuration(x, &[])?),
            case.energy,
            ENERGY,
        );
        let forces = assembly.forces_everywhere(assembly.configuration(x, &[])?);
        record.of_largest("forces", &forces, &case.forces, FORCE);
        let product =
            assembly.hessian_vector_everywhere(assembly.configuration(x, &[])?, &scene.dx)?;
        record.of_largest("K dx", &product, &case.K_times_dx, FORCE);
    }
    Ok(())
}

#[derive(Deserialize)]
struct A1 {
    #[serde(flatten)]
    mesh: Mesh,
    boundary: Vec<usize>,
    start: Vec<[f64; 3]>,
    x: Vec<[f64; 3]>,
    cases: Vec<A1Case>,
}

#[derive(Deserialize)]
struct A1Case {
    #[serde(flatten)]
    material: NamedMaterial,
    energy: f64,
    reaction_forces: Vec<[f64; 3]>,
}

/// a1: an affine deformation is an equilibrium.
///
/// # Errors
/// If the file can't be used or a solve fails.
pub fn a1(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    let scene: A1 = read_json(&folder.join("a1_patch.json"))?;
    let mesh = scene.mesh.build()?;
    for case in &scene.cases {
        let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &scene.boundary)?;
        let builder = AssemblyBuilder::new(&mesh, dofs)?;
        let assembly = case
            .material
            .add_to(builder, mesh.num_elements())?
            .build()?;
        let problem = Quasistatic::new(&assembly, scene.start.clone(), vec![])?;
        let (x, _) = equilibrium(&problem)?;
        let mut record = Record {
            report,
            scene: "scene a1",
            category: case.material.material.clone(),
            id: case.material.material.clone(),
        };
        record.absolute("positions", &x, &scene.x, POSITION);
        record.relative(
            "energy",
            assembly.energy(assembly.configuration(&x, &[])?),
            case.energy,
            ENERGY,
        );
        let forces = assembly.forces_everywhere(assembly.configuration(&x, &[])?);
        let reaction = |&n: &usize| forces[n].map(|f| -f);
        let reactions: Vec<[f64; 3]> = scene.boundary.iter().map(reaction).collect();
        record.of_largest("reactions", &reactions, &case.reaction_forces, FORCE);
    }
    Ok(())
}

#[derive(Deserialize)]
struct A2 {
    parameters: BTreeMap<String, f64>,
    degrees: f64,
    top_z: f64,
    length: usize,
    cases: Vec<A2Case>,
}

#[derive(Deserialize)]
struct A2Case {
    n: usize,
    fixed_top: Vec<usize>,
    top_positions: Vec<[f64; 3]>,
    energy: f64,
    x: Vec<[f64; 3]>,
    top_force_on_body: [f64; 3],
    top_torque_on_body: [f64; 3],
}

/// The bar of n×n×4n cubes, its ends' nodes, and a start that twists and stretches linearly in z.
pub struct TwistBar {
    /// The mesh.
    pub mesh: SimplexMesh<3>,
    /// Nodes at z = 0 and at the top.
    pub prescribed: Vec<usize>,
    /// The start; prescribed nodes are where they shall be.
    pub start: Vec<[f64; 3]>,
}

/// Builds the bar of the benchmark: 1 × 1 × `length`, turned by `degrees`, stretched to `top_z`.
///
/// # Errors
/// If `n` is zero.
pub fn twist_bar(
    n: usize,
    length: usize,
    degrees: f64,
    top_z: f64,
) -> Result<TwistBar, SceneError> {
    let tall = length as f64;
    let mesh = fem_assembly::mesh::kuhn_grid(n, n, length * n, [1.0, 1.0, tall])?;
    let nodes = mesh.nodes();
    let prescribed = (0..nodes.len())
        .filter(|&k| nodes[k][2] == 0.0 || nodes[k][2] == tall)
        .collect();
    let start = nodes
        .iter()
        .map(|p| {
            let share = p[2] / tall;
            let (s, c) = (degrees * share).to_radians().sin_cos();
            let (x, y) = (p[0] - 0.5, p[1] - 0.5);
            [0.5 + c * x - s * y, 0.5 + s * x + c * y, share * top_z]
        })
        .collect();
    Ok(TwistBar {
        mesh,
        prescribed,
        start,
    })
}

/// a2: the twisted bar.
///
/// # Errors
/// If the file can't be used or a solve fails.
pub fn a2(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    let scene: A2 = read_json(&folder.join("a2_twist.json"))?;
    let material = NamedMaterial {
        material: "neo_hookean".to_owned(),
        parameters: scene.parameters.clone(),
    };
    for case in &scene.cases {
        let mut bar = twist_bar(case.n, scene.length, scene.degrees, scene.top_z)?;
        for (&node, &place) in case.fixed_top.iter().zip(&case.top_positions) {
            bar.start[node] = place;
        }
        let dofs = Dofs::with_prescribed_nodes(bar.mesh.nodes(), &bar.prescribed)?;
        let builder = AssemblyBuilder::new(&bar.mesh, dofs)?;
        let assembly = material.add_to(builder, bar.mesh.num_elements())?.build()?;
        let problem = Quasistatic::new(&assembly, bar.start, vec![])?;
        let (x, _) = equilibrium(&problem)?;
        let mut record = Record {
            report,
            scene: "scene a2",
            category: format!("n = {}", case.n),
            id: case.n.to_string(),
        };
        record.relative(
            "energy",
            assembly.energy(assembly.configuration(&x, &[])?),
            case.energy,
            ENERGY,
        );
        record.absolute("positions", &x, &case.x, POSITION);
        let forces = assembly.forces_everywhere(assembly.configuration(&x, &[])?);
        let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
        for &node in &case.fixed_top {
            let f = forces[node].map(|f| -f);
            let r = [x[node][0] - 0.5, x[node][1] - 0.5, x[node][2] - scene.top_z];
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                force[k] += f[k];
                torque[k] += r[i] * f[j] - r[j] * f[i];
            }
        }
        record.of_largest("top force", &[force], &[case.top_force_on_body], FORCE);
        record.of_largest("top torque", &[torque], &[case.top_torque_on_body], FORCE);
    }
    Ok(())
}
