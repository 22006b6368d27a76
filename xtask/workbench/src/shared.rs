//! Where the reference data lies: beside the repository, never inside it.

use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// The repository: the folder above this crate that holds the others.
fn repository() -> Option<&'static Path> {
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    above.find(|folder| folder.join("crates").is_dir())
}

/// The folder with the reference data: `FEM_SHARED` where it is set, else `shared` beside the
/// repository; nothing where there is no such folder.
pub fn folder() -> Option<PathBuf> {
    let folder = match std::env::var_os("FEM_SHARED") {
        Some(folder) => PathBuf::from(folder),
        None => repository()?.parent()?.join("shared"),
    };
    folder.is_dir().then_some(folder)
}

/// The given folder, whatever it is, else `part` of the reference data; says so where there is
/// neither.
pub fn folder_or_skip(given: Option<&Path>, part: &str) -> Option<PathBuf> {
    if let Some(given) = given {
        return Some(given.to_path_buf());
    }
    let found = folder()
        .map(|shared| shared.join(part))
        .filter(|path| path.is_dir());
    if found.is_none() {
        eprintln!("skipped: no folder with {part} here (set FEM_SHARED or name one)");
    }
    found
}

/// Why a reference file could not be used.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file can't be opened.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file has another format.
    #[error("{path}: {source}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What and where.
        source: serde_json::Error,
    },
}

/// Reads a JSON file.
///
/// # Errors
/// If it can't be opened or doesn't have the expected form; the message names file, line and field.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, ReadError> {
    let text = std::fs::read_to_string(path).map_err(|source| ReadError::Io {
        path: path.to_path_buf(),
        source,
    })?;
    serde_json::from_str(&text).map_err(|source| ReadError::Format {
        path: path.to_path_buf(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_repository_is_where_the_workspace_begins() {
        let root = repository().expect("this crate lies in the repository");
        assert!(root.join("Cargo.toml").is_file() && root.join("docs").is_dir());
        assert!(root.join("xtask/workbench/src/shared.rs").is_file());
    }

    #[test]
    fn a_folder_that_was_named_is_taken_at_its_word() {
        let named = Path::new("no such folder");
        assert_eq!(folder_or_skip(Some(named), "reference"), Some(named.into()));
    }
}
