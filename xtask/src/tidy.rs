//! `cargo xtask tidy`: the invariants of `ARCHITECTURE.md` that can be read off the sources.

use std::fs;
use std::path::{Path, PathBuf};

/// Each crate and the crates of this workspace that it may depend on.
const ARROWS: &[(&str, &[&str])] = &[
    ("fem-kinematics", &[]),
    ("fem-materials", &["fem-kinematics"]),
    ("fem-solvers", &["fem-kinematics"]),
    (
        "fem-assembly",
        &["fem-kinematics", "fem-materials", "fem-solvers"],
    ),
    (
        "aniso-mpm",
        &["fem-kinematics", "fem-materials", "fem-solvers"],
    ),
    (
        "face-rig",
        &[
            "fem-kinematics",
            "fem-materials",
            "fem-solvers",
            "fem-assembly",
        ],
    ),
    (
        "fem-catalog",
        &[
            "fem-kinematics",
            "fem-materials",
            "fem-solvers",
            "fem-assembly",
        ],
    ),
    (
        "face-scenes",
        &[
            "fem-kinematics",
            "fem-materials",
            "fem-solvers",
            "fem-assembly",
            "fem-catalog",
            "face-rig",
        ],
    ),
    (
        "face-pictures",
        &["fem-kinematics", "fem-solvers", "fem-assembly"],
    ),
    (
        "face-cli",
        &[
            "fem-kinematics",
            "fem-materials",
            "fem-solvers",
            "fem-assembly",
            "face-rig",
            "face-scenes",
            "face-pictures",
        ],
    ),
];

/// Words that code of `fem-solvers` has no use for.
const FEM_WORDS: [&str; 9] = [
    "mesh",
    "element",
    "material",
    "muscle",
    "fiber",
    "tetrahedron",
    "stress",
    "strain",
    "deformation",
];

/// Longest source file, lines.
const LONGEST: usize = 600;

/// Longest function, lines: it reads like the method that it is. Tables of letters and of warnings are none.
const LONGEST_FUNCTION: usize = 65;
const TABLES: [&str; 2] = [
    "crates/face-pictures/src/font.rs",
    "crates/face-scenes/src/warning.rs",
];

/// Everything that breaks an invariant, one sentence each.
pub fn problems(root: &Path) -> Vec<String> {
    let mut found = Vec::new();
    arrows(root, &mut found);
    for path in sources(&root.join("crates")) {
        let Ok(text) = fs::read_to_string(&path) else {
            found.push(format!("{}: not readable as text", path.display()));
            continue;
        };
        let name = path.strip_prefix(root).unwrap_or(&path);
        let name = name.to_string_lossy().replace('\\', "/");
        file(&name, &text, &mut found);
    }
    found
}

fn arrows(root: &Path, found: &mut Vec<String>) {
    let Ok(folder) = fs::read_dir(root.join("crates")) else {
        found.push("there is no folder `crates`".to_owned());
        return;
    };
    let all: Vec<&str> = ARROWS.iter().map(|(name, _)| *name).collect();
    for entry in folder.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Ok(manifest) = fs::read_to_string(entry.path().join("Cargo.toml")) else {
            continue;
        };
        let Some((_, allowed)) = ARROWS.iter().find(|(known, _)| *known == name) else {
            found.push(format!(
                "{name} has no row in ARROWS (xtask/src/tidy.rs): say what it may depend on"
            ));
            continue;
        };
        let (library, _) = manifest
            .split_once("[dev-dependencies]")
            .unwrap_or((&manifest, ""));
        for other in &all {
            // What draws and writes meshes may serve the examples of any crate.
            let used = match *other {
                "face-pictures" | "fem-assembly" => library,
                _ => &manifest,
            };
            if *other != name && depends(used, other) && !allowed.contains(other) {
                found.push(format!("{name} depends on {other}, which lies above it"));
            }
        }
        for above in ["model-page", "verification", "workbench", "xtask"] {
            if depends(&manifest, above) {
                found.push(format!("{name} depends on {above}, which lies above it"));
            }
        }
    }
}

