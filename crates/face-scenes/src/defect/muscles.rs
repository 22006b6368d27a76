//! Muscles.

/// What is wrong with the muscles of a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MuscleDefect {
    /// A list out of order.
    #[error("\"{name}\" has index {found}, expected {expected}; list the muscles in order")]
    Order {
        /// The muscle.
        name: String,
        /// Its index.
        found: usize,
        /// Its place.
        expected: usize,
    },
    /// A name that cannot be set.
    #[error("\"{name}\": muscle names are unique, not empty and without \"=\"")]
    Name {
        /// The name.
        name: String,
    },
    /// A table of fibers without rows.
    #[error("the table has a header and no rows: no muscle would have a fiber")]
    NoFibers,
    /// A label of no muscle.
    #[error("muscle {label} is unknown; -1 stands for none")]
    Unknown {
        /// The label.
        label: i64,
    },
}
