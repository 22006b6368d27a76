//! Loads, cavities, motions, strengths and stiffnesses of a scene.

use super::*;
use face_rig::fit::{CraniumModel, JawModel};
use face_rig::rig::{Direction, Parameters, RigParams};
use fem_assembly::Cavity;
use promise::Rig;

#[path = "../../../face-rig/tests/all/promise.rs"]
pub(super) mod promise;

/// The block with these entries behind its material.
pub(super) fn with(entries: &str) -> Files {
    let files = Files::new();
    let material = r#""material": { "preset": "soft_tissue" },"#;
    files.edit("scene.json", material, &format!("{material}\n  {entries},"));
    files
}

pub(super) fn rig(scene: &Scene) -> Rig {
    let params = RigParams::default();
    Rig::of(scene.rig(params).expect("a rig"), params)
}

fn solved(scene: &Scene, change: impl FnOnce(&mut Parameters)) -> Vec<[f64; 3]> {
    let mut rig = rig(scene);
    let mut pose = scene.rest_pose();
    change(&mut pose);
    rig.solve(&pose).expect("an equilibrium").positions()
}

pub(super) const ALL: &str = r#""regions": { "array": "layer", "labels": [
    { "label": 1, "name": "fat", "material": { "neo_hookean": { "young": 5e3, "poisson": 0.4 } } } ] },
  "loads": [
    { "force": { "name": "finger", "at": { "box": { "low": [-0.01, 0.19, 0.09], "high": [0.11, 0.21, 0.11] } },
                 "newtons": [0, 0, -0.6] } },
    { "traction": { "name": "tape", "on": { "box": { "low": [0.09, -0.01, -0.01], "high": [0.11, 0.21, 0.11] } },
                    "pascals": [50, 0, 0], "range": [0, 2] } },
    { "pressure": { "name": "wind", "on": { "seen_from": [0.05, 0.1, 1] }, "pascals": 30, "range": [-1, 1] } },
    { "gravity": { "name": "weight", "density": 1000, "acceleration": [0, -9.81, 0], "range": [0, 1] } },
    { "springs": { "name": "ligament", "at": { "sphere": { "center": [0, 0.2, 0.1], "radius": 0.01 } },
                   "stiffness": 5, "to": [-0.01, 0.2, 0.1], "range": [0, 3] } }
  ],
  "cavities": [
    { "name": "mouth", "faces": { "box": { "low": [-0.01, -0.01, -0.01], "high": [0.11, 0.21, 0.11] },
      "region": "flesh" }, "closed_by": { "point": [0.05, 0.1, 0.05] }, "pascals": 10, "range": [0, 500] }
  ],
  "motions": [
    { "name": "pull", "nodes": { "nodes": [0, 20, 25] }, "axes": "xz", "by": [0.004, 0, 0.002], "range": [0, 1] },
    { "name": "still", "nodes": { "sphere": { "center": [0.1, 0.2, 0.05], "radius": 0.001 } }, "by": [0, 0.003, 0] }
  ],
  "strengths": [ { "name": "smiler", "muscle": "smile", "change": 0.5, "range": [-1, 2] } ],
  "stiffnesses": [ { "name": "firmness", "region": "fat", "range": [-0.5, 1] } ]"#;