/// Does a manifest name `crate_name` as a dependency, in any of the ways to write it?
fn depends(manifest: &str, crate_name: &str) -> bool {
    manifest.lines().any(|line| {
        let line = line.trim();
        let renamed = line.contains(&format!("package = \"{crate_name}\""));
        let table = line.starts_with('[') && line.ends_with(&format!("dependencies.{crate_name}]"));
        let rest = line.strip_prefix(crate_name).map(str::trim_start);
        renamed || table || rest.is_some_and(|rest| rest.starts_with(['.', '=']))
    })
}

/// Every Rust source below a folder, in a fixed order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Checks one file by its name from the root and its text.
fn file(name: &str, text: &str, found: &mut Vec<String>) {
    let lines = text.lines().count();
    if lines > LONGEST {
        found.push(format!("{name}: {lines} lines, more than {LONGEST}"));
    }
    let in_tests = !name.contains("/src/") || name.ends_with("tests.rs");
    let in_library =
        !in_tests && !name.starts_with("crates/face-cli/") && !name.ends_with("/main.rs");
    let library = text.split("#[cfg(test)]\nmod ").next().unwrap_or(text);
    for (number, line) in text.lines().enumerate() {
        let at = || format!("{name}:{}", number + 1);
        if line.contains(concat!("to", "do!(")) || line.contains(concat!("unimple", "mented!(")) {
            found.push(format!("{}: a stub", at()));
        }
        if ["home", "root", "tmp", "work"]
            .iter()
            .any(|folder| line.contains(&format!("\"/{folder}/")))
        {
            found.push(format!("{}: an absolute path", at()));
        }
        let allows = line.contains("allow(unsafe_code)");
        if allows && !name.starts_with("crates/fem-kinematics/src/dispatch/") {
            found.push(format!("{}: unsafe code belongs to dispatch", at()));
        }
    }
    if !in_tests && !TABLES.contains(&name) {
        for (number, lines) in functions(library).filter(|f| f.1 > LONGEST_FUNCTION) {
            found.push(format!(
                "{name}:{number}: a function of {lines} lines, more than {LONGEST_FUNCTION}"
            ));
        }
    }
    if !in_library {
        return;
    }
    for (number, line) in library.lines().enumerate() {
        let code = line.trim_start();
        if !code.starts_with("//") {
            library_line(name, number, code, found);
        }
    }
}

/// Checks a line of code of a library.
fn library_line(name: &str, number: usize, code: &str, found: &mut Vec<String>) {
    let at = || format!("{name}:{}", number + 1);
    let constant = code.starts_with("const ") || code.starts_with("static ");
    let panics = [".unwrap()", ".expect(", "panic!("]
        .iter()
        .any(|p| code.contains(p));
    if panics && !constant {
        found.push(format!("{}: library code that can panic", at()));
    }
    let clock = code.contains("Instant") || code.contains("SystemTime");
    let excepted = [
        "crates/face-rig/src/stopwatch.rs",
        "crates/fem-materials/src/conformance/random.rs",
    ];
    if clock && !excepted.iter().any(|e| name.starts_with(e)) {
        found.push(format!("{}: reads a clock", at()));
    }
    if has_word(code, "rayon")
        && !code.starts_with("#[cfg(")
        && name != "crates/fem-solvers/src/parallel.rs"
    {
        found.push(format!("{}: spreads tasks past `parallel`", at()));
    }
    if name.starts_with("crates/fem-solvers/")
        && let Some(word) = FEM_WORDS.iter().find(|w| has_word(code, w))
    {
        found.push(format!("{}: `{word}` is no word of a solver", at()));
    }
    if code.contains("register(visitor") && !name.starts_with("crates/fem-materials/src/models") {
        found.push(format!("{}: registers a model by hand", at()));
    }
}

