//! Faces that smile with the jaw open.

use super::Scene;
use super::bars::PROJECTIONS;
use crate::body::{apart, kept};
use crate::curve::{Axis, Claim, Curve, Point};
use crate::failure::Failure;
use crate::settings::Settings;
use crate::timing::fastest_with;
use face_rig::rig::{MultigridUse, Parameters, RigParams};
use face_scenes::Scene as Face;
use fem_solvers::{LinearSolver, NewtonParams, StopReason};
use std::path::Path;

const TRUTH: &str = "the same face to 1e-12; mesh curve: landmarks of the finest face of the run";

/// The built-in face and the two heads beside the repository.
pub const SCENES: [Scene; 3] = [
    Scene {
        name: "face",
        about: "the built-in face, zygomatic muscles at 0.6, the jaw opened by 8 degrees",
        measure: "apart, mm",
        truth: TRUTH,
        run: builtin,
        counted: Some(|| counted(&Face::builtin(4_000)?)),
    },
    Scene {
        name: "head-coarse",
        about: "the coarse reference head in the same pose",
        measure: "apart, mm",
        truth: TRUTH,
        run: |settings| head("coarse", settings),
        counted: Some(|| counted(&loaded("coarse")?)),
    },
    Scene {
        name: "head-medium",
        about: "the medium reference head in the same pose",
        measure: "apart, mm",
        truth: TRUTH,
        run: |settings| match settings.quick {
            true => Err(Failure::Skipped(
                "takes a minute: not in a quick run".to_owned(),
            )),
            false => head("medium", settings),
        },
        counted: None,
    },
];

/// Settings of a rig that is solved to this share of the forces.
pub fn rig_to(tolerance: f64) -> RigParams {
    let own = RigParams::default();
    RigParams {
        newton: NewtonParams {
            relative_gradient_tolerance: tolerance,
            ..own.newton
        },
        ..own
    }
}

/// Zygomatic muscles at 0.6, the jaw at 8°.
pub fn posed(face: &Face) -> Result<Parameters, Failure> {
    let mut pose = face.rest_pose();
    let mut found = 0;
    for (muscle, activation) in face.muscles.iter().zip(&mut pose.activations) {
        if muscle.name.contains("zygomaticus") {
            *activation = 0.6;
            found += 1;
        }
    }
    if found == 0 {
        return Err(Failure::Failed(
            format!("{} has no zygomatic muscle", face.name).into(),
        ));
    }
    pose.jaw = face.joint.motion([8.0_f64.to_radians(), 0.0, 0.0, 0.0]).0;
    Ok(pose)
}

/// One way to solve it, from rest; the rig's own setup is not counted.
fn solved(
    face: &Face,
    pose: &Parameters,
    params: RigParams,
    repetitions: usize,
) -> Result<(Vec<[f64; 3]>, Point), Failure> {
    let timed = fastest_with(
        repetitions,
        || Ok(face.rig(params)?),
        |rig| {
            let shape = rig.solve(pose)?.positions();
            let unknowns = rig.assembly().dofs().unknowns();
            let z = rig.equilibrium().in_cranium_frame.clone();
            Ok((shape, z, rig.work(), unknowns))
        },
    )?;
    let (shape, z, work, unknowns) = timed.value;
    came_to_rest(face, pose, z, &params)?;
    let point = Point {
        seconds: timed.seconds,
        unknowns,
        steps: work.newton_steps,
        factorizations: work.factorizations,
        iterations: work.linear_iterations,
        memory: timed.memory,
        ..Point::default()
    };
    Ok((shape, point))
}

/// Sums the forces of a pose again, contacts those of a fresh look.
///
/// # Errors
/// Where more is left than such a rig promises.
pub fn came_to_rest(
    face: &Face,
    pose: &Parameters,
    z: Vec<[f64; 3]>,
    params: &RigParams,
) -> Result<(), Failure> {
    let rig = face.rig(*params)?;
    let controls = rig.energy_controls(pose);
    let mut assembly = face.assembly()?;
    assembly.renew(assembly.configuration(&z, &controls)?)?;
    // A rig does not say which test its last solve met: the weakest promise.
    kept(&assembly, z, controls, &params.newton, StopReason::Rounding)
}

/// A curve, and the settings of its points.
type Ways = (Curve, Vec<(String, RigParams)>);