#[test]
fn every_kind_is_understood_and_is_a_control_of_the_rig() {
    let files = with(ALL);
    let scene = Scene::load(files.path("scene.json")).expect("a scene");
    let names: Vec<&str> = scene.influences.iter().map(|i| i.name.as_str()).collect();
    let expected = [
        "finger", "tape", "wind", "weight", "ligament", "mouth", "pull", "still", "smiler",
        "firmness",
    ];
    assert_eq!(names, expected);
    let neutral: Vec<f64> = scene.influences.iter().map(|i| i.neutral).collect();
    assert_eq!(neutral, [1.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0, 1.0, 0.5, 0.0]);
    let rig = rig(&scene);
    assert_eq!((rig.muscles(), rig.controls()), (2, 10));
    let map = scene.parametrization(CraniumModel::Fixed, JawModel::Fixed);
    assert_eq!(map.control_numbers(), 8);
    let InfluenceKind::Forces(forces) = &scene.influences[0].kind else {
        panic!("forces");
    };
    let total: f64 = forces.iter().map(|(_, f)| f[2]).sum();
    assert!(forces.len() == 3 && (total + 0.6).abs() < 1e-15);
    // 50 Pa on 0.1 × 0.2 m², and 30 Pa against the front and nothing behind it.
    let sum = |k: usize, axis: usize| {
        let InfluenceKind::Forces(forces) = &scene.influences[k].kind else {
            panic!("forces");
        };
        forces.iter().map(|(_, f)| f[axis]).sum::<f64>()
    };
    assert!((sum(1, 0) - 1.0).abs() < 1e-12, "{}", sum(1, 0));
    assert!((sum(2, 2) + 0.6).abs() < 1e-12, "{}", sum(2, 2));
    let report = crate::check(&scene).to_string();
    for name in expected {
        assert!(report.contains(&format!("control    {name}: ")), "{report}");
    }
    assert!(
        report.contains("10 Pa unless set, 0 to 500 Pa in a fit"),
        "{report}"
    );
}

/// Each column of the rig against differences of poses solved again.
#[test]
fn the_columns_of_a_scene_agree_with_differences() {
    let files = with(ALL);
    let scene = Scene::load(files.path("scene.json")).expect("a scene");
    let mut params = RigParams::default();
    params.newton.gradient_tolerance = 1e-12;
    let mut rig = Rig::of(scene.rig(params).expect("a rig"), params);
    let mut pose = scene.rest_pose();
    pose.activations = vec![0.1, 0.2];
    let names = [
        "tape=0.5",
        "mouth=40",
        "weight=0.3",
        "pull=0.5",
        "smiler=-0.2",
        "wind=-0.4",
    ];
    pose.controls = crate::parse_controls(&scene.influences, names).expect("values");
    rig.solve(&pose).expect("an equilibrium");
    let directions: Vec<Direction> = (0..10).map(Direction::Control).collect();
    let columns = rig
        .sensitivity()
        .expect("a slope")
        .columns(&directions)
        .unwrap();
    for (k, column) in columns.iter().enumerate() {
        let h = if k == 5 { 1e-2 } else { 1e-3 };
        let mut at = |t: f64| {
            let mut moved = pose.clone();
            moved.controls[k] += t;
            rig.solve(&moved).expect("an equilibrium").positions()
        };
        let [a, b, c, d] = [at(h), at(-h), at(2.0 * h), at(-2.0 * h)].map(|x| x.concat());
        let exact = column.concat();
        let scale = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(scale > 0.0, "{k}");
        for i in 0..exact.len() {
            let slope = (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
            let off = (slope - exact[i]).abs();
            assert!(off < 1e-6 * scale, "{k}: {off:e} of {scale:e}");
        }
    }
}

#[test]
fn motions_and_strengths_do_what_they_say() {
    let files = with(ALL);
    let scene = Scene::load(files.path("scene.json")).expect("a scene");
    let rest = scene.mesh.nodes();
    let x = solved(&scene, |pose| pose.controls[6] = 1.0);
    let moved: Vec<usize> = [0, 20, 25]
        .into_iter()
        .filter(|n| scene.bones.free.contains(&(*n as u32)))
        .collect();
    assert!(!moved.is_empty() && moved.len() < 3, "{moved:?}");
    for n in moved {
        assert!((x[n][0] - rest[n][0] - 0.004).abs() < 1e-15);
        assert!((x[n][2] - rest[n][2] - 0.002).abs() < 1e-15);
        assert!((x[n][1] - rest[n][1] - 1.0).abs() > 0.9);
    }
    let near = |p: &[f64; 3]| (p[0] - 0.1).abs() + (p[1] - 0.2).abs() + (p[2] - 0.05).abs() < 1e-9;
    let still = rest.iter().position(near).expect("a node");
    assert!((x[still][1] - rest[still][1] - 0.003).abs() < 1e-15);
    // A muscle half as strong again is one of half as much σ_max again.
    let stronger = with(&ALL.replace(
        r#""change": 0.5, "range": [-1, 2]"#,
        r#""change": 0, "range": [-1, 2]"#,
    ));
    stronger.edit(
        "scene.json",
        "\"targets\"",
        "\"fibers\": { \"max_isometric_stress\": 300e3 },\n  \"targets\"",
    );
    let other = Scene::load(stronger.path("scene.json")).expect("a scene");
    let plain = with(&ALL.replace(
        "\"loads\"",
        "\"fibers\": { \"max_isometric_stress\": 200e3 }, \"loads\"",
    ));
    let scene = Scene::load(plain.path("scene.json")).expect("a scene");
    let tensed = |pose: &mut Parameters| pose.activations = vec![0.05, 0.1];
    let (a, b) = (solved(&scene, tensed), solved(&other, tensed));
    let off = a.concat().into_iter().zip(b.concat());
    let off = off.map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9);
}

