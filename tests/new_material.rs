//! A new material is one new file: a copy of the workspace gets it, a scene reaches it by name, and
//! the tables that `cargo xtask models` writes have a row for it.
#![allow(missing_docs)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// The new files and where they go.
const ADDED: [(&str, &str); 3] = [
    (
        "exponential_neo_hookean.rs",
        "crates/fem-materials/src/models",
    ),
    ("scene.rs", "crates/face-scenes/tests"),
    ("added_row.rs", "xtask/model-page/tests"),
];

#[test]
fn a_file_in_models_is_a_model_of_scenes() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    // In one place, so that a second run finds what the first has built.
    let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new_material");
    for name in ["Cargo.toml", "Cargo.lock", "crates", "xtask", "tests"] {
        mirror(&here.join("..").join(name), &copy.join(name)).expect("a copy");
    }
    for (file, place) in ADDED {
        mirror(
            &here.join("new_material").join(file),
            &copy.join(place).join(file),
        )
        .expect("a new file");
    }
    let mut cargo = Command::new(env::var_os("CARGO").expect("tests run under cargo"));
    cargo.current_dir(&copy);
    // With the features of the whole workspace everything that is not of it is built already.
    cargo.args(["test", "--offline", "--workspace"]);
    cargo.args(["--test", "scene", "--test", "added_row"]);
    cargo
        .env("CARGO_TARGET_DIR", build_folder())
        .env("CARGO_INCREMENTAL", "0");
    for name in [
        "fem-kinematics",
        "fem-solvers",
        "fem-assembly",
        "fem-catalog",
        "face-rig",
        "face-scenes",
    ] {
        cargo.args([
            "--config",
            &format!("profile.dev.package.{name}.opt-level=0"),
        ]);
    }
    let output = cargo.output().expect("cargo starts");
    let text = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned());
    assert!(output.status.success(), "{}", text.join("\n"));
    for test in [
        "a_scene_reaches_the_added_model",
        "the_page_of_models_gets_a_row_for_the_added_model",
    ] {
        let passed = text[0].contains(&format!("test {test} ... ok"));
        assert!(passed, "{test}: {}", text[0]);
    }
}

/// Where this test was built: `TARGET/debug/deps/new_material-...`.
fn build_folder() -> PathBuf {
    let program = env::current_exe().expect("a path");
    program
        .ancestors()
        .nth(3)
        .expect("a build folder")
        .to_owned()
}

/// Makes `to` a copy of `from`, but for the added files; what is the same already stays untouched.
fn mirror(from: &Path, to: &Path) -> io::Result<()> {
    if from.is_file() {
        let text = fs::read(from)?;
        if fs::read(to).is_ok_and(|known| known == text) {
            return Ok(());
        }
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder)?;
        }
        return fs::write(to, text);
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(to)? {
        let entry = entry?;
        let added = ADDED.iter().any(|(file, _)| entry.file_name() == *file);
        if !added && !from.join(entry.file_name()).exists() {
            if entry.file_type()?.is_dir() {
                fs::remove_dir_all(entry.path())?;
            } else {
                fs::remove_file(entry.path())?;
            }
        }
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        mirror(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}
