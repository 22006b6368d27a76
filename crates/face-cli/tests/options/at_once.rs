//! Fits side by side are the fits one after the other.

use super::*;
use std::collections::BTreeMap;
use std::process::Output;

fn face_rig(at: &Path, options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_face-rig"))
        .args(["fit", "scene.json", "--force", "--targets", "more.csv"])
        .args(options)
        .current_dir(at)
        .output()
        .unwrap()
}

/// A table `more.csv` of the targets and of the first one under other names, moved by as much (m) to the side.
fn also(at: &Path, moved: &[(&str, f64)]) {
    let table = std::fs::read_to_string(at.join("targets.csv")).unwrap();
    let first = table.lines().filter(|row| row.starts_with("first,"));
    let mut more = table.clone();
    for row in first {
        for (name, by) in moved {
            let mut fields: Vec<String> = row.split(',').map(str::to_owned).collect();
            fields[0] = (*name).to_owned();
            let x: f64 = fields[3].parse().unwrap();
            fields[3] = format!("{:e}", x + by);
            more += &fields.join(",");
            more.push('\n');
        }
    }
    std::fs::write(at.join("more.csv"), more).unwrap();
}

/// A report without clocks, and without how many were at work.
fn timeless(value: &Value) -> Value {
    const OF_CLOCKS: [&str; 4] = ["seconds", "phase_seconds", "at_once", "threads"];
    match value {
        Value::Object(fields) => {
            let kept = fields
                .iter()
                .filter(|(key, _)| !OF_CLOCKS.contains(&key.as_str()));
            Value::Object(kept.map(|(k, v)| (k.clone(), timeless(v))).collect())
        }
        Value::Array(values) => values.iter().map(timeless).collect(),
        other => other.clone(),
    }
}

/// Every file of a folder, the report without clocks.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap());
    let of = |entry: std::fs::DirEntry| {
        let name = entry.file_name().into_string().unwrap();
        let bytes = std::fs::read(entry.path()).unwrap();
        let bytes = match name.as_str() {
            "report.json" => timeless(&serde_json::from_slice(&bytes).unwrap())
                .to_string()
                .into_bytes(),
            _ => bytes,
        };
        (name, bytes)
    };
    entries.map(of).collect()
}

/// What the user is told, without the column of seconds and the name of the folder.
fn told_text(output: &Output) -> Vec<String> {
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().filter(|line| !line.starts_with("results in"));
    let timeless = |line: &str| match line.starts_with('|') {
        true => {
            let mut fields: Vec<&str> = line.split('|').collect();
            fields.remove(7);
            fields.join("|")
        }
        false => line.to_owned(),
    };
    lines.map(timeless).collect()
}

fn report_in(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

#[test]
fn any_number_at_once_writes_draws_and_tells_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    also(at, &[("beyond", 0.05), ("beside", 2e-3), ("last", -1e-3)]);
    let run = |at_once: &str| {
        let options = ["--threads", "3", "--jaw", "rigid"];
        let own = ["--at-once", at_once, "--out", at_once];
        let output = face_rig(at, &[&options[..], &own].concat());
        (
            output.status.code(),
            told_text(&output),
            results(&at.join(at_once)),
        )
    };
    let (code, text, files) = run("1");
    let report = report_in(&at.join("1"));
    let fits = report["results"]["fits"].as_array().unwrap();
    let names: Vec<&str> = fits.iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(code, Some(1));
    for name in ["fits.png", "convergence.svg", "last.vtu", "last.glb"] {
        assert!(files.contains_key(name), "{name}");
    }
    // One ends in a pose that no jaw has, and is told as that among the others.
    let ends = fits
        .iter()
        .map(|f| f["outcome"].as_object().unwrap().keys().next().unwrap());
    let ends: Vec<&String> = ends.collect();
    let beyond = names.iter().position(|name| *name == "beyond").unwrap();
    assert!(
        ends[beyond] != "converged" && ends.iter().any(|end| *end == "converged"),
        "{ends:?}"
    );
    for (at_once, counted) in [("2", 2), ("9", 5)] {
        let (other_code, other_text, other_files) = run(at_once);
        assert_eq!((other_code, &other_text), (code, &text), "{at_once}");
        for (name, bytes) in &files {
            assert!(other_files.get(name) == Some(bytes), "{at_once}: {name}");
        }
        assert_eq!(other_files.len(), files.len(), "{at_once}");
        let settings = &report_in(&at.join(at_once))["settings"];
        assert_eq!(settings["at_once"], counted, "no more than targets");
    }
}

