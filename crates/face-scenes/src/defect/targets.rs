//! Embedded points, landmarks and targets.

use crate::names::DidYouMean;

/// What is wrong with a row of the embedding table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EmbeddingDefect {
    /// The element does not exist.
    #[error("tet {tet} is not in the mesh, which has {tets}; is this the table of another mesh?")]
    NoTet {
        /// The element.
        tet: u32,
        /// Elements of the mesh.
        tets: usize,
    },
    /// Weights of a point sum to 1.
    #[error("the weights sum to {sum}, not to 1")]
    Sum {
        /// Their sum.
        sum: f64,
    },
    /// A point far outside of its element.
    #[error("the point lies far outside tet {tet} (weights {weights:?})")]
    FarOutside {
        /// The element.
        tet: u32,
        /// Barycentric weights.
        weights: [f64; 4],
    },
    /// A number given before.
    #[error("vertex {vertex} is already on line {line}")]
    Twice {
        /// The number.
        vertex: u32,
        /// The line of the first.
        line: usize,
    },
}

/// Why a landmark has no place on the flesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LandmarkDefect {
    /// Its vertex is unknown.
    #[error("vertex {vertex} is not in the embedding table")]
    NoVertex {
        /// The vertex.
        vertex: u32,
    },
    /// Its position is not on the mesh.
    #[error("{position:?} lies outside the mesh; check units and axes")]
    Outside {
        /// Meters.
        position: [f64; 3],
    },
    /// It is embedded elsewhere.
    #[error(
        "its embedded place is {:.1} mm from its position at rest; the embedding belongs to \
         another mesh, or the units differ",
        distance * 1e3
    )]
    Displaced {
        /// Meters.
        distance: f64,
    },
}

/// What is wrong with landmarks and targets.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TargetDefect {
    /// Targets of a face without landmarks.
    #[error("targets need landmarks; add \"landmarks\" to the face")]
    NoLandmarks,
    /// Strays are to be repaired, and there is no skin to look at.
    #[error(
        "\"repair\" needs the skin of dense targets, which says what lies around a vertex; add \
         \"dense\" to the targets or leave \"strays\" out"
    )]
    StraysWithoutSkin,
    /// No target gives the landmarks at rest.
    #[error("no rows of target \"{target}\", which gives the landmarks at rest")]
    NoRest {
        /// The name looked for.
        target: String,
    },
    /// A landmark without a place on the flesh.
    #[error("landmark {landmark}: {defect}")]
    Landmark {
        /// Its index.
        landmark: u32,
        /// Why.
        defect: LandmarkDefect,
    },
    /// A landmark given before.
    #[error("landmark {landmark} of \"{target}\" is already on line {line}")]
    Twice {
        /// Its index.
        landmark: u32,
        /// The target.
        target: String,
        /// The line of the first.
        line: usize,
    },
    /// A name that no file can have.
    #[error(
        "\"{name}\" cannot be a target's name, because result files are named after it; use \
         letters, digits, spaces, - and _"
    )]
    Name {
        /// The name.
        name: String,
    },
    /// A landmark that the face does not have.
    #[error("target \"{target}\" names landmark {landmark}, which the face does not have")]
    UnknownLandmark {
        /// The target.
        target: String,
        /// The landmark.
        landmark: u32,
    },
    /// A landmark on another vertex than that of the face.
    #[error("landmark {landmark} is vertex {expected} of the face, not {found}")]
    OtherVertex {
        /// The landmark.
        landmark: u32,
        /// Its vertex.
        expected: u32,
        /// The vertex given.
        found: u32,
    },
    /// A goal farther from rest than the face is large.
    #[error(
        "landmark {landmark} of \"{target}\" lies {distance:.3} m from its place at rest, and the whole \
         face is {size:.3} m large; are these meters, and the same axes? Other units, axes and places: \
         \"align\": true in the scene's targets, or --align"
    )]
    TooFar {
        /// The landmark.
        landmark: u32,
        /// The target.
        target: String,
        /// Meters.
        distance: f64,
        /// The face's diagonal, meters.
        size: f64,
    },
    /// Landmarks that determine no motion.
    #[error(
        "the {landmarks} landmarks of target \"{target}\" that the face has are too few or lie on a line: \
         they do not say how to lay it over the face"
    )]
    NotAlignable {
        /// The target.
        target: String,
        /// How many the face has.
        landmarks: usize,
    },
    /// Left is right.
    #[error(
        "target \"{target}\" is a mirror image of the face; negate one axis of its positions, or number \
         its landmarks from the other side"
    )]
    Mirrored {
        /// The target.
        target: String,
    },
    /// A negative weight.
    #[error("weight {weight} is not 0 or more")]
    Weight {
        /// The weight.
        weight: f64,
    },
    /// Nothing counts.
    #[error("all weights of target \"{target}\" are 0")]
    NoWeight {
        /// The target.
        target: String,
    },
    /// A table with nothing to fit.
    #[error("there is no target in it (apart from those skipped)")]
    NoTargets,
    /// A dense skin on a vertex that has no place.
    #[error("vertex {vertex} is not in the face's embedding table")]
    NoVertex {
        /// The vertex.
        vertex: i64,
    },
    /// A point of a dense skin.
    #[error("its coordinates are not finite numbers")]
    NotFinite,
    /// No target of that name.
    #[error("there is no target \"{name}\"{}", DidYouMean(similar))]
    Unknown {
        /// The name.
        name: String,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// A scene without targets.
    #[error("the scene has no targets; name a table with --targets")]
    None,
}
