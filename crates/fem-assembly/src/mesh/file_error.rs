//! What can be wrong with a mesh file.

use super::error::MeshError;
use std::path::PathBuf;

/// Why a mesh file cannot be read, used or written. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFileError {
    /// The file is missing or cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is no VTU or VTK file, or is damaged.
    #[error("{}: {reason}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
    /// No array of that name.
    #[error(
        "{}: no {kind} data array \"{name}\"; the file has {}",
        path.display(),
        list(present)
    )]
    MissingArray {
        /// The file.
        path: PathBuf,
        /// "point" or "cell".
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names that are there.
        present: Vec<String>,
    },
    /// An array has the wrong number of components or of values.
    #[error(
        "{}: {kind} data array \"{name}\" has {found} {what}, expected {expected}",
        path.display()
    )]
    Shape {
        /// The file.
        path: PathBuf,
        /// "point" or "cell".
        kind: &'static str,
        /// The array.
        name: String,
        /// "components" or "values".
        what: &'static str,
        /// What it has.
        found: usize,
        /// What was asked for.
        expected: usize,
    },
    /// An array holds NaN, an infinity, or a fraction where whole numbers are expected.
    #[error(
        "{}: {kind} data array \"{name}\" at {kind} {index}: {value} is not a {wanted} number",
        path.display()
    )]
    Value {
        /// The file.
        path: PathBuf,
        /// "point" or "cell".
        kind: &'static str,
        /// The array.
        name: String,
        /// The first point or cell with such a value.
        index: usize,
        /// The value.
        value: f64,
        /// "finite" or "whole".
        wanted: &'static str,
    },
    /// A cell of another kind than the one needed.
    #[error(
        "{}: cell {cell} has VTK type {found}, but only {wanted} (type {expected}) can be used; \
         extract them first",
        path.display()
    )]
    CellType {
        /// The file.
        path: PathBuf,
        /// The first such cell.
        cell: usize,
        /// Its VTK type.
        found: u8,
        /// The kind needed, in words.
        wanted: &'static str,
        /// Its VTK type.
        expected: u8,
    },
    /// The cells make no valid mesh.
    #[error("{}: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: MeshError,
    },
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        "none".into()
    } else {
        names.join(", ")
    }
}
