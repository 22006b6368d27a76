//! `face-rig jacobian`.

use super::args::{JacobianArgs, Multigrid, OutputArgs};
use super::clock::Clock;
use super::error::Failure;
use super::output::{Output, say};
use super::progress::spinner;
use super::source::{open, pose};
use face_pictures::export::write_atomically;
use face_rig::rig::{Direction, JacobianRoute, Observation, RigParams};
use face_scenes::Scene;
use serde_json::json;
use std::fmt::Write;

pub fn run(args: &JacobianArgs, output: &OutputArgs, mut clock: Clock) -> Result<(), Failure> {
    clock.enter("scene");
    let source = open(&args.scene, false)?;
    let scene = &source.scene;
    let parameters = pose(scene, &args.pose)?;
    if scene.landmarks.is_empty() {
        return Err(Failure::NoLandmarks {
            scene: scene.name.clone(),
        });
    }
    let mut out = Output::prepare(output, clock)?;
    out.enter("assembly");
    let mut rig = scene.rig(RigParams {
        multigrid: args.multigrid.into(),
        ..RigParams::default()
    })?;
    let bar = spinner("equilibrium and derivative");
    out.enter("equilibrium");
    rig.solve(&parameters)?;
    out.enter("jacobian");
    let controls = (0..scene.influences.len()).map(Direction::Control);
    let mut directions = Direction::all(scene.muscles.len());
    directions.extend(controls);
    let points = scene.landmark_points(0..scene.landmarks.len());
    let route = JacobianRoute::cheaper(&points, &directions);
    let solves = route.right_hand_sides(&points, &directions);
    let sensitivity = rig.sensitivity_for(solves)?;
    let columns = sensitivity.jacobian(&points, &directions, route)?;
    bar.finish_and_clear();
    out.enter("files");
    let mut names = names(scene.muscles.iter().map(|m| m.name.as_str()));
    names.extend(scene.influences.iter().map(|i| i.name.clone()));
    let path = out.path("jacobian.csv");
    let text = table(scene, &names, &columns);
    write_atomically(&path, text.as_bytes())?;
    out.enter("report");
    let route = match route {
        JacobianRoute::Columns => "columns",
        JacobianRoute::Adjoint => "adjoint",
    };
    let settings = json!({ "scene": args.scene, "set": args.pose.set, "jaw": args.pose.jaw,
        "jaw_shift_mm": args.pose.jaw_shift, "control": args.pose.control,
        "multigrid": Multigrid::told(rig.params().multigrid) });
    let results =
        json!({ "rows": points.dim(), "columns": names, "route": route, "work": rig.work() });
    let report = out.report("jacobian", settings, results)?;
    if output.json {
        say(serde_json::to_string_pretty(&report)?)?;
    } else {
        say(format!(
            "{} rows (landmarks x 3, meters) by {} columns (by {route}) in {}",
            points.dim(),
            names.len(),
            path.display()
        ))?;
    }
    Ok(())
}

/// A line for each axis of each landmark, a column for each entry of θ.
fn table(scene: &Scene, names: &[String], columns: &[f64]) -> String {
    let rows = 3 * scene.landmarks.len();
    let mut text = format!("landmark,axis,{}\n", names.join(","));
    for row in 0..rows {
        let (index, axis) = (scene.landmarks[row / 3].index, ["x", "y", "z"][row % 3]);
        let _ = write!(text, "{index},{axis}");
        for column in 0..names.len() {
            let _ = write!(text, ",{:e}", columns[column * rows + row]);
        }
        text.push('\n');
    }
    text
}

/// Names of all entries of θ.
fn names<'a>(muscles: impl Iterator<Item = &'a str>) -> Vec<String> {
    let frame = |bone: &'static str| {
        let matrix = (0..9).map(move |k| format!("{bone}_m{}{}", k / 3 + 1, k % 3 + 1));
        matrix.chain((0..3).map(move |k| format!("{bone}_t{}", ["x", "y", "z"][k])))
    };
    muscles
        .map(str::to_owned)
        .chain(frame("cranium"))
        .chain(frame("jaw"))
        .collect()
}
