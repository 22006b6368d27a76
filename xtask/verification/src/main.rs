//! `cargo xtask verify`, `cargo xtask bench`, `cargo xtask stress`.

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    about = "Conformance, benchmarks and stress tests of the workspace"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compare every model and every derivative with reference tables, dual numbers, differences
    Verify(verification::verify::Verify),
    /// What an accuracy costs: time against error, scene by scene
    Bench(bench::Options),
    /// Bodies, faces, files and programs at the edge: a table with a verdict for each row
    Stress(stress::Options),
}

/// 0: everything holds; 1: something does not; 2: it could not be carried through.
fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Verify(options) => verification::verify::run(&options).map_err(|e| e.to_string()),
        Command::Bench(options) => bench::run(&options).map_err(|e| e.to_string()),
        Command::Stress(options) => stress::run(&options),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}
