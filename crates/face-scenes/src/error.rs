//! What can be wrong with a scene.

use super::defect::{Defect, Location};
use super::json;
use fem_assembly::mesh::MeshFileError;
use std::path::{Path, PathBuf};

/// Why a scene cannot be used. Every message names the file, the place in it, and the cure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file is missing or cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A JSON file does not have the form it should.
    #[error("{}:{line}:{column}: {}", path.display(), json::Said { field, source: &**source })]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The field's path, like `bones.jaw`; `None` for the whole file.
        field: Option<String>,
        /// What the reader of JSON says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A field of the scene file, or an entry of a file it names, does not fit the rest.
    #[error("{}: {location}: {defect}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The field, or the line or entry.
        location: Location,
        /// What is wrong and what to do.
        defect: Box<Defect>,
    },
    /// The mesh or one of its arrays.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
}

impl SceneError {
    pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        |source| Self::Io {
            path: path.to_path_buf(),
            source,
        }
    }
    pub(super) fn invalid(
        path: &Path,
        location: impl Into<Location>,
        defect: impl Into<Defect>,
    ) -> Self {
        let mut location = location.into();
        if let Location::Field { path: field, line } = &mut location {
            *line = json::line_in_file(path, field);
        }
        Self::Invalid {
            path: path.to_path_buf(),
            location,
            defect: Box::new(defect.into()),
        }
    }
}
