//! a4: from random, flattened and mirrored starts back to the rest state.

use super::assembled::tight;
use super::compare::{Record, apart};
use super::input::{Mesh, NamedMaterial, SceneError};
use super::muscle::Extent;
use crate::promise::Newton;
use crate::report::Report;
use crate::shared::read_json;
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

#[derive(Deserialize)]
struct A4 {
    #[serde(flatten)]
    mesh: Mesh,
    #[serde(rename = "clamped")]
    prescribed: Vec<usize>,
    starts: BTreeMap<String, Vec<[f64; 3]>>,
    cases: Vec<A4Case>,
}

#[derive(Deserialize)]
struct A4Case {
    #[serde(flatten)]
    material: NamedMaterial,
    start: String,
}

/// a4: |x − X| < 1e-6 from every start but one, where the fibers have no direction: there a clear
/// error or any finite state will do.
///
/// # Errors
/// If the file can't be used.
pub fn a4(folder: &Path, extent: Extent, report: &mut Report) -> Result<(), SceneError> {
    let scene: A4 = read_json(&folder.join("a4_recovery.json"))?;
    let mesh = scene.mesh.build()?;
    for (index, case) in scene.cases.iter().enumerate() {
        if !extent.takes(index) {
            continue;
        }
        let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &scene.prescribed)?;
        let builder = AssemblyBuilder::new(&mesh, dofs)?;
        let assembly = case
            .material
            .add_to(builder, mesh.num_elements())?
            .build()?;
        let problem = Quasistatic::new(&assembly, scene.starts[&case.start].clone(), vec![])?;
        let mut x = problem.unknowns();
        let solved = Newton::new(&problem).solve(&problem, &mut x, &tight());
        let fibers = case.material.parameters.get("kx").is_some_and(|&k| k > 0.0);
        let suffix = if fibers { " with fibers" } else { "" };
        let mut record = Record {
            report,
            scene: "scene a4",
            category: format!("{}{suffix}", case.material.material),
            id: case.start.clone(),
        };
        if fibers && case.start == "plane_x" {
            // |F e1| = 0 in every element: the fiber term has no gradient.
            let finite = x.iter().all(|x| x.is_finite());
            record.error("no NaN", if finite { 0.0 } else { f64::NAN }, 0.0);
            continue;
        }
        let distance = match solved {
            Ok(_) => apart(&problem.positions(&x)?, mesh.nodes()),
            Err(_) => f64::INFINITY,
        };
        record.error("|x - X|", distance, 1e-6);
    }
    Ok(())
}
