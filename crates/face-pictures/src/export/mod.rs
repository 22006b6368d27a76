//! Surfaces as files that other programs read: OBJ and binary glTF 2.0, and files that are written
//! whole or not at all.

mod atomic;
mod gltf;
mod obj;

pub use atomic::{WriteError, write_atomically};
pub use gltf::{GlbMesh, MorphTarget, glb};
pub use obj::obj;

/// What an export is made of.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportPart {
    /// Its points.
    #[error("the surface")]
    Surface,
    /// The displacements of a target of that name.
    #[error("morph target {0:?}")]
    MorphTarget(String),
}

/// What can be wrong with the input of an export.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A triangle names a point that does not exist.
    #[error("triangle {triangle} refers to point {point}, but there are only {count} points")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The offending point.
        point: usize,
        /// Number of points.
        count: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} of {what} is not finite: {value:?}")]
    NotFinite {
        /// Which array.
        what: ExportPart,
        /// The point.
        point: usize,
        /// Its coordinates.
        value: [f64; 3],
    },
    /// An array has the wrong length.
    #[error("{what} has {found} entries, expected {expected}")]
    WrongLength {
        /// Which array.
        what: ExportPart,
        /// Length found.
        found: usize,
        /// Length expected.
        expected: usize,
    },
    /// A mesh without points or triangles.
    #[error("the surface has no triangles: nothing to export")]
    Empty,
    /// A channel of a color is infinite or not a number.
    #[error("the base color {value:?} is not finite: give channels from 0 to 1")]
    BadColor {
        /// The color.
        value: [f32; 3],
    },
    /// More data than a binary glTF file can hold (4 GiB).
    #[error("the surface needs {bytes} bytes, more than the 4 GiB of a binary glTF file")]
    TooLarge {
        /// Size needed.
        bytes: u64,
    },
}

fn check(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), ExportError> {
    if points.is_empty() || triangles.is_empty() {
        return Err(ExportError::Empty);
    }
    check_finite(|| ExportPart::Surface, points)?;
    for (triangle, t) in triangles.iter().enumerate() {
        if let Some(&point) = t.iter().find(|&&p| p as usize >= points.len()) {
            let point = point as usize;
            return Err(ExportError::IndexOutOfRange {
                triangle,
                point,
                count: points.len(),
            });
        }
    }
    Ok(())
}

fn check_finite(what: impl Fn() -> ExportPart, values: &[[f64; 3]]) -> Result<(), ExportError> {
    // A glTF file stores single precision, so what overflows there counts as infinite.
    match values
        .iter()
        .position(|v| !v.iter().all(|&x| (x as f32).is_finite()))
    {
        Some(point) => Err(ExportError::NotFinite {
            what: what(),
            point,
            value: values[point],
        }),
        None => Ok(()),
    }
}

/// Smooth unit normals per point: the angle-weighted mean of the triangles around it; `[0, 0, 1]`
/// for a point without any triangle that has an area.
fn point_normals(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut normals = vec![[0.0, 0.0, 1.0]; points.len()];
    for (t, n) in triangles
        .iter()
        .zip(crate::corner_normals(points, triangles, 180.0))
    {
        for k in 0..3 {
            normals[t[k] as usize] = n[k];
        }
    }
    normals
}
