//! What a file says is what a scene means.

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
        let mut rig = scene.rig(RigParams::default()).expect("a rig");
        let start = map.rest();
        let target = scene.target("smile").expect("a target");
        let (seen, params) = (Observed::Landmarks, FitParams::default());
        fit_expression(
            &scene,
            &mut rig,
            target,
            seen,
            &map,
            &params,
            &start,
            &mut |_| {},
        )
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
