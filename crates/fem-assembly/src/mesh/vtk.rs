//! VTU and legacy VTK files: which of the two it is, and what both have in common.
//!
//! A reader trusts no size that a file announces: sizes follow from the numbers of points and cells,
//! and nothing is set aside that the bytes at hand could not fill.

mod base64;
mod blocks;
mod grid;
mod legacy;
mod scalar;
mod write;
mod xml;

use super::atomic;
use super::file::MeshFile;
use super::file_error::MeshFileError;
use std::io;
use std::path::Path;

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Xml,
    Legacy,
}

fn format_of(path: &Path) -> Result<Format, MeshFileError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("vtu") => Ok(Format::Xml),
        Some("vtk") => Ok(Format::Legacy),
        _ => Err(damaged(path, "mesh files end in .vtu or .vtk")),
    }
}

fn damaged(path: &Path, reason: impl Into<String>) -> MeshFileError {
    MeshFileError::Format {
        path: path.to_path_buf(),
        reason: reason.into(),
    }
}

fn system(path: &Path) -> impl FnOnce(io::Error) -> MeshFileError {
    |source| MeshFileError::Io {
        path: path.to_path_buf(),
        source,
    }
}

impl MeshFile {
    /// Reads a `.vtu` or legacy `.vtk` file with one unstructured grid, in any of the ways in which
    /// VTK writes them: text, base64, appended (raw or base64); zlib, LZ4, LZMA; 32 or 64 bits;
    /// either byte order; legacy 1.0 to 5.1. Every array of numbers on points and cells is returned;
    /// texts, and data of the file as a whole, are not.
    ///
    /// # Errors
    /// [`MeshFileError::Io`] and [`MeshFileError::Format`]; a damaged array is an error that names
    /// it, not left out. A file takes no more memory than its points, cells and bytes account for.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, MeshFileError> {
        read(path.as_ref())
    }
    /// Writes a `.vtu` (compressed) or legacy `.vtk` (binary) file, chosen by the extension, whole
    /// or not at all.
    ///
    /// # Errors
    /// [`MeshFileError::Io`]; [`MeshFileError::Format`] for another extension;
    /// [`MeshFileError::Shape`] and [`MeshFileError::Value`] for arrays of wrong length or with NaN.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshFileError> {
        write(self, path.as_ref())
    }
}

fn read(path: &Path) -> Result<MeshFile, MeshFileError> {
    let format = format_of(path)?;
    let bytes = std::fs::read(path).map_err(system(path))?;
    let read = match format {
        Format::Xml => xml::read(&bytes),
        Format::Legacy => legacy::read(&bytes),
    };
    let grid = read.map_err(|problem| damaged(path, problem.to_string()))?;
    Ok(MeshFile {
        path: path.to_path_buf(),
        points: grid.points,
        connectivity: grid.connectivity,
        offsets: grid.offsets,
        cell_types: grid.types,
        point_data: grid.point_data,
        cell_data: grid.cell_data,
    })
}

fn write(file: &MeshFile, path: &Path) -> Result<(), MeshFileError> {
    let format = format_of(path)?;
    let named = MeshFile {
        path: path.to_path_buf(),
        ..file.clone()
    };
    named.check_arrays()?;
    let finite = |x: &[f64; 3]| x.iter().all(|v| v.is_finite());
    if let Some(point) = named.points.iter().position(|x| !finite(x)) {
        let reason = format!("point {point} is not finite; nothing was written");
        return Err(damaged(path, reason));
    }
    write::check(&named).map_err(|reason| damaged(path, reason))?;
    let bytes = match format {
        Format::Xml => write::xml(&named),
        Format::Legacy => write::legacy(&named),
    };
    atomic::write_bytes(path, &bytes).map_err(system(path))
}

#[cfg(test)]
mod tests;
