//! The flesh, its regions and its bones.

/// What is wrong with the flesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FleshDefect {
    /// A unit of length that is none.
    #[error("{scale} must be meters per unit, above 0; 0.001 for mm")]
    Scale {
        /// What was given.
        scale: f64,
    },
    /// A unit of length too large for the coordinates.
    #[error("{scale} makes coordinates overflow")]
    ScaleOverflows {
        /// What was given.
        scale: f64,
    },
    /// A threshold on the stretches that is none.
    #[error(
        "{threshold} must be a stretch above 0 and below 1, such as 0.25: at 1 flesh at rest would be strained"
    )]
    Threshold {
        /// What was given.
        threshold: f64,
    },
    /// A weight that is none.
    #[error(
        "{weight} must be 0 or more millimeters squared; larger keeps a map rigid, a jaw in its joint"
    )]
    Weight {
        /// What was given.
        weight: f64,
    },
    /// A skin that no target knows.
    #[error("the scene has no \"targets.dense\"; say \"landmarks\", or where the skin goes")]
    NoDenseTargets,
    /// Landmarks that count for nothing, or less.
    #[error("{weight} must be above 0; to fit the dense skin alone say \"points\": \"dense\"")]
    LandmarkWeight {
        /// What was given.
        weight: f64,
    },
    /// More unknowns than dense QR takes.
    #[error(
        "\"qr\" is dense and takes at most {limit} unknowns, this face has {unknowns}; leave it out, or take a coarser mesh"
    )]
    TooLargeForQr {
        /// Unknowns of the face.
        unknowns: usize,
        /// The limit.
        limit: usize,
    },
    /// Dense QR by the scene, multigrid always by the caller.
    #[error(
        "\"qr\" solves without multigrid, which is asked for always (--multigrid always); leave \
         \"linear_solver\" out of the scene, or take --multigrid auto or never"
    )]
    QrOrMultigrid,
    /// Regions of a face that the program makes.
    #[error("the built-in face has no arrays to tell regions by; leave it out")]
    RegionsOfBuiltin,
    /// A label given before.
    #[error("label {label} is given twice")]
    RegionTwice {
        /// The label.
        label: i64,
    },
    /// A region without elements.
    #[error("no tet of the mesh has label {label} (\"{name}\")")]
    EmptyRegion {
        /// The label.
        label: i64,
        /// The region.
        name: String,
    },
    /// A label of no bone.
    #[error(
        "label {label} is neither free ({free}), cranium ({cranium}) nor jaw ({jaw}); correct \"bones\" \
         in the scene file"
    )]
    UnknownBone {
        /// The label.
        label: i64,
        /// That of free nodes.
        free: i64,
        /// That of the cranium.
        cranium: i64,
        /// That of the jaw.
        jaw: i64,
    },
    /// Nothing holds the face.
    #[error("no node has the cranium's label {label}; the face would float")]
    NoCranium {
        /// The cranium's label.
        label: i64,
    },
    /// Nothing can move.
    #[error("no node has the label {label} of free nodes")]
    NoFreeNode {
        /// The label.
        label: i64,
    },
    /// No bone at all.
    #[error("no node is attached to cranium or jaw; flesh without support floats away")]
    NoBone,
}
