//! `cargo xtask COMMAND`: builds and runs the program of `xtask/verification`.
//!
//! What measures or takes long runs optimized. `verify --quick` runs in the profile of the tests:
//! next to them little is left to build. The kernels give the same bits in both. `tidy` reads the
//! sources and builds nothing. `models` writes the tables of `docs/models.md`.

mod tidy;

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

/// The exit code of the program; 2 where it could not be built, started or ended.
fn main() -> ExitCode {
    let arguments: Vec<OsString> = env::args_os().skip(1).collect();
    if arguments.first().is_some_and(|a| a == "tidy") {
        return tidy_up();
    }
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    if arguments.first().is_some_and(|a| a == "models") {
        command.args(["run", "--quiet", "--package", "model-page"]);
    } else {
        command.args(["run", "--package", "verification"]);
        if is_long(&arguments) {
            command.arg("--release");
        }
        command.arg("--").args(&arguments);
    }
    match command.status() {
        Ok(status) => match status.code() {
            Some(code @ (0 | 1)) => ExitCode::from(code as u8),
            _ => ExitCode::from(2),
        },
        Err(error) => {
            eprintln!("error: cargo cannot be started: {error}");
            ExitCode::from(2)
        }
    }
}

/// Prints what breaks an invariant of `ARCHITECTURE.md`; the exit code is 1 if anything does.
fn tidy_up() -> ExitCode {
    let found = tidy::problems(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    for problem in &found {
        eprintln!("{problem}");
    }
    println!("tidy: {} invariants broken", found.len());
    ExitCode::from(u8::from(!found.is_empty()))
}

fn is_long(arguments: &[OsString]) -> bool {
    let has = |name: &str| arguments.iter().any(|a| a == name);
    let help = has("--help") || has("-h");
    match arguments.first().and_then(|a| a.to_str()) {
        Some("bench" | "stress") => !help,
        Some("verify") => !help && !has("--quick"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::is_long;
    use std::ffi::OsString;

    #[test]
    fn what_is_quick_is_not_optimized_and_what_measures_is() {
        let line = |text: &str| -> Vec<OsString> { text.split(' ').map(OsString::from).collect() };
        for long in ["verify", "verify --scenes shared", "bench twist", "stress"] {
            assert!(is_long(&line(long)), "{long}");
        }
        for short in [
            "verify --quick",
            "--help",
            "bench --help",
            "verify -h",
            "nonsense",
        ] {
            assert!(!is_long(&line(short)), "{short}");
        }
    }
}
