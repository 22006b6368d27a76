//! The jaw's joint in scene files, and flesh that may not end inside out.

use super::*;
use face_rig::anatomy::{CondylarPath, JointLimits};

const AXIS: &str = "\"axis\": [2, 0, 0] } },";

fn with_joint(joint: &str) -> Files {
    let files = Files::new();
    files.edit(
        "scene.json",
        AXIS,
        &format!("{AXIS}\n    \"joint\": {joint},"),
    );
    files
}

#[test]
fn a_hinge_alone_turns_within_the_limits_of_an_adult_joint() {
    let joint = Files::new().load().expect("a sound scene").joint;
    assert_eq!(*joint.path(), CondylarPath::default());
    assert_eq!(*joint.limits(), JointLimits::ADULT);
    assert_eq!(joint.condyles(), [[0.05, 0.1, 0.0], [-0.05, 0.1, 0.0]]);
}

#[test]
fn path_limits_and_condyles_are_read_in_the_unit_of_the_scene() {
    let files = with_joint(
        r#"{ "path": { "length": 6, "inclination_deg": 30, "full_at_deg": 20 },
        "limits": { "lateral": [-4, 3], "opening_deg": [-1, 30] },
        "condyles": [[40, 1, 2], [-40, 1, 2]] }"#,
    );
    files.edit("scene.json", "\"name\": \"block\"", "\"scale\": 0.001");
    let joint = files.load().expect("a sound scene").joint;
    let path = joint.path();
    assert!((path.length - 0.006).abs() < 1e-15);
    assert!((path.inclination.to_degrees() - 30.0).abs() < 1e-12);
    assert!((path.full_at.to_degrees() - 20.0).abs() < 1e-12);
    let limits = joint.limits();
    assert_eq!(limits.lateral, [-0.004, 0.003]);
    assert!((limits.opening[1].to_degrees() - 30.0).abs() < 1e-12);
    assert_eq!(limits.protrusion, JointLimits::ADULT.protrusion);
    assert_eq!(
        joint.condyles(),
        [[0.04, 0.001, 0.002], [-0.04, 0.001, 0.002]]
    );
}

#[test]
fn a_hinge_file_may_know_the_condyles() {
    let files = Files::new();
    let line = r#"{ "line": { "point": [0, 0.1, 0], "axis": [2, 0, 0] } }"#;
    files.edit("scene.json", line, r#"{ "file": "hinge.json" }"#);
    let hinge = "{ \"hinge_point_m\": [0, 0.8, 0], \"hinge_axis\": [1, 0, 0],
        \"condyles_m\": { \"R\": [-0.06, 0.8, 0], \"L\": [0.06, 0.8, 0] } }";
    files.text("hinge.json", hinge);
    let joint = files.load().expect("a sound scene").joint;
    assert_eq!(joint.condyles(), [[0.06, 0.8, 0.0], [-0.06, 0.8, 0.0]]);
}

#[test]
fn a_joint_that_makes_no_sense_is_found_in_its_line() {
    for (joint, words) in [
        (
            r#"{ "limits": { "lateral": [0.001, 0.002] } }"#,
            "limits of the lateral shift, 0.001 to 0.002",
        ),
        (
            r#"{ "path": { "length": -0.01, "inclination_deg": 30, "full_at_deg": 20 } }"#,
            "the path's length is -0.01",
        ),
        (
            r#"{ "path": { "length": 0.01, "inclination_deg": 30, "full_at_deg": 0 } }"#,
            "opening at the path's end",
        ),
    ] {
        let text = with_joint(joint).error("scene.json: line 7, face.files.joint: ");
        expect(&text, &[words]);
    }
    let text = with_joint(r#"{ "way": 3 }"#).error("scene.json:7:");
    expect(&text, &["unknown field `way`", "`path`"]);
    let files = Files::new();
    files.edit("scene.json", "[2, 0, 0]", "[0, 2, 0]");
    expect(
        &files.error("scene.json: line 6, face.files.hinge.line: "),
        &["points up"],
    );
}

/// A flattened block costs as much as its model says, and an element turned inside out far more than
/// any load on a face pays for, unless the scene allows it; then it is no equilibrium either.
#[test]
fn flesh_is_barred_from_turning_inside_out_unless_allowed() {
    let energies = |inversion: &str| {
        let files = Files::new();
        let material = r#"{ "stable_neo_hookean": { "young": 3e4, "poisson": 0.4 } }"#;
        files.edit("scene.json", r#"{ "preset": "soft_tissue" }"#, material);
        files.edit("scene.json", "\"name\": \"block\",", inversion);
        let scene = files.load().expect("a sound scene");
        let assembly = scene.assembly().expect("an assembly");
        let quiet = vec![0.0; assembly.controls()];
        [0.21, 0.1, -0.1].map(|height| {
            let rest = assembly.rest().iter();
            let x: Vec<_> = rest.map(|x| [x[0], height * x[1], x[2]]).collect();
            assembly.energy(assembly.configuration(&x, &quiet).expect("finite"))
        })
    };
    let [early, late, inside_out] = energies("");
    let [early_allowed, late_allowed, inside_out_allowed] = energies("\"inversion\": \"allowed\",");
    assert_eq!(early, early_allowed);
    // −κ (1 − u)² ln u at u = 0.1/0.2, in 2 liters, κ the shear modulus.
    let expected = 0.25 * 2.0_f64.ln() * 3e4 / 2.8 * 0.002;
    let wall = late - late_allowed;
    assert!(
        (wall - expected).abs() < 1e-9 * expected,
        "{wall} for {expected}"
    );
    // The parabola from u = 0.002 on, at u = −0.1/0.2, where φ'' = 2.5e5.
    let wall = inside_out - inside_out_allowed;
    let parabola = 0.5 * 2.5e5 * 0.502_f64.powi(2) * 3e4 / 2.8 * 0.002;
    assert!(
        (wall / parabola - 1.0).abs() < 0.02,
        "{wall} for {parabola}"
    );
}
