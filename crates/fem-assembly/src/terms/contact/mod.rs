//! Surfaces of flesh that touch.

mod flesh;
mod geometry;
mod pair;
mod search;
mod surface;
mod tree;

pub use flesh::{FleshContact, FleshContactParams};
