//! What a file says is what a scene means.

use super::influence_tests::promise::Rig;
use super::*;
use face_rig::fit::{CraniumModel, FitParams, Parametrization};
use face_rig::rig::RigParams;

/// The key of a hinge's file says meters.
#[test]
fn the_hinge_of_a_file_is_in_meters_in_any_scene() {
    let files = Files::new();
    let line = r#"{ "line": { "point": [0, 0.1, 0], "axis": [2, 0, 0] } }"#;
    files.edit("scene.json", line, r#"{ "file": "hinge.json" }"#);
    files.edit("scene.json", "\"name\": \"block\"", "\"scale\": 8");
    // With the byte-order mark that some editors write.
    let hinge = "\u{feff}{ \"hinge_point_m\": [0, 0.8, 0], \"hinge_axis\": [1, 0, 0] }";
    files.text("hinge.json", hinge);
    let scene = files.load().expect("a sound scene");
    assert_eq!(scene.joint.hinge().point(), [0.0, 0.8, 0.0]);
}

#[test]
fn a_landmark_without_weight_counts_nowhere() {
    let fitted = |rows: &str| {
        let files = Files::new();
        files.text(
            "wanted.csv",
            &format!("target,landmark,ict_vertex,x,y,z,weight\n{rows}"),
        );
        files.edit(
            "scene.json",
            "\"targets\": { \"landmarks\": \"landmarks.csv\"",
            "\"targets\": { \"landmarks\": \"wanted.csv\"",
        );
        let scene = files.load().expect("a sound scene");
        let (muscles, jaw) = (scene.muscles.len(), scene.jointed_jaw());
        let map = Parametrization::of_all(muscles, CraniumModel::Fixed, jaw);
        let rig_params = RigParams::default();
        let mut rig = Rig::of(scene.rig(rig_params).expect("a rig"), rig_params);
        let start = map.rest();
        let target = scene.target("smile").expect("a target");
        let (seen, params) = (Observed::Landmarks, FitParams::default());
        rig.lent(|rig| {
            fit_expression(
                &scene,
                rig,
                target,
                seen,
                &map,
                &params,
                &start,
                &mut |_| {},
            )
        })
        .expect("a fit")
    };
    let alone = fitted("smile,0,7,0.01,0,0,1\n");
    let both = fitted("smile,0,7,0.01,0,0,1\nsmile,1,9,0.09,0.09,0.09,0\n");
    assert_eq!((alone.points, both.points), (1, 1));
    for (alone, both) in [
        (alone.rms_before_mm, both.rms_before_mm),
        (alone.rms_after_mm, both.rms_after_mm),
        (alone.largest_mm, both.largest_mm),
    ] {
        assert!((alone - both).abs() < 1e-6, "{alone} against {both}");
    }
}

#[test]
fn tets_that_only_bones_move_are_named() {
    let mut scene = Files::new().load().expect("a sound scene");
    assert_eq!(check(&scene).tets_moved_by_both_bones, [0_u32; 0]);
    let mut bones = vec![Bone::Free; scene.mesh.num_nodes()];
    for (k, n) in scene.mesh.tet(40).into_iter().enumerate() {
        bones[n as usize] = if k < 2 { Bone::Cranium } else { Bone::Jaw };
    }
    scene.bones = face_rig::anatomy::Bones::new(bones);
    let report = check(&scene);
    assert_eq!(report.tets_moved_by_both_bones, [40]);
    let named = "1 tets hang on cranium and jaw with all their nodes (40)";
    expect(&warned(&report), &[named]);
}

/// Landmarks in another place, unit and turn give the fit that they give where they belong.
#[test]
fn targets_laid_over_the_face_are_fitted_as_those_that_lie_there() {
    let face = Scene::builtin(5_000).expect("a face");
    let (s, c) = 1.2_f64.sin_cos();
    let foreign = |p: [f64; 3]| {
        let moved = [p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]];
        [1e3 * moved[0] + 40.0, 1e3 * moved[1], 1e3 * moved[2] - 7.0]
    };
    let table = |place: &dyn Fn([f64; 3]) -> [f64; 3], neutral: bool| {
        let mut text = String::from("target,landmark,ict_vertex,x,y,z\n");
        let mut row = |target: &str, l: &Landmark, p: [f64; 3]| {
            let [x, y, z] = place(p);
            text += &format!("{target},{},{},{x},{y},{z}\n", l.index, l.vertex);
        };
        for l in &face.landmarks {
            let p = l.point.position(face.mesh.nodes());
            if neutral {
                row("rest", l, p);
            }
            // Chin and lower lip drop.
            let drop = match l.index {
                6..=10 | 55..=59 | 65..=67 => 0.004,
                _ => 0.0,
            };
            row("open", l, [p[0], p[1] - drop, p[2]]);
        }
        text
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("targets.csv");
    let read = |text: &str, align: bool| {
        std::fs::write(&file, text).expect("writable");
        let mut scene = face.clone();
        scene.read_targets(&file, align).map(|()| scene)
    };
    let far = read(&table(&foreign, true), false)
        .expect_err("too far")
        .to_string();
    expect(&far, &["--align", "m from its place at rest"]);
    let here = read(&table(&|p| p, true), false).expect("a table");
    for neutral in [true, false] {
        let scene = read(&table(&foreign, neutral), true).expect("a table");
        let by = scene.targets[0].alignment.expect("laid over");
        let (scale, angle) = ((1e3 * by.scale - 1.0).abs(), (by.angle() - 1.2).abs());
        let (most, turned) = if neutral { (1e-9, 1e-9) } else { (5e-3, 5e-3) };
        assert!(
            scale < most && angle < turned,
            "{scale}, {angle}, {neutral}"
        );
        let pairs = scene.targets[0]
            .landmarks
            .iter()
            .zip(&here.targets[0].landmarks);
        let apart = pairs.map(|(a, b)| {
            let square = (0..3).map(|i| (a.position[i] - b.position[i]).powi(2));
            square.sum::<f64>().sqrt()
        });
        let apart = apart.fold(0.0, f64::max);
        assert!(
            apart < if neutral { 1e-12 } else { 1e-3 },
            "{apart} m, {neutral}"
        );
    }
    let mirrored = table(&|p| [-p[0], p[1], p[2]], true);
    let text = read(&mirrored, true)
        .expect_err("left is right")
        .to_string();
    expect(&text, &["\"open\" is a mirror image of the face"]);
}

/// Flesh stretched along one muscle: what its activation adds is σ times the share of each tet, in the
/// stretch that the scene says.
#[test]
fn a_muscle_is_worth_its_share_of_each_tet_in_the_stretch_of_the_scene() {
    let stretch: f64 = 1.2;
    // A fifth longer along y and no thinner: the volume grows by a fifth, too.
    for (said, expected) in [("total", stretch), ("deviatoric", stretch.powf(2.0 / 3.0))] {
        let files = Files::new();
        let fibers = format!("\"fibers\": {{ \"stretch\": \"{said}\" }}, \"targets\"");
        files.edit("scene.json", "\"targets\"", &fibers);
        files.text(
            "fibers.csv",
            "tet,muscle,weight,fx,fy,fz\n3,0,0.5,0,1,0\n8,0,0.25,0,1,0\n3,1,0.125,1,0,0\n",
        );
        let scene = files.load().expect("a sound scene");
        let body = scene.assembly().expect("an assembly");
        let moved = scene.mesh.nodes().iter();
        let moved: Vec<[f64; 3]> = moved.map(|p| [p[0], stretch * p[1], p[2]]).collect();
        let energy = |activations: &[f64]| {
            body.energy(body.configuration(&moved, activations).expect("finite"))
        };
        // ∫ f_a from 1 on, f_a = 1 − 25/6 e².
        let e = expected - 1.0;
        let active = e - 25.0 / 18.0 * e.powi(3);
        let volume = 0.002 / 72.0;
        let all = scene.fibers.max_isometric_stress * volume * 0.75 * active;
        let added = energy(&[1.0, 0.0]) - energy(&[0.0, 0.0]);
        assert!(
            (added / all - 1.0).abs() < 1e-9,
            "{said}: {added} for {all}"
        );
    }
}

/// Bones that turn a tet over: a fit says how many ended so.
#[test]
fn a_fit_counts_the_tets_that_ended_inside_out() {
    let files = Files::new();
    let flesh = r#""inversion": "allowed",
        "material": { "stable_neo_hookean": { "young": 3e4, "poisson": 0.4 } }"#;
    files.edit(
        "scene.json",
        r#""material": { "preset": "soft_tissue" }"#,
        flesh,
    );
    let scene = files.load().expect("a sound scene");
    let point = scene.joint.hinge().point();
    let jaw = face_rig::fit::JawModel::Rigid { point };
    let map = Parametrization::of_all(scene.muscles.len(), CraniumModel::Fixed, jaw);
    for (back, inverted) in [(0.0, false), (0.12, true)] {
        let rig_params = RigParams::default();
        let mut rig = Rig::of(scene.rig(rig_params).expect("a rig"), rig_params);
        let mut start = map.rest();
        let last = start.len() - 1;
        start[last] = -back;
        let params = FitParams {
            max_iterations: 0,
            ..FitParams::default()
        };
        let target = scene.target("smile").expect("a target");
        let seen = Observed::Landmarks;
        let fit = rig
            .lent(|rig| {
                fit_expression(
                    &scene,
                    rig,
                    target,
                    seen,
                    &map,
                    &params,
                    &start,
                    &mut |_| {},
                )
            })
            .expect("a report");
        let turned = |tet: usize| {
            let [a, b, c, d] = scene.mesh.tet(tet).map(|n| fit.positions[n as usize]);
            let edge = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| p[k] - a[k]) };
            let [u, v, w] = [b, c, d].map(edge);
            let normal = |i: usize, j: usize| u[i] * v[j] - u[j] * v[i];
            w[0] * normal(1, 2) + w[1] * normal(2, 0) + w[2] * normal(0, 1) <= 0.0
        };
        let count = (0..scene.mesh.num_elements())
            .filter(|&tet| turned(tet))
            .count();
        assert_eq!((fit.inverted_tets, count > 0), (count, inverted));
        assert_eq!(fit.smallest_ratio < 0.0, inverted);
    }
}
