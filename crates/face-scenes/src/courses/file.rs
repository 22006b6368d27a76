//! A file of muscles as curves.

use crate::{SceneError, json};
use face_rig::anatomy::{Course, Section};
use serde::Deserialize;
use std::path::Path;

/// Other fields of the file are of no concern here.
#[derive(Deserialize)]
struct CurvedMuscle {
    name: String,
    half_thickness_m: f64,
    #[serde(default)]
    closed_loop: bool,
    #[serde(alias = "fibres")]
    fibers: Vec<Vec<CurvePoint>>,
}
#[derive(Deserialize)]
struct CurvePoint {
    point_m: [f64; 3],
}

/// The muscles by name: all points nearer to a line, or to the sheet between the lines, than the half
/// thickness. Lengths are meters whatever the scale, as the keys say.
pub(super) fn read(path: &Path) -> Result<Vec<(String, Course)>, SceneError> {
    let listed: Vec<CurvedMuscle> = json::read(path)?;
    let course = |muscle: CurvedMuscle| {
        let points = |line: Vec<CurvePoint>| line.into_iter().map(|p| p.point_m).collect();
        let section = match muscle.fibers.len() {
            0 | 1 => Section::Round {
                radius: muscle.half_thickness_m,
            },
            _ => Section::Sheet {
                thickness: 2.0 * muscle.half_thickness_m,
                rounded: true,
            },
        };
        let course = Course {
            lines: muscle.fibers.into_iter().map(points).collect(),
            closed: muscle.closed_loop,
            section,
        };
        (muscle.name, course)
    };
    Ok(listed.into_iter().map(course).collect())
}
