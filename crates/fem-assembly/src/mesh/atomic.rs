//! Files that are either written whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes a file under a temporary name beside `path` and renames it once everything is on disk,
/// so that a failure leaves whatever was at `path` untouched and no half-written file behind.
///
/// ```
/// use std::io::Write;
/// let folder = std::env::temp_dir();
/// let path = folder.join("fem_assembly_atomic_example.txt");
/// fem_assembly::mesh::atomic::write(&path, |file| writeln!(file, "whole"))?;
/// assert_eq!(std::fs::read_to_string(&path)?, "whole\n");
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// Whatever `content` or the file system returns.
pub fn write(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let temporary = temporary_name(path)?;
    let result = (|| {
        let mut file = BufWriter::new(File::create_new(&temporary)?);
        content(&mut file)?;
        file.into_inner().map_err(|e| e.into_error())?.sync_all()?;
        fs::rename(&temporary, path)
    })();
    if result.is_err() {
        // The first error is the one worth telling; the leftover may not even exist.
        let _ = fs::remove_file(&temporary);
    }
    result
}

/// [`write()`] for bytes at hand.
///
/// # Errors
/// Whatever the file system returns.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write(path, |file| file.write_all(bytes))
}

/// A name in the same folder, so that the rename stays on one file system.
fn temporary_name(path: &Path) -> io::Result<PathBuf> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or_else(|| {
        let message = format!("{} names no file", path.display());
        io::Error::new(io::ErrorKind::InvalidInput, message)
    })?;
    let serial = COUNTER.fetch_add(1, Ordering::Relaxed);
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}-{serial}.tmp", std::process::id()));
    Ok(path.with_file_name(temporary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("out.txt");
        write_bytes(&path, b"old").expect("writable");
        let failed = write(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::other("the disk is full"))
        });
        assert_eq!(
            failed.map_err(|e| e.to_string()),
            Err("the disk is full".into())
        );
        assert_eq!(fs::read(&path).expect("still there"), b"old");
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
        write_bytes(&path, b"new").expect("writable");
        assert_eq!(fs::read(&path).expect("there"), b"new");
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert!(write_bytes(&folder.path().join("no/such/file"), b"").is_err());
        assert!(write_bytes(Path::new("/"), b"").is_err());
    }
}
