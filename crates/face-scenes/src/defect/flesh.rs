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
