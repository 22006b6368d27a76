//! Files that someone has damaged: read, or refused by name; never a panic.

use super::*;
use fuzz::{Damage, EFFORT};
use std::panic::{AssertUnwindSafe, catch_unwind};

#[path = "../../../../tests/fuzz.rs"]
mod fuzz;

/// The scene of these tests with everything that can be in another file.
fn with_every_reader() -> (Files, Vec<(&'static str, String)>) {
    let files = Files::new();
    files.edit(
        "scene.json",
        r#"{ "line": { "point": [0, 0.1, 0], "axis": [2, 0, 0] } }"#,
        r#"{ "file": "hinge.json" }"#,
    );
    files.edit(
        "scene.json",
        r#"{ "list": ["smile_L", "smile_R"] }"#,
        r#"{ "file": "names.json" }"#,
    );
    files.edit(
        "scene.json",
        r#""skip": ["rest"]"#,
        r#""truth": "truth.json", "skip": ["rest"]"#,
    );
    files.edit(
        "scene.json",
        r#""fibers": { "table": "fibers.csv" }"#,
        r#""fibers": { "table": "fibers.csv" }, "drawn": [{ "name": "drawn_L", "along": {
             "lines": [[[0.02, 0.05, 0.05], [0.15, 0.05, 0.05], { "landmark": 1 }]], "radius": 0.01 } }]"#,
    );
    files.text(
        "hinge.json",
        r#"{ "hinge_point_m": [0, 0.1, 0], "hinge_axis": [1, 0, 0] }"#,
    );
    files.text(
        "names.json",
        r#"[{ "index": 0, "name": "smile_L" }, { "index": 1, "name": "smile_R" }]"#,
    );
    files.text(
        "truth.json",
        r#"{ "smile": { "jaw": { "rotation": [[1,0,0],[0,1,0],[0,0,1]], "translation_m": [0,0,0.001] } } }"#,
    );
    files.load().expect("a sound scene");
    let all = [
        "scene.json",
        "fibers.csv",
        "embedding.csv",
        "landmarks.csv",
        "hinge.json",
        "names.json",
        "truth.json",
    ];
    let texts = all.map(|name| {
        let text = fs::read_to_string(files.path(name)).expect("readable");
        (name, text)
    });
    (files, texts.to_vec())
}

/// Loads a scene with this file of it damaged, over and over; at least a fifth of it must be
/// noticed.
fn damaged(files: &Files, (name, text): (&str, &str), damage: &mut Damage, rounds: usize) {
    let folder = files.path("").display().to_string();
    let (mut read, mut refused) = (0, 0);
    let rounds = EFFORT * rounds;
    for _ in 0..rounds {
        let bytes = damage.of(text);
        // A file that is cut and written again waits for the disk, a new one does not.
        fs::remove_file(files.path(name)).expect("there");
        fs::write(files.path(name), &bytes).expect("writable");
        let shown = || format!("{name}:\n{}", String::from_utf8_lossy(&bytes));
        let loaded = catch_unwind(AssertUnwindSafe(|| {
            files.load().map(|scene| check(&scene).to_string())
        }));
        match loaded.unwrap_or_else(|_| panic!("a panic by {}", shown())) {
            Ok(_) => read += 1,
            Err(error) => {
                refused += 1;
                let told = error.to_string();
                assert!(told.contains(&folder), "{told}\n{}", shown());
            }
        }
    }
    // Damage that no reader ever notices would be none.
    assert!(
        refused > rounds / 5 && read > 0,
        "{name}: {read} read, {refused} refused"
    );
    files.text(name, text);
}

#[test]
fn damaged_scenes_and_tables_are_read_or_refused() {
    let (files, texts) = with_every_reader();
    let mut damage = Damage(0x5931_a7b3_f7df_b7fd);
    for (name, text) in &texts {
        damaged(&files, (name, text), &mut damage, 300);
    }
}

/// Muscles as curves: names, widths and points far away, many or none.
#[test]
fn damaged_curves_are_read_or_refused() {
    let files = course_tests::drawn(course_tests::FROM_FILE, "");
    files.text("curves.json", course_tests::CURVES);
    files.load().expect("a sound scene");
    let mut damage = Damage(0x0f1e_2d3c_4b5a_6978);
    let file = ("curves.json", course_tests::CURVES);
    damaged(&files, file, &mut damage, 1000);
}

/// Loads, cavities, motions, strengths, stiffnesses, regions, ligaments and contact.
#[test]
fn damaged_influences_are_read_or_refused() {
    let ligament = r#""ligaments": [{ "name": "tendon", "stiffness": 2e6, "toe": 0.02, "along": {
        "lines": [[[0.02, 0.05, 0.05], [0.05, 0.05, 0.05]]], "radius": 0.005 } }]"#;
    let contact = r#""contact": { "flesh": true }"#;
    let entries = format!("{}, {ligament}, {contact}", influence_tests::ALL);
    let files = influence_tests::with(&entries);
    files.load().expect("a sound scene");
    let text = fs::read_to_string(files.path("scene.json")).expect("readable");
    let mut damage = Damage(0x0123_4567_89ab_cdef);
    damaged(&files, ("scene.json", &text), &mut damage, 6000);
}

/// Numbers on the command line: read, or refused.
#[test]
fn damaged_settings_are_read_or_refused() {
    let mut damage = Damage(0xfedc_ba98_7654_3210);
    let muscles = Files::new().load().expect("a sound scene").muscles;
    for text in ["smile=0.5", "smile_R=1e-3", "12deg", "-0.2rad", "7.5 deg"] {
        for _ in 0..20_000 * EFFORT {
            let bytes = damage.of(text);
            let text = String::from_utf8_lossy(&bytes);
            let angle = catch_unwind(|| crate::parse_angle(&text).map_err(|e| e.to_string()));
            match angle.unwrap_or_else(|_| panic!("a panic by {text:?}")) {
                Ok(radians) => assert!(radians.is_finite(), "{text:?}: {radians}"),
                Err(told) => assert!(!told.is_empty()),
            }
            let set = catch_unwind(|| crate::parse_activations(&muscles, [&*text]));
            match set.unwrap_or_else(|_| panic!("a panic by {text:?}")) {
                Ok(values) => assert!(
                    values.iter().all(|v| (0.0..=1.0).contains(v)),
                    "{text:?}: {values:?}"
                ),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
}

/// Controls beside activations on the command line.
#[test]
fn damaged_controls_are_read_or_refused() {
    let mut damage = Damage(0x2468_ace0_1357_9bdf);
    let scene = influence_tests::with(influence_tests::ALL).load();
    let influences = scene.expect("a sound scene").influences;
    for text in ["tape=0.5", "mouth=40", "weight = 0.3", "smiler=-0.2"] {
        assert!(crate::parse_controls(&influences, [text]).is_ok(), "{text}");
        for _ in 0..20_000 * EFFORT {
            let bytes = damage.of(text);
            let text = String::from_utf8_lossy(&bytes);
            let set = catch_unwind(|| crate::parse_controls(&influences, [&*text]));
            match set.unwrap_or_else(|_| panic!("a panic by {text:?}")) {
                Ok(values) => assert!(values.iter().all(|v| v.is_finite()), "{text:?}: {values:?}"),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
}
