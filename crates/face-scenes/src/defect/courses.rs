//! Muscles, ligaments and regions that are drawn as lines.

use crate::names::DidYouMean;
use face_rig::anatomy::CourseError;

/// What is wrong with a drawing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CourseDefect {
    /// The lines, or the flesh around them.
    #[error("{name}: {error}")]
    Course {
        /// What is drawn.
        name: String,
        /// What is wrong with it.
        error: CourseError,
    },
    /// A cross-section that is none of the known ones.
    #[error(
        "{name}: give a \"radius\" (bundles), a \"thickness\" (a sheet between lines), or \"thickness\", \
         \"width\" and \"normal\" (straps)"
    )]
    Section {
        /// What is drawn.
        name: String,
    },
    /// A point that is nowhere, or at two places.
    #[error(
        "{name}, point {point} of line {line}: give one of \"landmark\", \"vertex\" and \"between\", and \
         \"at\" with \"between\" alone"
    )]
    Point {
        /// What is drawn.
        name: String,
        /// The line, from 0.
        line: usize,
        /// The point, from 0.
        point: usize,
    },
    /// A landmark that the face does not have.
    #[error("{name}: the face has no landmark {landmark}")]
    NoLandmark {
        /// What is drawn.
        name: String,
        /// The index.
        landmark: u32,
    },
    /// A vertex that the embedding does not have.
    #[error("{name}: the embedding has no vertex {vertex}")]
    NoVertex {
        /// What is drawn.
        name: String,
        /// Its number.
        vertex: u32,
    },
    /// Nothing says where the mirror image of a point is.
    #[error(
        "{name}: a vertex has no known mirror image; draw both sides, or start from landmarks 0 to 67"
    )]
    NoMirrorImage {
        /// What is drawn.
        name: String,
    },
    /// A name that cannot be mirrored.
    #[error("\"{name}\" is mirrored and must end in _L; the other one will end in _R")]
    NoSide {
        /// The name.
        name: String,
    },
    /// A length that is none.
    #[error("{name}: {what} = {value} must be a number above 0")]
    NotPositive {
        /// What is drawn.
        name: String,
        /// The field.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// No muscle of that name.
    #[error("there is no muscle \"{name}\"{}", DidYouMean(similar))]
    UnknownMuscle {
        /// The name.
        name: String,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// Fibers that no activation reaches need a face that has some.
    #[error("{name}: a face with ligaments needs a muscle; name or draw one")]
    NoMuscle {
        /// The ligament.
        name: String,
    },
    /// A name given before.
    #[error("\"{name}\" is drawn twice; give each a name of its own")]
    Twice {
        /// The name.
        name: String,
    },
    /// No bundle at all.
    #[error("{name}: \"count\" must be 1 or more; leave the muscle out with \"without\"")]
    NoBundle {
        /// The muscle.
        name: String,
    },
    /// A muscle in two lists.
    #[error("{name} is divided twice; name it in one of the lists")]
    DividedTwice {
        /// The muscle.
        name: String,
    },
    /// A bundle with the name of something else.
    #[error("\"{name}\" is the name of a bundle and of another muscle; name that one differently")]
    NameOfBundle {
        /// The name.
        name: String,
    },
    /// A region that fills no element.
    #[error("{name}: it fills no tetrahedron to {share}; lower the \"share\" or widen it")]
    EmptyRegion {
        /// The region.
        name: String,
        /// The share wanted.
        share: f64,
    },
}
