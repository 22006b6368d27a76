//! `cargo xtask stress`: what happens at the edge. Each [`Row`] says what it gives, an answer or one
//! named error, and passes only when it gives that: `docs/stress.md`.
#![allow(non_snake_case)]

mod balance;
mod body;
mod face;
mod failure;
mod named;
mod program;
mod row;
pub mod rows;
mod runner;
mod table;

pub use balance::kept;
pub use failure::Failure;
pub use row::{Evidence, Expected, Row, Settings, Verdict};
pub use runner::{Options, Record, run, run_rows};
