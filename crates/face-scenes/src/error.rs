//! What can be wrong with a scene.

use super::json;
use face_rig::anatomy::HingeError;
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
    #[error("{}:{line}:{column}: {field}{reason}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The field's path and a colon, like `bones.jaw: `, or nothing for the whole file.
        field: String,
        /// What is wrong.
        reason: String,
    },
    /// A field of the scene file, or an entry of a file it names, does not fit the rest.
    #[error("{}: {place}: {reason}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// "line 12", the field, or both.
        place: String,
        /// What is wrong and what to do.
        reason: String,
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
        place: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        let mut place = place.into();
        if let Some(line) = json::line_in_file(path, &place) {
            place = format!("line {line}, {place}");
        }
        Self::Invalid {
            path: path.to_path_buf(),
            place,
            reason: reason.into(),
        }
    }
    pub(super) fn hinge(path: &Path, place: &str) -> impl FnOnce(HingeError) -> Self {
        move |error| Self::invalid(path, place, error.to_string())
    }
}