/// A scene without any has the assembly that it had.
#[test]
fn a_neutral_stiffness_changes_nothing() {
    let region = r#""regions": { "array": "layer", "labels": [
      { "label": 1, "name": "fat", "material": { "neo_hookean": { "young": 5e3, "poisson": 0.47 } } } ] },
      "volume": "patches""#;
    let plain = Scene::load(with(region).path("scene.json")).expect("a scene");
    let firm =
        r#", "stiffnesses": [ { "name": "firmness", "region": "fat", "range": [-0.5, 1] } ]"#;
    let firm = Scene::load(with(&format!("{region}{firm}")).path("scene.json")).expect("a scene");
    let tensed = |pose: &mut Parameters| pose.activations = vec![0.05, 0.1];
    let (a, b) = (solved(&plain, tensed), solved(&firm, tensed));
    let off = a.concat().into_iter().zip(b.concat());
    let off = off.map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9);
}

#[test]
fn places_and_ranges_that_make_no_sense_are_named() {
    let cavity = |faces: &str, more: &str| {
        format!(r#""cavities": [ {{ "name": "mouth", "faces": {faces}{more} }} ]"#)
    };
    let somewhere = r#"{ "box": { "low": [-0.01, -0.01, 0.09], "high": [1, 1, 1] } }"#;
    let force = |at: &str, more: &str| {
        format!(
            r#""loads": [ {{ "force": {{ "name": "finger", "at": {at}, "newtons": [0, 0, 1]{more} }} }} ]"#
        )
    };
    let cases = [
        (force("{}", ""), vec!["loads[0].at", "give a condition"]),
        (force(r#"{ "nodes": [36] }"#, ""), vec!["loads[0].at.nodes", "node 36 does not exist"]),
        (force(r#"{ "seen_from": [0, 0, 1] }"#, ""), vec!["only faces can be seen"]),
        (
            force(r#"{ "sphere": { "center": [9, 9, 9], "radius": 1 } }"#, ""),
            vec!["loads[0].at", "no node meets", "scale"],
        ),
        (force(r#"{ "region": "flehs" }"#, ""), vec!["did you mean \"flesh\""]),
        (force(somewhere, r#", "range": [1, 0]"#), vec!["loads[0].range", "the lower first"]),
        (force(r#"{ "array": { "name": "nothing", "labels": [1] } }"#, ""), vec!["nothing"]),
        (
            cavity(somewhere, r#", "closed_by": "nothing", "pascals": 5"#),
            vec!["cavities[0].faces", "open at the edge of nodes", "cap the surface"],
        ),
        (cavity(somewhere, ""), vec!["cavities[0]", "does nothing"]),
        (
            r#""motions": [ { "name": "pull", "nodes": { "nodes": [20] }, "axes": "zx", "by": [0, 0, 1] } ]"#.into(),
            vec!["motions[0].axes", "x, y and z"],
        ),
        (
            r#""motions": [ { "name": "pull", "nodes": { "nodes": [20] }, "axes": "xz", "by": [0, 1, 0] } ]"#.into(),
            vec!["motions[0].by", "along y", "not among"],
        ),
        (
            r#""motions": [ { "name": "pull", "nodes": { "sphere": { "center": [0, 0, 0], "radius": 0 } }, "by": [0, 1, 0] } ]"#.into(),
            vec!["motions[0].nodes.sphere.radius", "above 0"],
        ),
        (
            r#""motions": [ { "name": "pull", "nodes": { "nodes": [0] }, "by": [0, 0, 1] } ]"#.into(),
            vec!["motions[0].nodes", "hang on a bone"],
        ),
        (
            r#""strengths": [ { "name": "s", "muscle": "smiel_L" } ]"#.into(),
            vec!["strengths[0].muscle", "did you mean \"smile_L\""],
        ),
        (
            r#""strengths": [ { "name": "s", "muscle": "smile_L" }, { "name": "t", "muscle": "smile" } ]"#.into(),
            vec!["strengths[1]", "strengths[0] changes already"],
        ),
        (
            r#""strengths": [ { "name": "s", "muscle": "smile_L", "change": -1.5 } ]"#.into(),
            vec!["strengths[0]", "below −1"],
        ),
        (
            r#""strengths": [ { "name": "s", "muscle": "smile_L" }, { "name": "s", "muscle": "smile_R" } ]"#.into(),
            vec!["strengths[1].name", "unique"],
        ),
    ];
    for (entries, parts) in cases {
        let error = Scene::load(with(&entries).path("scene.json")).expect_err(&entries);
        expect(&error.to_string(), &parts);
    }
}

#[test]
fn values_are_typed_by_name() {
    let scene = Scene::load(with(ALL).path("scene.json")).expect("a scene");
    let parse =
        |settings: &[&str]| crate::parse_controls(&scene.influences, settings.iter().copied());
    let values = parse(&["mouth=250", "wind = -0.5"]).expect("values");
    assert_eq!(
        (values[0], values[2], values[5], values[8]),
        (1.0, -0.5, 250.0, 0.5)
    );
    for (setting, part) in [
        ("mouth=501", "0 to 500 Pa"),
        ("mouth=nan", "0 to 500 Pa"),
        ("mouth", "expected name=value"),
        ("moth=1", "did you mean \"mouth\""),
        ("finger=x", "finite"),
    ] {
        let error = parse(&[setting]).expect_err(setting).to_string();
        assert!(error.contains(part), "{error}");
    }
    assert!(
        parse(&["wind=0", "wind=1"])
            .expect_err("twice")
            .to_string()
            .contains("already set")
    );
}

/// A mouth of the shipped heads: the faces of the socket with what closes them.
#[test]
fn the_mouth_of_the_coarse_head_is_a_cavity() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/head");
    if !shared.exists() {
        eprintln!("skipped: {} is not there", shared.display());
        return;
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/head_coarse_mouth.json");
    let scene = Scene::load(file).expect("a scene");
    let mouth = scene
        .influences
        .iter()
        .find(|i| i.name == "mouth")
        .expect("a cavity");
    let InfluenceKind::Cavity { faces, apex: None } = &mouth.kind else {
        panic!("{:?}", mouth.kind);
    };
    let volume = Cavity::closed(faces.clone(), 1.0)
        .expect("closed")
        .volume(scene.mesh.nodes())
        .expect("faces of the mesh");
    assert!(volume > 50e-6 && volume < 400e-6, "{volume}");
}
