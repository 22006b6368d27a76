//! Faces: muscles at their limits, a jaw that opens far and shuts, muscles that are twins.

use crate::face::{pose, rig, solve};
use crate::row::{Evidence, Settings};
use crate::{Expected, Failure, Row};
use face_rig::anatomy::{FiberEntry, FiberField, Muscle};
use face_rig::fit::{CraniumModel, FitIteration, FitParams, Goal, Parametrization};
use face_scenes::{Contact, Observed, Outcome, Scene, Target, TargetKind, fit_expression};
use std::path::Path;

const WALK: f64 = 1.0 / 256.0;
const AT_ONCE: f64 = 1.0;

/// The rows.
pub fn rows() -> Vec<Row> {
    let answer = Expected::Answer;
    let mut rows = vec![
        built_in(
            "muscles-all-1-at-once",
            "all muscles at 1 from rest, one solve",
            answer,
            1.0,
            0.0,
            AT_ONCE,
        ),
        built_in(
            "muscles-all-1",
            "all muscles at 1 from rest",
            answer,
            1.0,
            0.0,
            WALK,
        ),
        built_in(
            "muscles-all-minus-1",
            "all activations at −1: muscles that push",
            answer,
            -1.0,
            0.0,
            WALK,
        ),
        built_in(
            "muscles-all-1-jaw-25",
            "all muscles at 1 with the jaw at 25.33°",
            answer,
            1.0,
            25.33,
            WALK,
        ),
        built_in(
            "jaw-minus-10",
            "the jaw shut by 10° more than it can be",
            answer,
            0.0,
            -10.0,
            WALK,
        ),
        built_in("jaw-25", "the jaw at 25.33°", answer, 0.0, 25.33, WALK),
        built_in("jaw-35", "the jaw at 35°", answer, 0.0, 35.0, WALK),
        touching("touching-smile", "zygomatic muscles at 0.6", 0.6, 0.0),
        touching("touching-jaw-25", "the jaw at 25.33°", 0.0, 25.33),
        touching(
            "touching-jaw-minus-3",
            "the jaw shut by 3° more than at rest",
            0.0,
            -3.0,
        ),
        Row::new(
            "faces",
            "muscles-twins",
            "a fit with a muscle that is there twice: both get the same",
            answer,
            twins,
        ),
    ];
    let heads = [
        ("coarse", 0.0, -10.0),
        ("coarse", 0.0, 25.33),
        ("coarse", 0.0, 35.0),
        ("coarse", 1.0, 25.33),
        ("coarse_touching", 0.0, 25.33),
        ("coarse_touching", 0.0, -3.0),
        ("medium", 0.0, 25.33),
    ];
    for (size, activations, degrees) in heads {
        let run = move |settings: &Settings| {
            let file = format!("head_{size}.json");
            head(&file, activations, degrees, settings)
        };
        let muscles = if activations > 0.0 { "all-1-" } else { "" };
        let size = size.replace('_', " and ");
        let name = format!("head-{}-{muscles}jaw-{degrees}", size.replace(" and ", "-"));
        let what = format!("the {size} head, muscles at {activations}, the jaw at {degrees}°");
        rows.push(Row::new("heads", name, what, answer, run).long());
    }
    rows
}

/// The built-in face, touching nothing.
fn face(settings: &Settings) -> Result<Scene, Failure> {
    let mut scene = Scene::builtin(if settings.quick { 4_000 } else { 20_000 })?;
    scene.contact = Contact::default();
    Ok(scene)
}

fn built_in(
    name: &str,
    what: &str,
    expected: Expected,
    activations: f64,
    degrees: f64,
    smallest: f64,
) -> Row {
    let what = format!("the built-in face: {what}");
    Row::new("faces", name, what, expected, move |settings| {
        let scene = face(settings)?;
        let mut rig = rig(&scene, smallest, settings)?;
        solve(&scene, &mut rig, &pose(&scene, activations, degrees))
    })
}

