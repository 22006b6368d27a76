//! Instructions of a scene's smallest run, counted by valgrind: a number that no other program on
//! the machine can change.

use crate::failure::Failure;
use std::process::Command;

/// What the program is given to run a scene's smallest case and nothing else.
pub const ALONE: &str = "--alone";

/// Counts them on one thread; nothing where there is no valgrind.
///
/// # Errors
/// If the run fails, or valgrind says nothing that is understood.
pub fn count(scene: &str) -> Result<Option<u64>, Failure> {
    let program = std::env::current_exe()?;
    let mut command = Command::new("valgrind");
    command
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(["bench", scene, ALONE, "--threads", "1"])
        .env("RAYON_NUM_THREADS", "1");
    let output = match command.output() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        output => output?,
    };
    let told = String::from_utf8_lossy(&output.stderr);
    match (output.status.success(), collected(&told)) {
        (true, Some(count)) => Ok(Some(count)),
        _ => Err(Failure::Failed(
            format!("valgrind could not count {scene}: {told}").into(),
        )),
    }
}

/// `==123== Collected : 456`
pub fn collected(told: &str) -> Option<u64> {
    let line = told.lines().find(|l| l.contains("Collected :"))?;
    line.rsplit(' ').next()?.replace(',', "").parse().ok()
}
