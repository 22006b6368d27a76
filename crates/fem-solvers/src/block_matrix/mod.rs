//! Symmetric sparse matrices in D×D blocks, lower half only.

mod pattern;
mod product;
mod symmetric;

pub use pattern::{BlockPattern, PatternError};
pub use symmetric::BlockSymmetric;
