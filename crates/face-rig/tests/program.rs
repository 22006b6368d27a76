//! The program as its user meets it: exit codes, messages, files.

use std::path::Path;
use std::process::{Command, Output};

fn face_rig(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_face-rig"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn refused(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let output = face_rig(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    for word in words {
        assert!(
            message.contains(word),
            "{arguments:?} should mention {word}: {message}"
        );
    }
}

#[test]
fn bad_input_is_named_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let simulate = |setting| vec!["simulate", "builtin:5000", "--set", setting];
    refused(
        at,
        &simulate("zygomaticus_major=7"),
        3,
        &["zygomaticus_major=7", "0 (relaxed) to 1"],
    );
    refused(
        at,
        &simulate("zygomaticus_mayor=0.5"),
        3,
        &["zygomaticus_mayor", "did you mean"],
    );
    refused(
        at,
        &["simulate", "builtin:5000", "--jaw", "12"],
        3,
        &["12", "deg"],
    );
    refused(at, &["check", "nothing.json"], 3, &["nothing.json"]);
    refused(at, &["check", "builtin:12"], 3, &["4000"]);
    refused(at, &["check", "builtin:many"], 3, &["whole number"]);
    refused(at, &["fit", "builtin:5000"], 3, &["no targets"]);
    refused(at, &["pose"], 2, &["pose"]);
    std::fs::write(at.join("empty.csv"), "target,landmark,ict_vertex,x,y,z\n").unwrap();
    refused(
        at,
        &["fit", "builtin:5000", "--targets", "empty.csv"],
        3,
        &["target"],
    );
    let left: Vec<_> = std::fs::read_dir(at)
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(left, ["empty.csv"]);
}

#[test]
fn a_pose_is_written_whole_and_never_over_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = [
        "simulate",
        "builtin:5000",
        "--set",
        "zygomaticus_major=0.3",
        "--jaw",
        "4deg",
        "--json",
    ];
    let output = face_rig(at, &arguments);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let results = &report["results"];
    assert_eq!(results["inverted_tets"], 0);
    assert!(results["largest_displacement_mm"].as_f64().unwrap() > 2.0);
    for name in [
        "pose.vtu",
        "pose.obj",
        "pose.glb",
        "pose.png",
        "report.json",
    ] {
        assert!(
            at.join("out").join(name).metadata().unwrap().len() > 100,
            "{name}"
        );
    }
    let before = std::fs::read(at.join("out/pose.vtu")).unwrap();
    refused(at, &arguments, 4, &["out", "--force"]);
    assert_eq!(std::fs::read(at.join("out/pose.vtu")).unwrap(), before);
    let mut forced = arguments.to_vec();
    forced.push("--force");
    assert!(face_rig(at, &forced).status.success());
    assert_eq!(
        std::fs::read(at.join("out/pose.vtu")).unwrap(),
        before,
        "same input, same bytes"
    );
}

#[test]
fn a_scene_file_and_a_table_of_targets_lead_to_a_fit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = r#"{ "name": "small", "face": { "builtin": { "tets": 5000 } },
        "material": { "preset": "soft_tissue" } }"#;
    std::fs::write(at.join("small.json"), scene).unwrap();
    let jacobian = face_rig(at, &["jacobian", "small.json", "--out", "j"]);
    assert!(
        jacobian.status.success(),
        "{}",
        String::from_utf8_lossy(&jacobian.stderr)
    );
    let table = std::fs::read_to_string(at.join("j/jacobian.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 3 * 68);
    // The first column of the jaw's translation is how landmarks follow a jaw that slides left:
    // shifted targets made of it are reached by sliding the jaw.
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = header.iter().position(|h| *h == "jaw_tx").unwrap();
    let check = face_rig(at, &["check", "small.json", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&check.stdout).unwrap();
    assert_eq!(report["landmarks"], 68);
    let chin = table.lines().find(|l| l.starts_with("8,x")).unwrap();
    let follows: f64 = chin.split(',').nth(column).unwrap().parse().unwrap();
    assert!(
        follows > 0.5 && follows < 1.1,
        "the chin follows the jaw by {follows}"
    );
}
