//! `cargo xtask verify`: everything against its independent truth.

mod elements;
mod intermediate;
mod kinematics;
pub mod materials;
mod models;
pub mod runtime;
mod scalars;
pub mod table;

use crate::report::{Report, Style};
use crate::scenes::Extent;
use crate::shared::{ReadError, folder_or_skip};
use fem_assembly::mesh::atomic;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What to verify.
#[derive(Clone, Debug, clap::Args)]
pub struct Verify {
    /// Folder with the reference tables [default: ../shared/reference]
    #[arg(long, value_name = "DIR")]
    pub tables: Option<PathBuf>,
    /// Folder with the reference scenes [default: ../shared/reference/scenes]
    #[arg(long, value_name = "DIR")]
    pub scenes: Option<PathBuf>,
    /// Fewer random deformations and only the short scenes
    #[arg(long)]
    pub quick: bool,
    /// Write all numbers to this file as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Seed of the random deformations, as printed by an earlier run [default: fresh]
    #[arg(long, value_name = "N", value_parser = seed)]
    pub seed: Option<u64>,
}

fn seed(text: &str) -> Result<u64, String> {
    fem_materials::conformance::parse_seed(text)
        .ok_or_else(|| "a seed is a whole number, decimal or hexadecimal after 0x".to_owned())
}

/// Why the verification could not be carried through.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// A reference file could not be used.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A folder could not be listed.
    #[error("{path}: {source}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The report could not be written.
    #[error("{path}: {source}; give --json a file in a folder that exists and can be written")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

#[derive(Serialize)]
struct Json<'a> {
    version: &'a str,
    seed: String,
    passed: bool,
    seconds: f64,
    broken: &'a [String],
    entries: &'a [crate::report::Entry],
}

/// All comparisons with the tables in `folder`; returns the names of models without a table.
///
/// # Errors
/// If a table can't be read.
pub fn check_tables(folder: &Path, report: &mut Report) -> Result<Vec<String>, VerifyError> {
    let without = models::check_tables(folder, report)?;
    scalars::check_lame(folder, report)?;
    scalars::check_curves(folder, report)?;
    kinematics::check::<2>(folder, report)?;
    kinematics::check::<3>(folder, report)?;
    intermediate::check(folder, report)?;
    elements::check::<2>(folder, report)?;
    elements::check::<3>(folder, report)?;
    Ok(without)
}

/// The conformance suite on every registered model.
pub fn check_conformance(seed: u64, rounds: usize, report: &mut Report) {
    models::check_conformance(seed, rounds, report);
}

/// Runs the verification and prints it; true if everything held.
///
/// # Errors
/// If a file can't be read or the report can't be written.
pub fn run(options: &Verify) -> Result<bool, VerifyError> {
    let start = Instant::now();
    let seed = options
        .seed
        .unwrap_or_else(fem_materials::conformance::fresh_seed);
    let style = Style::of_stdout();
    println!("seed {seed:#x}");
    let mut report = Report::default();
    let mut skipped = Vec::new();
    if let Some(folder) = folder_or_skip(options.tables.as_deref(), "reference") {
        let without = check_tables(&folder, &mut report)?;
        if !without.is_empty() {
            println!("no table, conformance only: {}", without.join(", "));
        }
    } else {
        skipped.push("tables");
    }
    check_conformance(seed, if options.quick { 8 } else { 64 }, &mut report);
    if let Some(folder) = folder_or_skip(options.scenes.as_deref(), "reference/scenes") {
        let extent = if options.quick {
            Extent::Some
        } else {
            Extent::All
        };
        crate::scenes::check(&folder, extent, &mut report);
    } else {
        skipped.push("scenes");
    }
    println!("\n{}", report.tables(style));
    println!("{}", report.summary(style));
    let seconds = start.elapsed().as_secs_f64();
    let passed = report.passed();
    println!(
        "{} in {seconds:.1} s, seed {seed:#x}",
        if passed {
            style.green("everything holds")
        } else {
            style.red("NOT everything holds")
        }
    );
    if !skipped.is_empty() {
        println!("NOT compared, for want of a folder: {}", skipped.join(", "));
    }
    if let Some(path) = &options.json {
        let report = Json {
            version: env!("CARGO_PKG_VERSION"),
            seed: format!("{seed:#x}"),
            passed,
            seconds,
            broken: &report.broken,
            entries: report.entries(),
        };
        let text = serde_json::to_string_pretty(&report).expect("plain data becomes JSON");
        atomic::write_bytes(path, text.as_bytes()).map_err(|source| VerifyError::Write {
            path: path.clone(),
            source,
        })?;
    }
    Ok(passed)
}