fn ways(name: &str) -> Vec<Ways> {
    let named = |what: &str| format!("{name}, {what}");
    let tolerance = |t: f64| (format!("{t:.0e}"), rig_to(t));
    let tolerances = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9].map(tolerance);
    let solver = |(name, linear_solver, multigrid): (&str, LinearSolver, MultigridUse)| {
        let mut params = rig_to(1e-9);
        params.newton.linear_solver = linear_solver;
        params.multigrid = multigrid;
        (name.to_owned(), params)
    };
    let (never, always) = (MultigridUse::Never, MultigridUse::Always);
    let solvers = [
        ("direct f64", LinearSolver::Direct, never),
        ("direct f32, refined", LinearSolver::DirectSingle, never),
        ("multigrid f32 in f64", LinearSolver::Direct, always),
    ];
    let projection = |(name, projection): (&str, _)| {
        let mut params = rig_to(1e-9);
        params.newton.projection = projection;
        (name.to_owned(), params)
    };
    vec![
        (
            Curve::new(
                named("direct"),
                Axis::Tolerance,
                Claim::PerToleranceUpTo(50.0, 1e-6, 1e-4),
            ),
            tolerances.to_vec(),
        ),
        (
            Curve::new(named("to 1e-9"), Axis::Solver, Claim::AtMost(1e-3)),
            solvers.map(solver).to_vec(),
        ),
        (
            Curve::new(
                named("to 1e-9, direct"),
                Axis::Projection,
                Claim::AtMost(1e-3),
            ),
            PROJECTIONS.map(projection).to_vec(),
        ),
    ]
}

fn curves(face: &Face, name: &str, settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let pose = posed(face)?;
    let (exact, _) = solved(face, &pose, rig_to(1e-12), 1)?;
    let mut curves = Vec::new();
    for (mut curve, ways) in ways(name) {
        for (setting, params) in ways {
            let (shape, point) = solved(face, &pose, params, settings.repetitions)?;
            curve.points.push(Point {
                setting,
                error: 1e3 * apart(&shape, &exact),
                ..point
            });
        }
        curves.push(curve);
    }
    Ok(curves)
}

/// Displacements of the landmarks, m.
fn landmarks(face: &Face, shape: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let moved = face.landmarks.iter().map(|l| {
        let (x, rest) = (l.point.position(shape), l.point.position(face.mesh.nodes()));
        std::array::from_fn(|k| x[k] - rest[k])
    });
    moved.collect()
}

fn builtin(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let sizes: &[usize] = match (settings.quick, settings.large) {
        (true, _) => &[4_000, 20_000],
        (false, false) => &[4_000, 20_000, 50_000, 100_000],
        (false, true) => &[4_000, 20_000, 100_000, 300_000, 1_000_000],
    };
    let mut shown = Vec::new();
    for &tets in sizes {
        let face = Face::builtin(tets)?;
        let params = RigParams {
            multigrid: MultigridUse::WhereCheaper,
            ..rig_to(1e-8)
        };
        let (shape, point) = solved(&face, &posed(&face)?, params, settings.repetitions)?;
        shown.push((landmarks(&face, &shape), tets, point));
    }
    let mut meshes = Curve::new("against the finest", Axis::Mesh, Claim::Nothing);
    if let Some((finest, ..)) = shown.last().cloned() {
        for (landmarks, tets, point) in shown {
            meshes.points.push(Point {
                setting: format!("{tets} tets"),
                error: 1e3 * apart(&landmarks, &finest),
                ..point
            });
        }
    }
    let mut all = vec![meshes];
    for &tets in settings.pick(&[4_000][..], &[20_000, 50_000][..]) {
        let face = Face::builtin(tets)?;
        all.extend(curves(&face, &format!("{tets} tets"), settings)?);
    }
    Ok(all)
}

fn counted(face: &Face) -> Result<(), Failure> {
    solved(face, &posed(face)?, rig_to(1e-9), 1).map(|_| ())
}

fn loaded(size: &str) -> Result<Face, Failure> {
    if workbench::shared::folder().is_none() {
        return Err(Failure::Skipped(
            "no folder with the reference heads beside the repository".to_owned(),
        ));
    }
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/face-scenes/scenes");
    Ok(Face::load(scenes.join(format!("head_{size}.json")))?)
}

fn head(size: &str, settings: &Settings) -> Result<Vec<Curve>, Failure> {
    curves(&loaded(size)?, size, settings)
}
