//! Files that are either written whole or not at all.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use tempfile::NamedTempFile;

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
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    // In the same folder, so that the rename stays on one file system.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let mut file = BufWriter::new(temporary_in(folder.unwrap_or(Path::new(".")))?);
    content(&mut file)?;
    let file = file.into_inner().map_err(|e| e.into_error())?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// [`write()`] for bytes at hand.
///
/// # Errors
/// Whatever the file system returns.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write(path, |file| file.write_all(bytes))
}

/// A temporary file with the permissions of any new file.
fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    #[cfg_attr(not(unix), expect(unused_mut))]
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
    #[cfg(unix)]
    fn a_new_file_has_the_permissions_of_any_other() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mode = |name: &str| {
            let path = folder.path().join(name);
            fs::metadata(path).expect("there").permissions().mode()
        };
        fs::write(folder.path().join("plain"), b"").expect("writable");
        write_bytes(&folder.path().join("whole"), b"").expect("writable");
        assert_eq!(mode("whole"), mode("plain"));
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert!(write_bytes(&folder.path().join("no/such/file"), b"").is_err());
        assert!(write_bytes(Path::new("/"), b"").is_err());
    }
}
