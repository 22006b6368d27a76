//! Curves as text and as CSV.

use crate::curve::{Curve, Point};
use std::path::Path;
use workbench::report::Style;

/// Prints a curve, and what breaks its claim.
pub fn print(curve: &Curve, measure: &str, style: Style) {
    println!("  {} ({})", style.bold(&curve.name), curve.axis.name());
    println!(
        "    {:<30} {:>11} {:>10} {:>9} {:>6} {:>7} {:>7} {:>8}",
        "", measure, "seconds", "unknowns", "steps", "factors", "iter.", "MiB"
    );
    for p in &curve.points {
        let memory = p.memory.map_or("-".to_owned(), |m| format!("{m:.0}"));
        println!(
            "    {:<30} {:>11.2e} {:>10.4} {:>9} {:>6} {:>7} {:>7} {memory:>8}",
            p.setting, p.error, p.seconds, p.unknowns, p.steps, p.factorizations, p.iterations,
        );
    }
    if let Some(broken) = curve.broken() {
        println!("    {} {broken}", style.red("WRONG:"));
    }
}

/// The columns of the file.
const COLUMNS: [&str; 11] = [
    "scene",
    "curve",
    "axis",
    "setting",
    "error",
    "seconds",
    "unknowns",
    "steps",
    "factorizations",
    "iterations",
    "peak_mib",
];

/// Writes the curves of a scene to a file.
///
/// # Errors
/// If it cannot be written.
pub fn csv(scene: &str, curves: &[Curve], path: &Path) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_path(path)?;
    writer.write_record(COLUMNS)?;
    for curve in curves {
        for point in &curve.points {
            writer.write_record(row(scene, curve, point))?;
        }
    }
    writer.flush()?;
    Ok(())
}

fn row(scene: &str, curve: &Curve, p: &Point) -> [String; 11] {
    [
        scene.to_owned(),
        curve.name.clone(),
        curve.axis.name().to_owned(),
        p.setting.clone(),
        format!("{:.3e}", p.error),
        format!("{:.5}", p.seconds),
        p.unknowns.to_string(),
        p.steps.to_string(),
        p.factorizations.to_string(),
        p.iterations.to_string(),
        p.memory.map_or_else(String::new, |m| format!("{m:.0}")),
    ]
}
