//! Beside the library, which is then compiled once.

mod baseline;
mod curve;
mod instructions;
mod radial;
mod scenes;
mod shell;
mod timing;
