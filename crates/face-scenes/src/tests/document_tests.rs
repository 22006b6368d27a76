//! What the documents let one choose, as fields of a scene: the threshold on the stretches, penalties,
//! QR inside Newton's method, the weights of orthogonality.

use super::influence_tests::promise::Rig;
use super::influence_tests::rig;
use super::influence_tests::with;
use super::*;
use crate::LinearMethod;
use face_rig::rig::{MultigridUse, RigParams};
use fem_assembly::{Assembly, AssemblyBuilder, Dofs};
use fem_materials::inversion::Thresholded;
use fem_materials::{Lame, NeoHookean};

/// A node inside that a control pushes through the back; flesh with ln J and no fibers.
const PUSHED: &str = r#""motions": [ { "name": "push", "nodes": { "sphere": { "center": [0.05, 0.2, 0.05], "radius": 0.001 } },
    "by": [0, 0, -0.07], "range": [0, 1] } ]"#;

fn pushed(inversion: &str) -> Scene {
    let files = with(&format!("{PUSHED}{inversion}"));
    let fibers = ",\n      \"fibers\": { \"table\": \"fibers.csv\" }";
    files.edit("scene.json", fibers, "");
    let flesh = r#"{ "neo_hookean": { "young": 1e4, "poisson": 0.3 } }"#;
    files.edit("scene.json", r#"{ "preset": "soft_tissue" }"#, flesh);
    files.load().expect("a scene")
}

fn posed(scene: &Scene, push: f64) -> Result<Rig, String> {
    let mut rig = rig(scene);
    let mut pose = scene.rest_pose();
    pose.controls[0] = push;
    match rig.solve(&pose) {
        Ok(_) => Ok(rig),
        Err(error) => Err(error.to_string()),
    }
}

/// The flesh of the scene by the wrapped material, without a scene's way to it.
fn reference(scene: &Scene) -> Assembly<3> {
    let Lame { mu, lambda } = scene.regions[0].material.at_rest().expect("a model");
    let flesh = Thresholded::new(NeoHookean { mu, lambda }, 0.25).expect("a threshold");
    let bones = scene.bones.cranium.iter().chain(&scene.bones.jaw);
    let held: Vec<usize> = bones.map(|&n| n as usize).collect();
    let dofs = Dofs::new(scene.mesh.nodes(), &held, &scene.moved_axes()).expect("a split");
    let builder = AssemblyBuilder::new(&scene.mesh, dofs).expect("a builder");
    builder
        .material(flesh)
        .and_then(AssemblyBuilder::build)
        .expect("a body")
}

#[test]
fn flesh_goes_inside_out_under_a_threshold_and_is_balanced_there() {
    let [barred, allowed, thresholded] = [
        "",
        ", \"inversion\": \"allowed\"",
        ", \"inversion\": { \"thresholded\": 0.25 }",
    ]
    .map(pushed);
    for refused in [&barred, &allowed] {
        assert!(posed(refused, 1.0).is_err());
    }
    let rig = posed(&thresholded, 1.0).expect("an equilibrium");
    let x = rig.equilibrium().positions();
    let body = reference(&thresholded);
    let at = body.configuration(&x, &[]).expect("finite");
    let ratios = body.volume_ratios(at).expect("ratios");
    assert!(ratios.iter().any(|&ratio| ratio < -0.05), "{ratios:?}");
    let mut left = vec![0.0; body.dofs().vector_len()];
    body.gradient(at, &mut left).expect("a gradient");
    let largest = body.absolute_forces(at).into_iter().fold(0.0, f64::max);
    let worst = left.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    assert!(worst < 1e-7 * largest, "{worst} of {largest}");
    // Where nothing is below it the pose is that without a threshold.
    let [here, there] =
        [&thresholded, &allowed].map(|s| posed(s, 0.1).expect("a pose").equilibrium().positions());
    for (a, b) in here.as_flattened().iter().zip(there.as_flattened()) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn thresholds_and_weights_and_solvers_that_make_no_sense_are_named() {
    for (entries, parts) in [
        (
            r#""inversion": { "thresholded": 0 }"#,
            ["inversion.thresholded", "0 must be"],
        ),
        (
            r#""inversion": { "thresholded": -0.25 }"#,
            ["inversion.thresholded", "such as 0.25"],
        ),
        (
            r#""inversion": { "thresholded": 1 }"#,
            ["inversion.thresholded", "below 1"],
        ),
        (
            r#""inversion": { "thresholded": null }"#,
            ["inversion", "f64"],
        ),
        (r#""inversion": "lifted""#, ["inversion", "thresholded"]),
        (r#""linear_solver": "lu""#, ["linear_solver", "qr"]),
        (
            r#""fit": { "orthogonality": { "jaw_mm2": -1 } }"#,
            ["fit.orthogonality.jaw_mm2", "0 or more"],
        ),
        (
            r#""fit": { "orthogonality": { "jaw": 1 } }"#,
            ["fit.orthogonality", "jaw_mm2"],
        ),
        (r#""fit": { "relax": 1 }"#, ["fit", "orthogonality"]),
        (r#""fit": { "points": "all" }"#, ["fit.points", "both"]),
        (
            r#""fit": { "points": "both" }"#,
            ["fit.points", "targets.dense"],
        ),
        (
            r#""fit": { "landmark_weight": 0 }"#,
            ["fit.landmark_weight", "above 0"],
        ),
        (
            r#""fit": { "jaw_weight_mm2": -3 }"#,
            ["fit.jaw_weight_mm2", "0 or more"],
        ),
    ] {
        let error = with(entries).load().expect_err(entries).to_string();
        expect(&error, &parts);
    }
    let mut scene = Files::new().load().expect("a scene");
    for threshold in [f64::NAN, 1.0, -1.0] {
        scene.inversion = Inversion::Thresholded(threshold);
        let error = scene.assembly().expect_err("no threshold").to_string();
        expect(&error, &["inversion", &threshold.to_string()]);
    }
}

fn wall(stiffness: &str, shape: &str) -> String {
    format!(
        r#""loads": [ {{ "penalty": {{ "name": "wall", "stiffness": {stiffness}, "shape": {shape}, "range": [0, 2],
          "at": {{ "box": {{ "low": [-0.01, 0.19, 0.01], "high": [0.11, 0.21, 0.11] }} }} }} }} ]"#
    )
}

/// What is behind the plane y = 0.19, which the top of the block enters by 10 mm.
const PLANE: &str = r#"{ "half_space": { "point": [0, 0.19, 0], "normal": [0, -1, 0] } }"#;

#[test]
fn a_penalty_pushes_nodes_out_by_stiffness_times_depth() {
    let scene = with(&wall("300", PLANE)).load().expect("a scene");
    assert!(
        check(&scene)
            .to_string()
            .contains("penalty of 300 N/m on 6 nodes in 1 solids")
    );
    let body = scene.assembly().expect("an assembly");
    let quiet = vec![0.0; scene.muscles.len()];
    let forces = |factor: f64| {
        let controls = [quiet.as_slice(), &[factor]].concat();
        let at = body.configuration(scene.mesh.nodes(), &controls);
        body.forces_everywhere(at.expect("finite"))
    };
    let (off, on) = (forces(0.0), forces(1.5));
    for ((rest, off), on) in scene.mesh.nodes().iter().zip(off).zip(on) {
        let inside = rest[1] > 0.195 && rest[2] > 0.01;
        let push = if inside { -1.5 * 300.0 * 0.01 } else { 0.0 };
        let added: [f64; 3] = std::array::from_fn(|k| on[k] - off[k]);
        assert!((added[1] - push).abs() < 1e-9, "{rest:?}: {added:?}");
        assert!(
            added[0].abs().max(added[2].abs()) < 1e-12,
            "{rest:?}: {added:?}"
        );
    }
    // Solved, the top comes down, further under a stiffer wall and never past it.
    let top = |factor: f64| {
        let mut rig = rig(&scene);
        let mut pose = scene.rest_pose();
        pose.controls[0] = factor;
        let x = rig.solve(&pose).expect("an equilibrium").positions();
        let top = x
            .iter()
            .zip(scene.mesh.nodes())
            .filter(|(_, r)| r[1] > 0.195 && r[2] > 0.01);
        top.map(|(x, _)| x[1]).fold(0.0, f64::max)
    };
    let [none, soft, stiff] = [0.0, 0.5, 2.0].map(top);
    assert!(
        (none - 0.2).abs() < 1e-12 && soft < none && stiff < soft && stiff > 0.19,
        "{soft} {stiff}"
    );
}

#[test]
fn penalties_that_push_nowhere_are_named() {
    let ball = r#"{ "sphere": { "center": [0, 0.2, 0], "radius": -1 } }"#;
    let triangles = r#"{ "triangles": { "file": "teeth.vtu" } }"#;
    for (stiffness, shape, parts) in [
        ("0", PLANE, ["loads[0].stiffness", "above 0"]),
        ("-300", PLANE, ["loads[0].stiffness", "-300"]),
        ("300", ball, ["loads[0].shape", "radius"]),
        ("300", triangles, ["loads[0].shape", "\"contact\""]),
    ] {
        let error = with(&wall(stiffness, shape))
            .load()
            .expect_err(shape)
            .to_string();
        expect(&error, &parts);
    }
    let pulling = wall("300", PLANE).replace("[0, 2]", "[-1, 1]");
    let error = with(&pulling).load().expect_err("it pulls").to_string();
    expect(&error, &["loads[0].range", "below 0"]);
    let blind = with(&wall("300", r#"{ "eyeballs": "eyes.json" }"#));
    blind.text("eyes.json", r#"{ "eyeballs": {} }"#);
    let error = blind.load().expect_err("nothing to push").to_string();
    expect(&error, &["loads[0].shape", "no eyeball"]);
}

#[test]
fn newton_by_qr_finds_the_same_pose_and_says_when_a_face_is_too_large() {
    let plain = Files::new().load().expect("a scene");
    let by_qr = with(r#""linear_solver": "qr""#).load().expect("a scene");
    assert_eq!(plain.linear_solver, LinearMethod::Rig);
    let positions = |scene: &Scene| {
        let mut rig = rig(scene);
        let mut pose = scene.rest_pose();
        pose.activations = vec![0.4, 0.2];
        let solved = rig.solve(&pose).expect("an equilibrium");
        solved.positions()
    };
    let (here, there) = (positions(&by_qr), positions(&plain));
    // Other sums, so other bits.
    assert_ne!(here, there);
    for (a, b) in here.as_flattened().iter().zip(there.as_flattened()) {
        assert!((a - b).abs() < 1e-10, "{a} {b}");
    }
    let with_multigrid = |multigrid| {
        let params = RigParams {
            multigrid,
            ..RigParams::default()
        };
        let made = Scene::rig(&by_qr, params);
        made.map(|rig| rig.params().multigrid)
            .map_err(|error| error.to_string())
    };
    let error = with_multigrid(MultigridUse::Always).expect_err("a contradiction");
    expect(
        &error,
        &["linear_solver", "qr", "--multigrid always", "or take"],
    );
    for multigrid in [MultigridUse::WhereCheaper, MultigridUse::Never] {
        assert_eq!(with_multigrid(multigrid), Ok(MultigridUse::Never));
    }
    let mut face = Scene::builtin(20_000).expect("a face");
    face.linear_solver = LinearMethod::Qr;
    let error = Scene::rig(&face, RigParams::default());
    let error = error.expect_err("too large").to_string();
    expect(&error, &["linear_solver", "at most 3000 unknowns"]);
}

#[test]
fn weights_of_orthogonality_are_those_of_the_scene() {
    let weights = |entries: &str| with(entries).load().expect("a scene").orthogonality();
    let plain = weights(r#""volume": "elements""#);
    assert_eq!((plain.cranium, plain.jaw), (1e-6 * 1e4, 1e-6 * 1e4));
    let other = weights(r#""fit": { "orthogonality": { "jaw_mm2": 50 } }"#);
    assert_eq!((other.cranium, other.jaw), (1e-6 * 1e4, 1e-6 * 50.0));
    let both = r#""fit": { "orthogonality": { "cranium_mm2": 0, "jaw_mm2": 2 } }"#;
    assert_eq!((weights(both).cranium, weights(both).jaw), (0.0, 2e-6));
}

#[test]
fn what_is_not_the_default_is_told_by_a_check() {
    let told = |entries: &str| check(&with(entries).load().expect("a scene")).settings;
    assert_eq!(told(r#""volume": "elements""#), [""; 0]);
    let entries = r#""inversion": { "thresholded": 0.25 }, "linear_solver": "qr",
        "fit": { "jaw_weight_mm2": 20 }"#;
    let report = check(&with(entries).load().expect("a scene"));
    expect(
        &report.to_string(),
        &[
            "setting    stretches below 0.25 are felt as 0.25",
            "setting    Newton's steps by dense QR",
            "setting    fits weigh the jaw's slides by 20 mm²",
        ],
    );
    assert_eq!(told(r#""inversion": "allowed""#).len(), 1);
    let springs = r#""loads": [ { "springs": { "name": "s", "at": { "nodes": [30] }, "stiffness": 5,
        "range": [-1, 2] } } ]"#;
    let error = with(springs).load().expect_err("a push").to_string();
    expect(&error, &["loads[0].range", "push away"]);
}