#[test]
fn a_fit_knows_nothing_of_those_that_its_rig_had_before() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    // Without a weight the face begins at rest itself, so that a derivative can be left there.
    let text = std::fs::read_to_string(at.join("scene.json")).unwrap();
    let weightless = text.split(",\n  \"loads\"").next().unwrap();
    std::fs::write(at.join("scene.json"), format!("{weightless} }}")).unwrap();
    // The first is a hierarchy that still serves.
    for options in [
        &["--multigrid", "always"][..],
        &["--max-iterations", "1"],
        &[],
    ] {
        let of = |more: &[&str]| {
            let fits = report(at, "fit", &[options, more].concat()).1["results"]["fits"].clone();
            timeless(fits.as_array().unwrap().last().unwrap())
        };
        let alone = of(&["--target", "second"]);
        assert_eq!(of(&["--at-once", "1"]), alone, "{options:?}");
        assert_eq!(of(&["--at-once", "2"]), alone, "{options:?}");
    }
}

#[test]
fn as_many_run_at_once_as_threads_and_targets_and_one_where_each_follows_another() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    let counted = |options: &[&str]| report(at, "fit", options).1["settings"]["at_once"].clone();
    for (options, count) in [
        (&["--threads", "1"][..], 1),
        (&["--threads", "2"], 2),
        (&["--threads", "3"], 2),
        (&["--threads", "3", "--target", "second"], 1),
        (&["--threads", "1", "--at-once", "2"], 2),
        (&["--threads", "2", "--warm-start"], 1),
        (&["--threads", "2", "--warm-start", "--at-once", "1"], 1),
    ] {
        assert_eq!(counted(options), count, "{options:?}");
    }
    also(at, &[]);
    let output = face_rig(at, &["--warm-start", "--at-once", "2", "--out", "none"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for part in ["--at-once 2", "--warm-start"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!at.join("none").exists());
    assert_eq!(face_rig(at, &["--at-once", "0"]).status.code(), Some(2));
}

/// Targets without a skin, where the skin is wanted; and flesh too heavy for its bones, so that no fit can begin.
#[test]
fn what_cannot_be_fitted_is_told_the_same_however_many_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    also(at, &[("bare", 1e-3), ("naked", 2e-3)]);
    for at_once in ["1", "2", "4"] {
        let output = face_rig(
            at,
            &["--points", "dense", "--at-once", at_once, "--out", "dense"],
        );
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{message}");
        assert!(
            message.contains("target first: the target is empty"),
            "{at_once}: {message}"
        );
    }
    let text = std::fs::read_to_string(at.join("scene.json")).unwrap();
    let heavy = text.replace("-9.81", "-1e4");
    std::fs::write(at.join("scene.json"), heavy).unwrap();
    let (code, one) = report(at, "fit", &["--targets", "more.csv", "--at-once", "1"]);
    assert_eq!(code, Some(1));
    let impossible = one["results"]["impossible"].as_object().unwrap();
    let names: Vec<&String> = impossible.keys().collect();
    assert_eq!(names, ["bare", "first", "naked", "second"]);
    let (other_code, two) = report(at, "fit", &["--targets", "more.csv", "--at-once", "2"]);
    assert_eq!((other_code, timeless(&two)), (code, timeless(&one)));
}

#[test]
fn files_that_cannot_be_written_end_the_work_of_all() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    with_targets(at);
    let names: Vec<String> = (0..40).map(|k| format!("more{k}")).collect();
    let moved: Vec<(&str, f64)> = names.iter().map(|name| (name.as_str(), 1e-3)).collect();
    also(at, &moved);
    // A folder where the first file should be.
    std::fs::create_dir_all(at.join("out/first.obj/full")).unwrap();
    let options = [
        "--pictures",
        "none",
        "--write",
        "obj",
        "--threads",
        "3",
        "--at-once",
        "2",
    ];
    let output = face_rig(at, &options);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{message}");
    assert!(message.contains("first.obj"), "{message}");
    let made = |name: &str| at.join(format!("out/{name}.obj")).is_file();
    assert!(!made("more39") && !at.join("out/report.json").exists());
}