/// The built-in face with its eyeballs, teeth and lips, which touch.
fn touching(name: &str, what: &str, smile: f64, degrees: f64) -> Row {
    let what = format!("the built-in face with lips, teeth and eyeballs: {what}");
    Row::new("faces", name, what, Expected::Answer, move |settings| {
        let scene = Scene::builtin(if settings.quick { 4_000 } else { 20_000 })?;
        let mut rig = rig(&scene, WALK, settings)?;
        let mut pose = pose(&scene, 0.0, degrees);
        let muscles = scene.muscles.iter().zip(&mut pose.activations);
        muscles
            .filter(|(muscle, _)| muscle.name.starts_with("zygomaticus_major"))
            .for_each(|(_, activation)| *activation = smile);
        solve(&scene, &mut rig, &pose)
    })
}

/// A head of the reference data, where that is.
fn head(
    file: &str,
    activations: f64,
    degrees: f64,
    settings: &Settings,
) -> Result<Evidence, Failure> {
    if workbench::shared::folder().is_none() {
        return Err(Failure::skipped(
            "no folder with the reference data beside the repository",
        ));
    }
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/face-scenes/scenes");
    let scene = Scene::load(scenes.join(file))?;
    let mut rig = rig(&scene, WALK, settings)?;
    solve(&scene, &mut rig, &pose(&scene, activations, degrees))
}

/// The face with its zygomatic muscle of the left side once more.
fn with_twin(mut scene: Scene) -> Result<(Scene, usize, usize), Failure> {
    let one = scene
        .muscles
        .iter()
        .position(|m| m.name == "zygomaticus_major_L");
    let one = one.ok_or_else(|| Failure::trial(&"no zygomaticus_major_L"))?;
    let two = scene.muscles.len();
    scene.muscles.push(Muscle {
        name: "zygomaticus_twin_L".to_owned(),
    });
    let entries = scene.fiber_field.entries();
    let again = entries.iter().filter(|e| e.muscle as usize == one);
    let again = again.map(|e| FiberEntry {
        muscle: two as u32,
        ..*e
    });
    let all = entries.iter().copied().chain(again).collect();
    let tets = scene.mesh.num_elements();
    let field = FiberField::new(all, tets, two + 1);
    scene.fiber_field = field.map_err(|e| Failure::trial(&e))?;
    Ok((scene, one, two))
}

fn twins(settings: &Settings) -> Result<Evidence, Failure> {
    let (scene, one, two) = with_twin(face(settings)?)?;
    let mut rig = rig(&scene, WALK, settings)?;
    let mut truth = pose(&scene, 0.0, 0.0);
    (truth.activations[one], truth.activations[two]) = (0.4, 0.4);
    let posed = solve(&scene, &mut rig, &truth)?;
    let goal = |l: &face_scenes::Landmark, x: &[[f64; 3]]| Goal {
        point: l.point,
        position: l.point.position(x),
        weight: 1.0,
    };
    let x = rig.equilibrium().positions();
    let target = Target {
        name: "twins".to_owned(),
        kind: TargetKind::Expression,
        landmarks: scene.landmarks.iter().map(|l| goal(l, &x)).collect(),
        dense: None,
        jaw_truth: None,
        alignment: None,
    };
    let mut rig = self::rig(&scene, WALK, settings)?;
    let map = Parametrization::of_all(
        scene.muscles.len(),
        CraniumModel::Fixed,
        scene.jointed_jaw(),
    );
    let params = FitParams {
        activation_weight: 1e-9,
        ..FitParams::default()
    };
    let mut observer = |_: &FitIteration| {};
    let fit = fit_expression(
        &scene,
        &mut rig,
        &target,
        Observed::Landmarks,
        &map,
        &params,
        &map.rest(),
        &mut observer,
    );
    let fit = fit.map_err(|e| Failure::of("FitError", &e))?;
    let message = match &fit.outcome {
        Outcome::NotConverged(why) => Some(why.to_string()),
        Outcome::Impossible(why) => Some(format!("{why:?}")),
        _ => None,
    };
    if let Some(message) = message {
        return Err(Failure::new("Outcome", message));
    }
    let (a, b) = (fit.activations[one], fit.activations[two]);
    let apart = Evidence {
        left: (a - b).abs(),
        allowed: 1e-6,
        ..Evidence::default()
    };
    let off = Evidence {
        left: fit.rms_after_mm,
        allowed: 0.02 * fit.rms_before_mm,
        note: format!(
            "{a:.3} and {b:.3} of 0.4, {:.4} of {:.3} mm left",
            fit.rms_after_mm, fit.rms_before_mm
        ),
        ..Evidence::default()
    };
    Ok(posed.and(apart).and(off))
}
