//! a3: a block with one muscle. a5: a block pressed by an obstacle.

use super::assembled::equilibrium;
use super::compare::{ENERGY, POSITION, Record};
use super::input::{Curve, FiberStretch, Mesh, NamedMaterial, SceneError};
use crate::report::Report;
use crate::shared::read_json;
use fem_assembly::{AssemblyBuilder, Dofs, Fiber, ImplicitSurface, Penalty, Quasistatic};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

#[derive(Deserialize)]
struct A3 {
    #[serde(flatten)]
    mesh: Mesh,
    muscle_tets: Vec<usize>,
    #[serde(rename = "fibre_direction")]
    fiber_direction: [f64; 3],
    parameters: BTreeMap<String, f64>,
    #[serde(rename = "clamped_left")]
    prescribed_left: Vec<usize>,
    right_face: Vec<usize>,
    pull: f64,
    cases: Vec<A3Case>,
}

#[derive(Deserialize)]
struct A3Case {
    #[serde(rename = "deviatoric")]
    stretch: FiberStretch,
    variant: String,
    curve: Curve,
    #[serde(rename = "sigma_max")]
    max_isometric_stress: f64,
    activation: f64,
    energy: f64,
    x: Vec<[f64; 3]>,
}

/// How many cases of a long scene to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All of them.
    All,
    /// Every third.
    Some,
}

impl Extent {
    pub(super) fn takes(self, index: usize) -> bool {
        self == Self::All || index.is_multiple_of(3)
    }
}

/// a3: both stretches, both curves, free and pulled.
///
/// # Errors
/// If the file can't be used or a solve fails.
pub fn a3(folder: &Path, extent: Extent, report: &mut Report) -> Result<(), SceneError> {
    let scene: A3 = read_json(&folder.join("a3_muscle.json"))?;
    let mesh = scene.mesh.build()?;
    let flesh = NamedMaterial::flesh(&scene.parameters);
    for (index, case) in scene.cases.iter().enumerate() {
        if !extent.takes(index) {
            continue;
        }
        let mut prescribed = scene.prescribed_left.clone();
        let mut start = mesh.nodes().to_vec();
        if case.variant == "pulled" {
            prescribed.extend(&scene.right_face);
            for p in &mut start {
                p[0] *= 1.0 + scene.pull;
            }
        }
        let fiber = |&element: &usize| Fiber {
            element,
            control: 0,
            direction: scene.fiber_direction,
            max_isometric_stress: case.max_isometric_stress,
            optimal_stretch: case.curve.lambda_ofl,
        };
        let fibers: Vec<Fiber> = scene.muscle_tets.iter().map(fiber).collect();
        let builder = AssemblyBuilder::new(
            &mesh,
            Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed)?,
        )?;
        let law = case.curve.law(case.stretch.0)?;
        let assembly = flesh
            .add_to(builder, mesh.num_elements())?
            .fibers(law, 1, &fibers)?
            .build()?;
        let problem = Quasistatic::new(&assembly, start, vec![case.activation])?;
        let (x, _) = equilibrium(&problem)?;
        let mut record = Record {
            report,
            scene: "scene a3",
            category: format!("{} {:?}", case.variant, case.stretch.0),
            id: index.to_string(),
        };
        let energy = assembly.energy(assembly.configuration(&x, &[case.activation])?);
        record.relative("energy", energy, case.energy, ENERGY);
        record.absolute("positions", &x, &case.x, POSITION);
    }
    Ok(())
}

#[derive(Deserialize)]
struct A5 {
    #[serde(flatten)]
    mesh: Mesh,
    #[serde(rename = "clamped")]
    prescribed: Vec<usize>,
    penalty_nodes: Vec<usize>,
    parameters: BTreeMap<String, f64>,
    cases: Vec<A5Case>,
}

#[derive(Deserialize)]
struct A5Case {
    #[serde(flatten)]
    shape: Shape,
    epsilon: f64,
    energy: f64,
    x: Vec<[f64; 3]>,
    contact_nodes: Vec<usize>,
    depth: Vec<f64>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(tag = "obstacle", rename_all = "snake_case")]
enum Shape {
    Sphere { center: [f64; 3], radius: f64 },
    HalfSpace { point: [f64; 3], normal: [f64; 3] },
}

impl Shape {
    fn depth(&self, x: [f64; 3]) -> f64 {
        let from = |c: [f64; 3]| [x[0] - c[0], x[1] - c[1], x[2] - c[2]];
        match *self {
            Self::Sphere { center, radius } => {
                radius - from(center).iter().map(|d| d * d).sum::<f64>().sqrt()
            }
            Self::HalfSpace { point, normal } => {
                let d = from(point);
                -(normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2])
            }
        }
    }

    fn obstacle(self) -> (&'static str, ImplicitSurface<3>) {
        match self {
            Self::Sphere { center, radius } => {
                ("sphere", ImplicitSurface::Sphere { center, radius })
            }
            Self::HalfSpace { point, normal } => {
                ("half-space", ImplicitSurface::HalfSpace { point, normal })
            }
        }
    }
}

/// a5: penalty collisions with a sphere and a half-space.
///
/// # Errors
/// If the file can't be used or a solve fails.
pub fn a5(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    let scene: A5 = read_json(&folder.join("a5_penalty.json"))?;
    let mesh = scene.mesh.build()?;
    let flesh = NamedMaterial::flesh(&scene.parameters);
    for case in &scene.cases {
        let (name, obstacle) = case.shape.obstacle();
        let penalty = Penalty {
            nodes: scene.penalty_nodes.clone(),
            stiffness: case.epsilon,
            obstacle,
        };
        let dofs = Dofs::with_prescribed_nodes(mesh.nodes(), &scene.prescribed)?;
        let builder = AssemblyBuilder::new(&mesh, dofs)?;
        let assembly = flesh
            .add_to(builder, mesh.num_elements())?
            .penalty(penalty)?
            .build()?;
        let problem = Quasistatic::new(&assembly, mesh.nodes().to_vec(), vec![])?;
        let (x, _) = equilibrium(&problem)?;
        let mut record = Record {
            report,
            scene: "scene a5",
            category: name.to_owned(),
            id: format!("ε = {}", case.epsilon),
        };
        record.relative(
            "energy",
            assembly.energy(assembly.configuration(&x, &[])?),
            case.energy,
            ENERGY,
        );
        record.absolute("positions", &x, &case.x, POSITION);
        let mut inside = scene.penalty_nodes.clone();
        inside.retain(|&n| case.shape.depth(x[n]) > 0.0);
        let same = inside == case.contact_nodes;
        record.error("contacts", if same { 0.0 } else { f64::INFINITY }, 0.0);
        for (&node, &depth) in case.contact_nodes.iter().zip(&case.depth) {
            let error = (case.shape.depth(x[node]) - depth).abs();
            record.error("depth", error, POSITION);
        }
    }
    Ok(())
}
