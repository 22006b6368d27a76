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
    /// No surface to touch with.
    #[error("there is no skin: it comes with \"targets.dense\"")]
    NoSkin,
    /// A part of something that is no skin.
    #[error("\"near\" chooses a part of the skin; give \"surface\": \"skin\" with it")]
    NearOnSkinAlone,
    /// A landmark that the scene does not have.
    #[error("the scene has no landmark {index}")]
    NoLandmark {
        /// Its index.
        index: u32,
    },
    /// A choice without a triangle.
    #[error("no triangle of the skin has all corners so near to these landmarks")]
    NothingNear,
    /// A form that has no distance.
    #[error(transparent)]
    Form(#[from] UnusableSurface),
}
