//! What flesh touches.

use fem_kinematics::UnusableSurface;

/// What is wrong with the solids of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContactDefect {
    /// A length or a pressure that is none.
    #[error("{value} must be finite and above 0")]
    NotPositive {
        /// Meters or pascals.
        value: f64,
    },
    /// Half a choice of triangles.
    #[error("\"array\" and \"label\" choose triangles together; give both or none")]
    HalfChosen,
    /// Nothing chosen.
    #[error("no triangle has corners of label {label} alone")]
    NoTriangle {
        /// The label.
        label: i64,
    },
    /// A form that has no distance.
    #[error(transparent)]
    Form(#[from] UnusableSurface),
}
