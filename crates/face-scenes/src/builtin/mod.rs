//! A face made by the program: nothing to download, any resolution, the same bytes every time.
//!
//! See [`BuiltinFace`]; as a scene it is [`Scene::builtin`](crate::Scene::builtin).

// Comparisons are written so that a value that is not a number takes the safe branch.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod anatomy;
mod bones;
mod decoration;
mod face;
mod features;
mod form;
mod grid;
mod landmarks;
mod muscles;
mod paint;
mod spline;
#[cfg(test)]
mod tests;
mod tissue;

pub use decoration::{Decoration, Ornament};
pub use face::{BoundaryTriangle, BuiltinError, BuiltinFace, Touching};
pub use form::Side;
pub use paint::flesh_color;
pub use tissue::Tissue;
