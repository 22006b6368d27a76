//! Beside the library, which is then compiled once.

mod baseline;
mod curve;
#[path = "../../../../tests/fuzz.rs"]
mod fuzz;
mod instructions;
mod radial;
mod scenes;
mod shell;
mod timing;
