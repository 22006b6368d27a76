//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writing a file failed; the file at the path is as it was before.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {step}: {source}", path.display())]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// What was being done.
    pub step: &'static str,
    /// The system's reason.
    pub source: io::Error,
}

/// Writes `bytes` to a temporary name in the same folder, flushes it to disk and renames it, so
/// that a reader, or a crash, never meets half a file. An existing file is replaced.
///
/// # Errors
/// [`WriteError`] naming the path; the temporary file is removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let fail = |step| {
        move |source| WriteError {
            path: path.to_path_buf(),
            step,
            source,
        }
    };
    let Some(name) = path.file_name() else {
        let reason = io::Error::new(io::ErrorKind::InvalidInput, "the path has no file name");
        return Err(fail("choosing a name")(reason));
    };
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let (temporary, mut file) = create_beside(folder, &name.to_string_lossy())
        .map_err(fail("creating a temporary file"))?;
    let finished = file
        .write_all(bytes)
        .and_then(|()| file.sync_all())
        .map_err(fail("writing the temporary file"))
        .and_then(|()| {
            drop(file);
            fs::rename(&temporary, path).map_err(fail("renaming the temporary file"))
        });
    if finished.is_err() {
        // The first error is the one to report; a leftover is the worst that can follow.
        let _ = fs::remove_file(&temporary);
    }
    finished
}

fn create_beside(folder: &Path, name: &str) -> io::Result<(PathBuf, File)> {
    let process = std::process::id();
    for attempt in 0..64u32 {
        let temporary = folder.join(format!(".{name}.{process}.{attempt}.part"));
        match File::options()
            .write(true)
            .create_new(true)
            .open(&temporary)
        {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            other => return other.map(|file| (temporary, file)),
        }
    }
    Err(io::Error::new(
        io::ErrorKind::AlreadyExists,
        "64 temporary names are taken",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_is_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn failures_name_the_path_and_leave_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/such/a.txt");
        let error = write_atomically(&missing, b"x").unwrap_err();
        assert!(error.to_string().contains("a.txt"), "{error}");
        let taken = folder.path().join("folder");
        fs::create_dir(&taken).unwrap();
        let error = write_atomically(&taken, b"x").unwrap_err();
        assert_eq!(error.step, "renaming the temporary file");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write_atomically(Path::new("/"), b"x").is_err());
    }
}
