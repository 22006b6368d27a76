//! Conformance, benchmarks and stress tests of the workspace: the code behind `cargo xtask`, and
//! what the tests that cross crates share with it.
#![allow(non_snake_case)]

pub mod verify;

pub use stress;
pub use workbench::{numbers, report, scenes, shared};
