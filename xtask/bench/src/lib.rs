//! `cargo xtask bench`: what an accuracy costs. Each scene has a truth (a closed form, or a solution
//! that has converged), and each curve says how near to it a setting comes in which time: `docs/bench.md`.
#![allow(non_snake_case)]

mod baseline;
mod body;
mod curve;
mod failure;
pub mod instructions;
mod machine;
mod plot;
mod runner;
pub mod scenes;
mod settings;
mod table;
pub mod timing;

pub use baseline::{Baseline, Change};
pub use curve::{Axis, Claim, Curve, Point};
pub use failure::Failure;
pub use runner::{Options, run};
pub use settings::Settings;
