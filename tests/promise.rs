//! No test believes a solve: what is `Ok` there was summed again by `promise.rs` of the crates, or by
//! `fit_promise.rs` for least squares, which stand for what solves. Tests reach that by a name alone, so
//! names are what this reads.
#![allow(missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};

/// Folders with tests that solve, and single files that do.
const TESTED: [&str; 9] = [
    "crates/fem-solvers/tests",
    "crates/fem-assembly/tests",
    "crates/fem-assembly/src/portable_tests.rs",
    "crates/fem-assembly/examples/inertia.rs",
    "crates/face-rig/tests",
    "crates/face-scenes/tests",
    "crates/face-scenes/src/tests",
    "crates/face-cli/tests",
    "xtask/workbench/src",
];

/// What solves, by crate.
const SOLVE: [(&str, &[&str]); 3] = [
    (
        "fem_solvers",
        &["Newton", "gauss_newton", "gauss_newton_observed"],
    ),
    ("fem_assembly", &["solve_renewing", "solve_walking"]),
    ("face_rig", &["Rig"]),
];

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// What of a test is not checked: an import of what solves, or its full path or a scene's rig that is not
/// handed on at once.
fn believed(text: &str) -> Vec<String> {
    let handed_on = |at: usize| {
        let start = text[..at].rfind(['{', ';']).unwrap_or(0);
        text[start..at].contains("Rig::of(")
    };
    let mut found = Vec::new();
    for (krate, names) in SOLVE {
        for (at, _) in text.match_indices(&format!("{krate}::")) {
            let end = text[at..].find(';').map_or(text.len(), |end| at + end);
            // A path ends with its expression, a list of imports with its statement.
            if handed_on(at) {
                continue;
            }
            let is_import = text[..at].trim_end().ends_with("use");
            let path = text[at..end].find(|c: char| !is_word(c) && c != ':');
            let end = if is_import {
                end
            } else {
                path.map_or(end, |length| at + length)
            };
            let words = text[at..end].split(|c| !is_word(c));
            found.extend(words.filter(|w| names.contains(w)).map(str::to_owned));
            if is_import && text[at..end].contains('*') {
                found.push(format!("{krate}::*"));
            }
        }
    }
    for (at, _) in text.match_indices(".rig(") {
        if !handed_on(at) {
            found.push(".rig(".to_owned());
        }
    }
    found
}

fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    if folder.is_file() {
        all.push(folder.to_owned());
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, all);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
}

#[test]
fn no_test_believes_a_solve() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (mut all, mut checked) = (Vec::new(), 0);
    for tested in TESTED {
        let before = all.len();
        files(&root.join(tested), &mut all);
        assert!(all.len() > before, "nothing at {tested}");
    }
    for file in all {
        if ["promise.rs", "fit_promise.rs"]
            .iter()
            .any(|checks| file.ends_with(checks))
        {
            continue;
        }
        let text = fs::read_to_string(&file).expect("readable");
        checked += usize::from(text.contains("promise::"));
        let mut believed = believed(&text);
        // The end of this fit is compared with another's, whatever it calls itself.
        let compared =
            file.ends_with("workbench/src/scenes/fit.rs") && text.contains("let _ = gauss_newton(");
        believed.retain(|what| !(compared && what == "gauss_newton"));
        assert!(
            believed.is_empty(),
            "{}: {believed:?} is not checked; take that of `promise`",
            file.display()
        );
    }
    assert!(checked > 20, "{checked} files with a checked solve");
}

#[test]
fn a_belief_is_seen_however_it_is_written() {
    for text in [
        "use fem_solvers::Newton;",
        "use fem_solvers::{\n    LinearSolver,\n    Newton, NewtonParams,\n};",
        "let info = fem_solvers::Newton::new(&problem).solve(&problem, &mut x, &params);",
        "use fem_assembly::{Assembly, solve_walking};",
        "fem_assembly::solve_renewing(&mut body, &mut newton, start, &[], &params)",
        "use face_rig::rig::{Parameters, Rig, RigParams};",
        "let rig = face_rig::rig::Rig::new(assembly, &jaw, params);",
        "use fem_solvers::*;",
        "use fem_solvers::{Damping, gauss_newton};",
        "let mut rig = scene.rig(RigParams::default()).unwrap();",
    ] {
        assert_eq!(believed(text).len(), 1, "{text}");
    }
    for text in [
        "use fem_solvers::{NewtonParams, StopReason};",
        "use face_rig::rig::{RigError, RigParams};",
        "use crate::promise::{Newton, solve_renewing};",
        "let mut rig = Rig::of(scene.rig(params).unwrap(), params);",
        "let rig = Rig::of(face_rig::rig::Rig::new(flesh, &jaw, loose).unwrap(), params);",
    ] {
        assert!(believed(text).is_empty(), "{text}");
    }
}
