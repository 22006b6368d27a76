//! Lists `src/models/*.rs`, so that a new material is one new file and nothing else.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

fn main() {
    let folder =
        Path::new(&env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("src/models");
    // Absolute, so that a checkout that was moved lists its models anew.
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut names: Vec<String> = fs::read_dir(&folder)
        .expect("the folder of the models is part of the crate")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(".rs").map(str::to_owned))
        .filter(|name| name != "mod")
        .collect();
    names.sort();
    let mut code = String::new();
    for name in &names {
        let path = folder.join(format!("{name}.rs"));
        writeln!(code, "#[path = {path:?}]\nmod {name};\npub use {name}::*;").expect("a String");
    }
    code.push_str("/// Registers every model of this crate, file by file in alphabetical order.\n");
    code.push_str("pub(crate) fn register_all(visitor: &mut impl crate::registry::Register) {\n");
    for name in &names {
        writeln!(code, "    {name}::register(visitor);").expect("a String");
    }
    code.push_str("}\n");
    let out = Path::new(&env::var("OUT_DIR").expect("cargo sets it")).join("models.rs");
    fs::write(out, code).expect("the build folder can be written");
}
