//! The built program, run as its user runs it.

use crate::Failure;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;

/// Builds the program once, optimized.
///
/// # Errors
/// [`Failure::skipped`] where cargo cannot.
pub fn path() -> Result<&'static Path, Failure> {
    static PROGRAM: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let found = PROGRAM.get_or_init(build).as_ref();
    found.map(PathBuf::as_path).map_err(Failure::skipped)
}

fn build() -> Result<PathBuf, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        // With the package that is running: what it shares with the program is built already.
        .args(["build", "--quiet", "--release", "--message-format=json"])
        .args(["--package", "verification", "--package", "face-cli"])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .stderr(Stdio::null())
        .output()
        .map_err(|e| format!("cargo cannot be started: {e}"))?;
    let text = String::from_utf8_lossy(&built.stdout);
    let messages = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    let executable = |m: serde_json::Value| {
        let is_it = m["target"]["name"] == "face-rig";
        Some(PathBuf::from(m["executable"].as_str().filter(|_| is_it)?))
    };
    let mut programs = messages.filter_map(executable);
    let program = programs.next_back();
    program.ok_or_else(|| "the program face-rig cannot be built".to_owned())
}

/// A command in a folder.
pub fn command(folder: &Path, arguments: &[&str]) -> Result<Command, Failure> {
    let mut command = Command::new(path()?);
    command.args(arguments).current_dir(folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    Ok(command)
}

/// The same under a shell's limits, such as `ulimit -f 8`.
pub fn limited(folder: &Path, limits: &str, arguments: &[&str]) -> Result<Command, Failure> {
    let mut command = Command::new("sh");
    let line = format!("{limits}; exec \"$0\" \"$@\"");
    command.args(["-c", &line]).arg(path()?).args(arguments);
    command.current_dir(folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    Ok(command)
}

/// Starts it.
pub fn spawn(command: &mut Command) -> Result<Child, Failure> {
    command.spawn().map_err(|e| Failure::trial(&e))
}

/// How a run ended: its exit code is the kind of a failure, `exit 4`; a panic or a signal is a lie.
pub fn ended(output: &Output) -> Result<(), Failure> {
    let message = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    if message.contains("panicked") {
        return Err(Failure::lie(message));
    }
    match output.status.code() {
        Some(0) => Ok(()),
        Some(code) => Err(Failure::new(format!("exit {code}"), message)),
        None => Err(Failure::lie(format!(
            "ended by a signal: {}",
            output.status
        ))),
    }
}
