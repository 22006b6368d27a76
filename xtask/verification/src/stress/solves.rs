//! Whole solves at the edge.

use super::{Outcome, Row};
use crate::numbers::worse;
use crate::scenes::{SceneError, apart, twist_bar};
use fem_assembly::mesh::{SimplexMesh, kuhn_grid};
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use fem_materials::{Material, NeoHookean, StableNeoHookean};
use fem_solvers::{Newton, NewtonParams};

/// Every trial.
pub(super) fn rows() -> Vec<Row> {
    let soft = NeoHookean {
        mu: 3.4e4,
        lambda: 3.1e5,
    };
    let robust = StableNeoHookean {
        mu: 3.6e3,
        lambda: 1.4e4,
    };
    let nearly_incompressible = NeoHookean {
        mu: 1e4,
        lambda: 1e4 * 2.0 * 0.4999 / (1.0 - 2.0 * 0.4999),
    };
    let mut rows = Vec::new();
    let mut add = |trial, result: Result<Outcome, SceneError>| {
        let outcome = result.unwrap_or_else(|error| Outcome::ClearError(error.to_string()));
        rows.push(Row {
            subject: "solves".to_owned(),
            trial,
            outcome,
        });
    };
    add(
        "nearly incompressible bar",
        twist(nearly_incompressible, 20.0, 4.1),
    );
    add("huge step: two full turns", twist(soft, 720.0, 4.4));
    add("huge step: six times longer", twist(soft, 0.0, 24.0));
    add("top pushed below the bottom", twist(soft, 0.0, -1.0));
    let mirror: fn([f64; 3]) -> [f64; 3] = |p| [-p[0], p[1], p[2]];
    let point: fn([f64; 3]) -> [f64; 3] = |_| [0.0; 3];
    let far: fn([f64; 3]) -> [f64; 3] = |p| [1e6 * p[1], -1e6 * p[0], 1e6 * p[2]];
    add("mirrored start, any F", recover(robust, mirror));
    add("start in one point, any F", recover(robust, point));
    add("start 1000 km away, any F", recover(robust, far));
    add("mirrored start, log J", recover(soft, mirror));
    add("slivers in the mesh", slivers(soft));
    add("NaN among the positions", nan_start(soft));
    rows
}

fn twist<M: Material<3> + 'static>(
    material: M,
    degrees: f64,
    top: f64,
) -> Result<Outcome, SceneError> {
    let bar = twist_bar(2, 4, degrees, top)?;
    let dofs = Dofs::with_prescribed_nodes(bar.mesh.nodes(), &bar.prescribed)?;
    solve(&bar.mesh, dofs, material, bar.start)
}

/// Solves, and trusts nothing: the result must be finite, in the domain and in balance.
fn solve<M: Material<3> + 'static>(
    mesh: &SimplexMesh<3>,
    dofs: Dofs<3>,
    material: M,
    start: Vec<[f64; 3]>,
) -> Result<Outcome, SceneError> {
    let assembly = AssemblyBuilder::new(mesh, dofs)?
        .material(material)?
        .build()?;
    let problem = Quasistatic::new(&assembly, start, vec![])?;
    let mut x = problem.unknowns();
    let solved = Newton::new(&problem).solve(&problem, &mut x, &NewtonParams::default());
    let positions = problem.positions(&x);
    let finite = positions.as_flattened().iter().all(|c| c.is_finite());
    if !finite {
        return Ok(Outcome::Fail(
            "the state left behind is not finite".to_owned(),
        ));
    }
    let info = match solved {
        Ok(info) => info,
        Err(error) => return Ok(Outcome::ClearError(error.to_string())),
    };
    let forces = assembly.forces_everywhere(assembly.configuration(&positions, &[])?);
    let size = forces
        .as_flattened()
        .iter()
        .fold(0.0, |m, f| worse(m, f.abs()));
    let free = (0..forces.len()).filter(|&n| assembly.dofs().row(n).is_some());
    let unbalanced = free
        .flat_map(|n| forces[n])
        .fold(0.0, |m, f| worse(m, f.abs()));
    let balanced = unbalanced <= 1e-6 * size.max(info.energy.abs());
    let in_domain = assembly
        .energy(assembly.configuration(&positions, &[])?)
        .is_finite();
    Ok(if balanced && in_domain {
        let steps = info.iterations;
        Outcome::Right(format!("{steps} steps, unbalanced force {unbalanced:.1e}"))
    } else {
        Outcome::Fail(format!("called converged with a force of {unbalanced:e}"))
    })
}

/// A cube clamped on one face, started elsewhere, must come back to rest.
fn recover<M: Material<3> + 'static>(
    material: M,
    start: fn([f64; 3]) -> [f64; 3],
) -> Result<Outcome, SceneError> {
    let mesh = kuhn_grid(3, 3, 3, [1.0; 3])?;
    let rest = mesh.nodes();
    let clamped: Vec<usize> = (0..rest.len()).filter(|&n| rest[n][0] == 0.0).collect();
    let mut from: Vec<[f64; 3]> = rest.iter().map(|&p| start(p)).collect();
    for &node in &clamped {
        from[node] = rest[node];
    }
    let dofs = Dofs::with_prescribed_nodes(rest, &clamped)?;
    let assembly = AssemblyBuilder::new(&mesh, dofs)?
        .material(material)?
        .build()?;
    let problem = Quasistatic::new(&assembly, from, vec![])?;
    let mut x = problem.unknowns();
    let params = NewtonParams {
        max_iterations: 400,
        ..NewtonParams::default()
    };
    Ok(
        match Newton::new(&problem).solve(&problem, &mut x, &params) {
            Err(error) => Outcome::ClearError(error.to_string()),
            Ok(info) => {
                let distance = apart(&problem.positions(&x), rest);
                if distance < 1e-4 {
                    Outcome::Right(format!("at rest after {} steps", info.iterations))
                } else {
                    Outcome::Fail(format!("called converged {distance:e} m from rest"))
                }
            }
        },
    )
}

/// A bar whose middle layers are squeezed to a ten-thousandth of their height.
fn slivers<M: Material<3> + 'static>(material: M) -> Result<Outcome, SceneError> {
    let grid = kuhn_grid(2, 2, 8, [1.0, 1.0, 4.0])?;
    let squeeze = |z: f64| {
        if z > 2.0 {
            2.0 + 1e-4 * (z - 2.0).min(0.5) + (z - 2.5).max(0.0)
        } else {
            z
        }
    };
    let nodes: Vec<[f64; 3]> = grid
        .nodes()
        .iter()
        .map(|p| [p[0], p[1], squeeze(p[2])])
        .collect();
    let mesh = SimplexMesh::new(nodes, grid.connectivity().to_vec())?;
    let rest = mesh.nodes();
    let top = rest.iter().fold(0.0, |m, p| f64::max(m, p[2]));
    let held: Vec<usize> = (0..rest.len())
        .filter(|&n| rest[n][2] == 0.0 || rest[n][2] == top)
        .collect();
    let start = rest.iter().map(|p| [p[0], p[1], 1.1 * p[2]]).collect();
    solve(
        &mesh,
        Dofs::with_prescribed_nodes(rest, &held)?,
        material,
        start,
    )
}

fn nan_start<M: Material<3> + 'static>(material: M) -> Result<Outcome, SceneError> {
    let bar = twist_bar(2, 4, 0.0, 4.4)?;
    let dofs = Dofs::with_prescribed_nodes(bar.mesh.nodes(), &bar.prescribed)?;
    let mut start = bar.start;
    start[40][1] = f64::NAN;
    solve(&bar.mesh, dofs, material, start)
}
