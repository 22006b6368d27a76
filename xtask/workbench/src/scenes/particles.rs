//! c1 to c4: kernels, damage, inextensible fibers and the relaxed KKT system.

use super::input::SceneError;
use crate::report::Report;
use crate::shared::read_json;
use aniso_mpm::scenes::{NAMES, compare};
use std::path::Path;

/// Every scene of the material-point crate.
///
/// # Errors
/// If a file can't be used.
pub fn c(folder: &Path, report: &mut Report) -> Result<(), SceneError> {
    for name in NAMES {
        let file: serde_json::Value = read_json(&folder.join(format!("{name}.json")))?;
        match compare(name, &file) {
            Ok(deviations) => {
                for d in deviations {
                    report.record(
                        "scenes c",
                        "error",
                        name,
                        &d.name,
                        // Counts are compared exactly: their tolerance is 0.
                        if d.error == d.tolerance {
                            1.0
                        } else {
                            d.error / d.tolerance
                        },
                        1.0,
                    );
                }
            }
            Err(error) => report.broken(format!("scene {name}: {error}")),
        }
    }
    Ok(())
}
