//! Opens scenes and reads poses as typed.

use super::args::PoseArgs;
use super::error::Failure;
use face_rig::rig::Parameters;
use face_scenes::builtin::BuiltinFace;
use face_scenes::{Scene, parse_activations, parse_angle, parse_controls};
use std::collections::BTreeMap;

/// Tetrahedra of `builtin` without a number.
const BUILTIN_TETS: usize = 20_000;

/// A scene, and the built-in face behind it if that is what it is.
pub struct Source {
    pub scene: Scene,
    pub builtin: Option<BuiltinFace>,
}

/// A scene by its file or as `builtin:N`; with `align` its targets are laid over the face.
pub fn open(name: &str, align: bool) -> Result<Source, Failure> {
    let tets = match name.split_once(':') {
        None if name == "builtin" => BUILTIN_TETS,
        Some(("builtin", tets)) => tets.parse().map_err(|_| {
            let name = name.to_owned();
            Failure::Tets { name }
        })?,
        _ => {
            let load = if align {
                Scene::load_aligned
            } else {
                Scene::load
            };
            return Ok(Source {
                scene: load(name)?,
                builtin: None,
            });
        }
    };
    builtin(tets)
}

pub fn builtin(tets: usize) -> Result<Source, Failure> {
    let scene = Scene::builtin(tets)?;
    let face = BuiltinFace::with_tets(tets)?;
    Ok(Source {
        scene,
        builtin: Some(face),
    })
}

/// θ of a typed pose.
pub fn pose(scene: &Scene, typed: &PoseArgs) -> Result<Parameters, Failure> {
    let activations = parse_activations(&scene.muscles, typed.set.iter().map(String::as_str))?;
    let angle = typed.jaw.as_deref().map_or(Ok(0.0), parse_angle)?;
    let shift = typed
        .jaw_shift
        .as_deref()
        .map_or(Ok([0.0; 3]), parse_shift)?;
    let controls = typed.control.iter().map(String::as_str);
    let mut parameters = scene.rest_pose();
    parameters.controls = parse_controls(&scene.influences, controls)?;
    parameters.activations = activations;
    parameters.jaw = scene.joint.motion([angle, 0.0, 0.0, 0.0]).0;
    for (t, by) in parameters.jaw.translation.iter_mut().zip(shift) {
        *t += by;
    }
    Ok(parameters)
}

/// The value of every control by its name.
pub fn named_controls<'s>(scene: &'s Scene, pose: &Parameters) -> BTreeMap<&'s str, f64> {
    let names = scene.influences.iter().map(|i| i.name.as_str());
    names.zip(pose.controls.iter().copied()).collect()
}

fn parse_shift(text: &str) -> Result<[f64; 3], Failure> {
    let wrong = || Failure::JawShift {
        text: text.to_owned(),
    };
    let numbers: Vec<f64> = text
        .split(',')
        .map(|t| {
            t.trim()
                .parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .map(|v| 1e-3 * v)
        })
        .collect::<Option<_>>()
        .ok_or_else(wrong)?;
    numbers.try_into().map_err(|_| wrong())
}
