//! The program as its user meets it: exit codes, messages, files.

use face_scenes::Scene;
use fem_assembly::mesh::{DataArray, MeshFile, kuhn_grid};
use std::path::Path;
use std::process::{Command, Output, Stdio};

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
    for (option, value) in [
        ("--relax", "NaN"),
        ("--relax", "-1"),
        ("--robust", "0"),
        ("--stop", "inf"),
        ("--threads", "0"),
    ] {
        refused(
            at,
            &["fit", "builtin:5000", option, value],
            2,
            &[option, value],
        );
    }
    refused(
        at,
        &["fit", "builtin:5000", "--target", "smile"],
        3,
        &["--targets"],
    );
    refused(at, &["demo", "--tets", "10"], 3, &["4000 to 2000000"]);
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
fn a_reader_that_closes_the_pipe_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_face-rig"))
        .args(["check", "builtin:5000"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(message.is_empty(), "{message}");
}

/// The phases of a report, those of every run and its own, add up to its seconds: none is missing, and
/// nothing is left for others.
fn assert_phases(report: &serde_json::Value, own: &[&str]) {
    let phases = report["phase_seconds"].as_object().unwrap();
    let mut expected = ["start", "scene", "assembly", "report"].to_vec();
    expected.extend(own);
    expected.sort_unstable();
    assert!(phases.keys().eq(expected), "{phases:?}");
    let sum: f64 = phases.values().map(|s| s.as_f64().unwrap()).sum();
    let seconds = report["seconds"].as_f64().unwrap();
    assert!((sum - seconds).abs() < 1e-9, "{sum} {seconds}");
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
    assert_phases(&report, &["equilibrium", "files", "pictures"]);
    let results = &report["results"];
    assert_eq!(results["inverted_tets"], 0);
    let torques = &results["jaw_torques_newton_meters"];
    let (left, right) = (&torques["masseter_L"], &torques["masseter_R"]);
    let (left, right) = (left.as_f64().unwrap(), right.as_f64().unwrap());
    // An open jaw stretches its closers; the face is its own mirror image.
    assert!(left < 0.0 && (left - right).abs() < 1e-6 * left.abs());
    assert!(torques.get("frontalis_medial_L").is_none());
    assert!(results["largest_displacement_mm"].as_f64().unwrap() > 2.0);
    let evaluated = &results["evaluations"];
    let count = |of: &str, pass: &str| evaluated[of][pass].as_u64().unwrap();
    // Every step assembles once and more for each projected try; muscles that pull are evaluated.
    let (elements, fibers) = (count("elements", "hessians"), count("fibers", "hessians"));
    assert!(elements >= 1000 * results["newton_steps"].as_u64().unwrap());
    assert!(fibers > 0 && fibers < elements);
    assert!(count("contacts", "gradients") > 0 && evaluated["searches"].as_u64().unwrap() > 0);
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

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let name = |e: std::io::Result<std::fs::DirEntry>| e.unwrap().file_name();
    let mut names: Vec<String> = entries.map(|e| name(e).into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_folder_belongs_to_one_run_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let arguments = ["simulate", "builtin:4000", "--jaw", "1deg", "--out", "out"];
    std::fs::create_dir(at.join("out")).unwrap();
    let path = at.join("out/.face-rig.lock");
    let other = std::fs::File::create(&path).unwrap();
    other.lock().unwrap();
    refused(at, &arguments, 4, &["out", "another run"]);
    let forced = [&arguments[..], &["--force"]].concat();
    refused(at, &forced, 4, &["out", "another run"]);
    // A run that was killed leaves its file, and the system takes its lock.
    drop(other);
    assert!(path.exists());
    let output = face_rig(at, &arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert!(!path.exists());
    let glb_alone = ["--out", "bare", "--pictures", "none", "--write", "glb"];
    let bare = [&arguments[..4], &glb_alone].concat();
    assert!(face_rig(at, &bare).status.success());
    assert_eq!(files(&at.join("bare")), ["pose.glb", "report.json"]);
}

#[test]
fn a_scene_file_and_a_table_of_targets_lead_to_a_fit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = r#"{ "name": "small", "face": { "builtin": { "tets": 5000 } },
        "material": { "preset": "soft_tissue" }, "contact": {} }"#;
    // Without what the built-in face touches: fits of it take ten times as long.
    std::fs::write(at.join("small.json"), scene).unwrap();
    let jacobian = face_rig(at, &["jacobian", "small.json", "--out", "j"]);
    assert!(
        jacobian.status.success(),
        "{}",
        String::from_utf8_lossy(&jacobian.stderr)
    );
    let report = std::fs::read(at.join("j/report.json")).unwrap();
    let report = serde_json::from_slice(&report).unwrap();
    assert_phases(&report, &["equilibrium", "jacobian", "files"]);
    let table = std::fs::read_to_string(at.join("j/jacobian.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 3 * 68);
    // The first column of the jaw's translation is how landmarks follow a jaw that slides left:
    // shifted targets made of it are reached by sliding the jaw.
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = header.iter().position(|h| *h == "jaw_tx").unwrap();
    let check = face_rig(at, &["check", "small.json", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&check.stdout).unwrap();
    assert_eq!(report["landmarks"], 68);
    let follow = |row: &str| -> f64 {
        let line = table.lines().find(|l| l.starts_with(row)).unwrap();
        line.split(',').nth(column).unwrap().parse().unwrap()
    };
    let chin = follow("8,x");
    assert!(chin > 0.5 && chin < 1.1, "the chin follows by {chin}");

    // Two frames of a sequence, the jaw 1 and 2 mm to the left.
    let face = Scene::builtin(5000).unwrap();
    let mut targets = String::from("target,landmark,ict_vertex,x,y,z,weight\n");
    for (name, slide) in [("frame 1", 1e-3), ("frame 2", 2e-3)] {
        for l in &face.landmarks {
            let rest = l.point.position(face.mesh.nodes());
            let [x, y, z] =
                ["x", "y", "z"].map(|axis| slide * follow(&format!("{},{axis}", l.index)));
            let (x, y, z) = (rest[0] + x, rest[1] + y, rest[2] + z);
            let weight = if l.index < 17 { 2.0 } else { 1.0 };
            targets += &format!("{name},{},0,{x:e},{y:e},{z:e},{weight}\n", l.index);
        }
    }
    std::fs::write(at.join("sequence.csv"), &targets).unwrap();
    let arguments = [
        "fit",
        "small.json",
        "--targets",
        "sequence.csv",
        "--warm-start",
        "--jaw-weight",
        "0",
        "--json",
    ];
    let fit = face_rig(at, &arguments);
    assert!(
        fit.status.success(),
        "{}",
        String::from_utf8_lossy(&fit.stderr)
    );
    let report: serde_json::Value = serde_json::from_slice(&fit.stdout).unwrap();
    for (k, frame) in report["results"]["fits"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
    {
        let slide = frame["jaw_pose"]["lateral_mm"].as_f64().unwrap();
        assert!(
            (slide - (k + 1) as f64).abs() < 0.1,
            "frame {k}: {slide} mm"
        );
        let (before, after) = (&frame["rms_before_mm"], &frame["rms_after_mm"]);
        assert!(after.as_f64().unwrap() < 0.1 * before.as_f64().unwrap());
        assert_eq!(frame["inverted_tets"], 0);
        let work = &frame["work"];
        let count = |of: &str| work[of].as_u64().unwrap();
        assert!(count("equilibria") > 0 && count("right_hand_sides") > 0);
        assert!(
            work["evaluations"]["elements"]["gradients"]
                .as_u64()
                .unwrap()
                > 0
        );
        // This scene touches nothing.
        assert_eq!(work["evaluations"]["contacts"]["gradients"], 0);
        assert!(at.join(format!("out/frame {}.vtu", k + 1)).is_file());
    }
    let own = ["rest picture", "fit", "files and pictures", "sheet"];
    assert_phases(&report, &own);

    // One sheet for both; each on its own if asked for; nothing if not.
    let again = |out: &str, options: &[&str]| {
        let one_step = ["--max-iterations", "1", "--out", out];
        let arguments = [&arguments[..], &one_step[..], options].concat();
        face_rig(at, &arguments);
        files(&at.join(out))
    };
    let sheet = ["convergence.svg", "fits.png"];
    let png = ["frame 1.png", "frame 2.png"];
    let report = ["report.json"];
    let has = |names: &[String], some: &[&str]| some.iter().all(|s| names.iter().any(|n| n == s));
    let out = files(&at.join("out"));
    assert!(has(&out, &sheet) && !has(&out, &png[..1]), "{out:?}");
    let all = again("all", &["--pictures", "all", "--write", "obj"]);
    let obj = ["frame 1.obj", "frame 2.obj"];
    assert!(has(&all, &sheet) && has(&all, &png) && has(&all, &obj));
    assert_eq!(all.len(), 2 + 2 + 2 + 1, "{all:?}");
    let bare = again("bare", &["--pictures", "none", "--write", "none"]);
    assert_eq!(bare, report);

    // The jaw of frame 1 as other models have it: a hinge cannot slide, a weight holds the joint.
    let lateral = |arguments: &[&str]| {
        let mut all = vec!["fit", "small.json", "--targets", "sequence.csv", "--json"];
        all.extend(["--target", "frame 1", "--force", "--out", "jaws"]);
        all.extend(arguments);
        let output = face_rig(at, &all);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let fit = &report["results"]["fits"][0];
        fit["jaw_pose"]["lateral_mm"].as_f64().unwrap()
    };
    assert!(lateral(&["--jaw", "hinge"]).abs() < 1e-9);
    assert!((lateral(&["--jaw", "rigid"]) - 1.0).abs() < 0.1);
    assert!(lateral(&["--jaw", "joint", "--jaw-weight", "1e6"]).abs() < 0.05);

    // The same frame, z-up and of half the size, is no target of this face until it is laid over it.
    let mut foreign = String::from("target,landmark,ict_vertex,x,y,z\n");
    for row in targets.lines().filter(|row| row.starts_with("frame 1")) {
        let fields: Vec<&str> = row.split(',').collect();
        let [x, y, z] = [3, 4, 5].map(|k| 0.5 * fields[k].parse::<f64>().unwrap());
        foreign += &format!("frame 1,{},0,{x},{},{y}\n", fields[1], -z);
    }
    std::fs::write(at.join("foreign.csv"), foreign).unwrap();
    let fit_foreign = |more: &[&str]| {
        let mut all = vec!["fit", "small.json", "--targets", "foreign.csv", "--json"];
        all.extend([
            "--pictures",
            "none",
            "--write",
            "none",
            "--force",
            "--out",
            "foreign",
        ]);
        all.extend(more);
        let output = face_rig(at, &all);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), report["results"]["fits"][0].clone())
    };
    let (code, fit) = fit_foreign(&[]);
    let missed = fit["outcome"]["missed"].as_str().unwrap();
    assert_eq!(code, Some(1));
    assert!(
        missed.contains("scaled by 2.00") && missed.contains("--align"),
        "{missed}"
    );
    let (code, fit) = fit_foreign(&["--align"]);
    assert_eq!(code, Some(0), "{fit}");
    let scale = fit["alignment"]["scale"].as_f64().unwrap();
    assert!((scale - 2.0).abs() < 1e-3, "{scale}");
    assert!(fit["rms_after_mm"].as_f64().unwrap() < 0.3, "{fit}");

    let with = |from: &str, to: &str| std::fs::write(at.join("bad.csv"), targets.replace(from, to));
    let fit_bad = ["fit", "small.json", "--targets", "bad.csv", "--out", "bad"];
    with("frame 2", "../frame 2").unwrap();
    refused(
        at,
        &fit_bad,
        3,
        &["bad.csv", "line 70", "../frame 2", "letters"],
    );
    let mut millimeters = String::from("target,landmark,ict_vertex,x,y,z\n");
    for l in &face.landmarks {
        let [x, y, z] = l.point.position(face.mesh.nodes()).map(|v| 1e3 * v);
        millimeters += &format!("open,{},0,{x},{y},{z}\n", l.index);
    }
    std::fs::write(at.join("bad.csv"), millimeters).unwrap();
    refused(at, &fit_bad, 3, &["bad.csv", "line 2", "are these meters"]);
    with(",2\n", ",-2\n").unwrap();
    refused(at, &fit_bad, 3, &["bad.csv", "line 2", "weight -2"]);
    refused(
        at,
        &[
            "fit",
            "small.json",
            "--targets",
            "sequence.csv",
            "--target",
            "frame 1",
        ],
        4,
        &["--force"],
    );
    refused(
        at,
        &[
            "fit",
            "small.json",
            "--targets",
            "sequence.csv",
            "--target",
            "smile",
            "--out",
            "bad",
        ],
        3,
        &["small.json", "no target \"smile\""],
    );
    assert!(!at.join("bad").exists());
}

/// Flesh between two plates, of which the jaw's is pushed through the other: flat, so that it cannot
/// get out of the way.
const PRESSED: &str = r#"{ "name": "pressed",
  "face": { "files": {
    "mesh": "block.vtu", "bones": { "array": "bone", "free": 0, "cranium": 1, "jaw": 2 },
    "hinge": { "line": { "point": [0, 0.1, 0], "axis": [1, 0, 0] } },
    "muscles": { "names": { "list": ["pull"] }, "fibers": { "table": "fibers.csv" } } } },
  "material": { "preset": "soft_tissue" } }"#;

/// The three elements that a message names are those squashed most in the state, with their stress.
fn assert_worst(scene: &Scene, state: &MeshFile, message: &str) {
    let assembly = scene.assembly().unwrap();
    let x = assembly.positions(&state.points).unwrap();
    let mut ratios: Vec<(f64, usize)> = assembly
        .volume_ratios(x)
        .unwrap()
        .into_iter()
        .zip(0..)
        .collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let told = message.split("was solved: ").nth(1).unwrap();
    for (k, named) in told.split("element ").skip(1).take(3).enumerate() {
        let number = |after: &str| -> f64 {
            let text = named.split(after).nth(1).unwrap().trim_start();
            let end = text.find([',', ' ']).unwrap();
            text[..end].parse().unwrap()
        };
        let element: usize = named.split(' ').next().unwrap().parse().unwrap();
        let (ratio, stress) = (number("det F "), number(", "));
        assert!((ratio - ratios[k].0).abs() < 1e-3, "{k}: {message}");
        let own = ratios.iter().find(|(_, e)| *e == element).unwrap().0;
        assert!((ratio - own).abs() < 1e-3, "{k}: {message}");
        let material = &scene.regions[0].material;
        let stresses = assembly.deformation_gradients(element, x).unwrap();
        let expected = stresses.map(|by_rest| material.von_mises_stress(&by_rest).unwrap());
        let expected = 1e-3 * expected.fold(0.0, f64::max);
        assert!(
            (stress / expected - 1.0).abs() < 1e-2,
            "{k}: {expected} kPa, {message}"
        );
    }
}

#[test]
fn a_pose_without_equilibrium_leaves_the_last_state_that_has_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mesh = kuhn_grid(2, 2, 2, [0.08, 0.08, 0.02]).unwrap();
    let bone = mesh.nodes().iter().map(|x| match x[2] {
        0.0 => 1,
        z if z > 0.019 => 2,
        _ => 0,
    });
    let block = MeshFile::from_tets(&mesh).with_point_data(DataArray::integers("bone", bone));
    block.write(at.join("block.vtu")).unwrap();
    std::fs::write(
        at.join("fibers.csv"),
        "tet,muscle,weight,fx,fy,fz\n0,0,1,0,0,1\n",
    )
    .unwrap();
    std::fs::write(at.join("pressed.json"), PRESSED).unwrap();
    let shift = |millimeters: &str| {
        let quiet = ["--pictures", "none", "--write", "obj", "--out", "out"];
        let pose = ["simulate", "pressed.json", "--jaw-shift", millimeters];
        face_rig(at, &[&pose[..], &quiet].concat())
    };
    let output = shift("0,0,-22");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("last_state.vtu in out"), "{message}");
    // One screen: the step that was taken last, the worst elements, and what could help.
    assert!(message.lines().count() < 20, "{message}");
    for word in ["of Newton's", "Hessian", "to try: ", "squashed most"] {
        assert!(message.contains(word), "{word}: {message}");
    }
    // The flesh, whatever else was asked for, and no pose that was not found.
    assert_eq!(files(&at.join("out")), ["last_state.vtu"]);
    let percent = message.split("stuck ").nth(1).unwrap();
    let percent: f64 = percent.split(' ').next().unwrap().parse().unwrap();
    assert!((5.0..95.0).contains(&percent), "{message}");
    let state = MeshFile::read(at.join("out/last_state.vtu")).unwrap();
    assert_worst(
        &Scene::load(at.join("pressed.json")).unwrap(),
        &state,
        &message,
    );
    for (x, rest) in state.points.iter().zip(mesh.nodes()) {
        let plate = -22e-5 * percent;
        if rest[2] > 0.019 {
            // Percent are printed to a tenth.
            assert!((x[2] - rest[2] - plate).abs() < 22e-3 * 1e-3, "{x:?}");
        }
        assert!(rest[2] > 0.0 || x == rest, "{x:?}");
    }
    // Tilted, so that one side is squashed more than all else.
    let output = face_rig(
        at,
        &[
            "simulate",
            "pressed.json",
            "--jaw",
            "4deg",
            "--jaw-shift",
            "0,0,-24",
            "--pictures",
            "none",
            "--out",
            "tilted",
        ],
    );
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    let state = MeshFile::read(at.join("tilted/last_state.vtu")).unwrap();
    let scene = Scene::load(at.join("pressed.json")).unwrap();
    assert_worst(&scene, &state, &message);
}
