//! `cargo xtask bench`: time, work, memory, and time against error.

pub mod twist;

/// What to measure.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum Bench {
    /// The twisted bar of n×n×4n cubes: time, iterations, memory, energy, and time against error
    Twist(twist::Twist),
}

/// Runs a benchmark; true if its results are right.
///
/// # Errors
/// If a mesh can't be built or a solve fails.
pub fn run(bench: &Bench) -> Result<bool, crate::scenes::SceneError> {
    match bench {
        Bench::Twist(options) => twist::run(options),
    }
}
