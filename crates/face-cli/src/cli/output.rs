//! The folder of results: refused when it holds files, each file written whole or not at all.

use super::args::{Format, OutputArgs, Pictures};
use super::clock::Clock;
use super::error::Failure;
use super::shape_files::{self, Fields};
use face_pictures::export::write_atomically;
use face_rig::rig::{Parameters, Rig};
use face_scenes::Scene;
use serde_json::{Value, json};
use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Locked while a run writes to the folder. The system takes the lock away from a run that was killed.
const LOCK: &str = ".face-rig.lock";

/// An output folder that may be written to, by nobody else until this is dropped.
pub struct Output {
    folder: PathBuf,
    _lock: Lock,
    clock: Clock,
    files: Vec<String>,
    pub formats: Vec<Format>,
    pub pictures: Pictures,
}

impl Output {
    /// Checks before any work is done that the results will have a place.
    pub fn prepare(args: &OutputArgs, clock: Clock) -> Result<Self, Failure> {
        let folder = args.out.clone();
        let cannot = |source| Failure::Output {
            path: folder.clone(),
            source,
        };
        std::fs::create_dir_all(&folder).map_err(cannot)?;
        let lock = Lock::take(&folder)?;
        let mut entries = std::fs::read_dir(&folder).map_err(cannot)?;
        let holds_files =
            entries.any(|entry| entry.map_or(true, |entry| entry.file_name() != LOCK));
        if holds_files && !args.force {
            return Err(Failure::OutputExists(folder));
        }
        Ok(Self {
            folder,
            _lock: lock,
            clock,
            files: Vec::new(),
            formats: args.write.clone(),
            pictures: args.pictures,
        })
    }

    /// From now on time counts to this phase of the report.
    pub fn enter(&mut self, phase: &str) {
        self.clock.enter(phase);
    }

    /// The path of a file in the folder, remembered for the report.
    pub fn path(&mut self, name: &str) -> PathBuf {
        self.files.push(name.into());
        self.folder.join(name)
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes `report.json` with what every report has: program, settings, times, files. What comes
    /// after it, this file and what the user is told, is in no phase.
    pub fn report(
        &mut self,
        command: &str,
        settings: Value,
        results: Value,
    ) -> Result<Value, Failure> {
        let path = self.path("report.json");
        let phases = self.clock.seconds();
        let seconds: f64 = phases.iter().map(|p| p.1).sum();
        let phases = phases.into_iter().map(|(name, s)| (name.into(), json!(s)));
        let phases: serde_json::Map<String, Value> = phases.collect();
        let report = json!({
            "program": "face-rig",
            "version": env!("CARGO_PKG_VERSION"),
            "command": command,
            "settings": settings,
            "threads": rayon::current_num_threads(),
            "seconds": seconds,
            "phase_seconds": phases,
            "results": results,
            "files": self.files,
        });
        write_atomically(&path, serde_json::to_string_pretty(&report)?.as_bytes())?;
        Ok(report)
    }

    /// The flesh as VTU with displacement, det F, fiber stretch and activation; the skin as OBJ and
    /// glTF, whose morph target leads from rest to the pose. Only what was asked for.
    pub fn write_shape(
        &mut self,
        name: &str,
        scene: &Scene,
        rig: &Rig,
        parameters: &Parameters,
        positions: &[[f64; 3]],
    ) -> Result<(), Failure> {
        let formats = &self.formats;
        let fields = Fields::of(formats, scene, rig, parameters, positions)?;
        let files = shape_files::write(
            &self.folder,
            formats,
            name,
            scene,
            fields.as_ref(),
            positions,
        );
        self.files.extend(files?);
        Ok(())
    }

    /// Remembers files that were written elsewhere.
    pub fn wrote(&mut self, files: impl IntoIterator<Item = String>) {
        self.files.extend(files);
    }
}

/// The lock of a folder; the file goes with it.
struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    fn take(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(LOCK);
        let cannot = |source| Failure::Output {
            path: path.clone(),
            source,
        };
        let file = File::create(&path).map_err(cannot)?;
        match file.try_lock() {
            Ok(()) => Ok(Self { path, _file: file }),
            Err(TryLockError::WouldBlock) => Err(Failure::OutputBusy(folder.to_path_buf())),
            // Some network file systems know no locks.
            Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => {
                Ok(Self { path, _file: file })
            }
            Err(TryLockError::Error(e)) => Err(cannot(e)),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // One that stays behind is locked by nobody and counts as no result.
        std::fs::remove_file(&self.path).ok();
    }
}

/// Writes a line to the standard output. A reader who has seen enough and closed it is no failure.
///
/// # Errors
/// When it cannot be written for another reason.
pub fn say(text: impl std::fmt::Display) -> Result<(), Failure> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::StandardOutput(e)),
        _ => Ok(()),
    }
}