/// The line, from 1, and the number of lines of every function with a body.
fn functions(text: &str) -> impl Iterator<Item = (usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    (0..lines.len()).filter_map(move |start| {
        let line = lines[start];
        let indent = &line[..line.len() - line.trim_start().len()];
        let mut words = line.split_whitespace().take_while(|w| !w.contains('='));
        if line.trim_start().starts_with("//") || !words.any(|word| word == "fn") {
            return None;
        }
        let rest = &lines[start..];
        let head = rest.iter().position(|l| l.ends_with(['{', ';', '}']))?;
        if !rest[head].ends_with('{') {
            return None;
        }
        let end = rest
            .iter()
            .position(|l| l.strip_prefix(indent) == Some("}"))?;
        Some((start + 1, end + 1))
    })
}

/// Does `word` or its plural stand in the code, alone or as a part of a snake_case name?
fn has_word(code: &str, word: &str) -> bool {
    code.split(|c: char| !c.is_alphanumeric())
        .map(str::to_lowercase)
        .any(|part| {
            [
                part.as_str(),
                part.trim_end_matches('s'),
                part.trim_end_matches("es"),
            ]
            .contains(&word)
        })
}

#[cfg(test)]
mod tests {
    use super::{depends, file, problems};
    use std::path::Path;

    #[test]
    fn the_workspace_keeps_its_invariants() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let found = problems(&root);
        assert!(found.is_empty(), "\n{}", found.join("\n"));
    }

    /// A method that takes so many lines, from `fn` to its last brace.
    fn function_of(lines: usize) -> String {
        let body = "        x();\n".repeat(lines - 3);
        format!("    pub fn long(\n    ) {{\n{body}    }}")
    }

    #[test]
    fn what_breaks_an_invariant_is_found() {
        for (name, text) in [
            ("crates/fem-solvers/src/a.rs", "let mesh = 1;"),
            ("crates/fem-solvers/src/a.rs", "fn nodal_stresses() {}"),
            (
                "crates/fem-assembly/src/a.rs",
                "let t = std::time::Instant::now();",
            ),
            (
                "crates/fem-materials/src/conformance/mod.rs",
                "let t = std::time::SystemTime::now();",
            ),
            ("crates/fem-assembly/src/a.rs", "let x = y.unwrap();"),
            ("crates/face-rig/src/a.rs", "use rayon::prelude::*;"),
            ("crates/face-rig/src/a.rs", &function_of(66)),
            ("crates/face-cli/src/a.rs", &function_of(66)),
            ("crates/fem-assembly/src/a.rs", "#![allow(unsafe_code)]"),
            ("crates/fem-materials/src/a.rs", "hooke::register(visitor);"),
            ("crates/face-rig/src/a.rs", concat!("to", "do!()")),
            (
                "crates/face-rig/src/a.rs",
                concat!("let p = \"/", "tmp/x\";"),
            ),
        ] {
            let mut found = Vec::new();
            file(name, text, &mut found);
            assert_eq!(found.len(), 1, "{text}: {found:?}");
        }
        let mut found = Vec::new();
        let fine = "// a mesh is none of ours\nlet x = y.unwrap_or(0);\n";
        file("crates/fem-solvers/src/a.rs", fine, &mut found);
        file("crates/face-rig/src/a.rs", &function_of(65), &mut found);
        file("crates/face-rig/tests/a.rs", &function_of(66), &mut found);
        file("crates/fem-solvers/src/a.rs", &"\n".repeat(601), &mut found);
        assert_eq!(found.len(), 1, "{found:?}");
    }

    #[test]
    fn a_dependency_is_seen_however_it_is_written() {
        for line in [
            "face-rig.workspace = true",
            "face-rig = { path = \"../face-rig\" }",
            "face-rig={ workspace = true }",
            "[dev-dependencies.face-rig]",
            "rig = { package = \"face-rig\", path = \"../face-rig\" }",
        ] {
            assert!(depends(line, "face-rig"), "{line}");
        }
        assert!(!depends("face-rigging.workspace = true", "face-rig"));
        assert!(!depends("name = \"face-rig\"", "face-rig"));
    }
}
