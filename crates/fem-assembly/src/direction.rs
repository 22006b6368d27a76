//! Directions that are given.

/// How far from 1 the length of a direction may be.
pub(crate) const UNIT_TOLERANCE: f64 = 1e-3;
