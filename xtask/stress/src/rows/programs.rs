//! The program where it cannot write, where another run writes, and where it is killed.

use crate::row::Evidence;
use crate::{Expected, Failure, Row, program};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// A pose that is written in every way.
const POSE: [&str; 7] = [
    "simulate",
    "builtin:4000",
    "--set",
    "zygomaticus_major=0.3",
    "--out",
    "out",
    "--force",
];

/// The rows: they need the program, so they are part of long runs only.
pub fn rows() -> Vec<Row> {
    let row = |name: &str, what: &str, expected, run: fn(&Path) -> Result<Evidence, Failure>| {
        let run = move |_: &crate::Settings| {
            let folder = tempfile::tempdir().map_err(|e| Failure::trial(&e))?;
            run(folder.path())
        };
        Row::new("programs", name, what, expected, run).long()
    };
    let output = Expected::Error("exit 4");
    vec![
        row(
            "program-report-to-full-disk",
            "the report printed to a full disk",
            output,
            |at| {
                let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
                let full = full.map_err(|e| Failure::skipped(format!("/dev/full: {e}")))?;
                let mut command = program::command(at, &["check", "builtin:4000", "--json"])?;
                let child = program::spawn(command.stdout(full))?;
                ended(child)
            },
        ),
        row(
            "program-disk-full",
            "files of at most 4 KiB: no half file is left",
            output,
            |at| {
                let limits = "trap '' XFSZ; ulimit -f 8";
                let child = program::spawn(&mut program::limited(at, limits, &POSE)?)?;
                let result = ended(child);
                nothing_half(&at.join("out"))?;
                result
            },
        ),
        row(
            "program-read-only-folder",
            "results into a folder that nobody may write to",
            output,
            |at| {
                let mut arguments = POSE;
                arguments[5] = "/proc/face-rig-stress";
                ended(program::spawn(&mut program::command(at, &arguments)?)?)
            },
        ),
        row(
            "program-folder-is-a-file",
            "results into what is a file",
            output,
            |at| {
                std::fs::write(at.join("out"), "mine").map_err(|e| Failure::trial(&e))?;
                ended(program::spawn(&mut program::command(at, &POSE)?)?)
            },
        ),
        row(
            "program-memory-limit",
            "at most 64 MiB of memory: an end with a word, no wrong file",
            Expected::Property,
            little_memory,
        ),
        row(
            "program-twice-into-one-folder",
            "two runs at once into one folder: one writes, the other says so",
            Expected::Property,
            two_at_once,
        ),
        row(
            "program-kill-9",
            "killed 16 times on its way: every file is whole, and the next run writes",
            Expected::Property,
            killed,
        ),
    ]
}

fn ended(child: std::process::Child) -> Result<Evidence, Failure> {
    let output = child.wait_with_output().map_err(|e| Failure::trial(&e))?;
    program::ended(&output)?;
    Ok(Evidence::default())
}

/// The files of a folder with their bytes; hidden ones are those of a run that did not end.
fn files(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
    let mut files = BTreeMap::new();
    if !folder.is_dir() {
        return Ok(files);
    }
    for entry in std::fs::read_dir(folder).map_err(|e| Failure::trial(&e))? {
        let path = entry.map_err(|e| Failure::trial(&e))?.path();
        let name = path.file_name().and_then(|n| n.to_str());
        if let Some(name) = name.filter(|n| !n.starts_with('.')) {
            let bytes = std::fs::read(&path).map_err(|e| Failure::trial(&e))?;
            files.insert(name.to_owned(), bytes);
        }
    }
    Ok(files)
}

/// What an undisturbed run writes.
fn whole(at: &Path) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
    ended(program::spawn(&mut program::command(at, &POSE)?)?)?;
    files(&at.join("out"))
}

/// Same input, same bytes, but for the report, which holds times.
fn same(
    found: &BTreeMap<String, Vec<u8>>,
    whole: &BTreeMap<String, Vec<u8>>,
) -> Result<(), Failure> {
    for (name, bytes) in found {
        let good = if name == "report.json" {
            serde_json::from_slice::<serde_json::Value>(bytes).is_ok()
        } else {
            whole.get(name) == Some(bytes)
        };
        if !good {
            return Err(Failure::lie(format!(
                "{name} is not whole, {} bytes",
                bytes.len()
            )));
        }
    }
    Ok(())
}

/// Every file that is there is one of an undisturbed run.
fn nothing_half(folder: &Path) -> Result<(), Failure> {
    let other = tempfile::tempdir().map_err(|e| Failure::trial(&e))?;
    same(&files(folder)?, &whole(other.path())?)
}

fn little_memory(at: &Path) -> Result<Evidence, Failure> {
    let limits = "ulimit -v 65536";
    let child = program::spawn(&mut program::limited(at, limits, &POSE)?)?;
    let output = child.wait_with_output().map_err(|e| Failure::trial(&e))?;
    nothing_half(&at.join("out"))?;
    let message = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    if output.status.success() || message.is_empty() {
        return Err(Failure::lie(format!("{}: {message}", output.status)));
    }
    Ok(Evidence::holds(format!("{}: {message}", output.status)))
}

fn two_at_once(at: &Path) -> Result<Evidence, Failure> {
    let plain = &POSE[..6];
    let mut command = program::command(at, plain)?;
    let (one, two) = (program::spawn(&mut command)?, program::spawn(&mut command)?);
    let results = [ended(one), ended(two)];
    let other = tempfile::tempdir().map_err(|e| Failure::trial(&e))?;
    let (found, whole) = (files(&at.join("out"))?, whole(other.path())?);
    same(&found, &whole)?;
    let refused: Vec<&Failure> = results.iter().filter_map(|r| r.as_ref().err()).collect();
    match refused.as_slice() {
        [failure] if failure.kind == "exit 4" && found.len() == whole.len() => {
            Ok(Evidence::holds(failure.message.clone()))
        }
        _ => Err(Failure::lie(format!("{results:?}, {} files", found.len()))),
    }
}

fn killed(at: &Path) -> Result<Evidence, Failure> {
    let begin = Instant::now();
    let whole = whole(at)?;
    let whole_run = begin.elapsed();
    let (mut stopped, mut left) = (0, 0);
    for k in 0..16_u32 {
        let mut child = program::spawn(&mut program::command(at, &POSE)?)?;
        std::thread::sleep(
            whole_run
                .mul_f64(f64::from(k + 1) / 17.0)
                .max(Duration::from_millis(1)),
        );
        let _ = child.kill();
        let output = child.wait_with_output().map_err(|e| Failure::trial(&e))?;
        stopped += usize::from(!output.status.success());
        let found = files(&at.join("out"))?;
        same(&found, &whole)?;
        if found.len() != whole.len() {
            return Err(Failure::lie(format!(
                "{} of {} files",
                found.len(),
                whole.len()
            )));
        }
    }
    for entry in std::fs::read_dir(at.join("out")).map_err(|e| Failure::trial(&e))? {
        let name = entry.map_err(|e| Failure::trial(&e))?.file_name();
        left += usize::from(name.to_string_lossy().starts_with('.'));
    }
    ended(program::spawn(&mut program::command(at, &POSE)?)?)?;
    Ok(Evidence::holds(format!(
        "{stopped} runs killed, {left} hidden files left by them"
    )))
}
