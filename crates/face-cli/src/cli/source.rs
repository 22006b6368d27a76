//! Opens scenes and reads poses as typed.

use super::args::PoseArgs;
use super::error::Failure;
use face_rig::rig::Parameters;
use face_scenes::builtin::BuiltinFace;
use face_scenes::{Scene, parse_activations, parse_angle};

/// Tetrahedra of `builtin` without a number.
const BUILTIN_TETS: usize = 20_000;

/// A scene, and the built-in face behind it if that is what it is.
pub struct Source {
    pub scene: Scene,
    pub builtin: Option<BuiltinFace>,
}

pub fn open(name: &str) -> Result<Source, Failure> {
    let tets = match name.split_once(':') {
        None if name == "builtin" => BUILTIN_TETS,
        Some(("builtin", tets)) => tets.parse().map_err(|_| {
            Failure::Input(format!(
                "\"{name}\": builtin:TETS wants a whole number of tetrahedra"
            ))
        })?,
        _ => {
            return Ok(Source {
                scene: Scene::load(name)?,
                builtin: None,
            });
        }
    };
    builtin(tets)
}

pub fn builtin(tets: usize) -> Result<Source, Failure> {
    let scene = Scene::builtin(tets)?;
    let face = BuiltinFace::with_tets(tets).map_err(|e| Failure::Input(e.to_string()))?;
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
    let mut parameters = Parameters::rest(scene.muscles.len());
    parameters.activations = activations;
    parameters.jaw = scene.joint.motion([angle, 0.0, 0.0, 0.0]).0;
    for (t, by) in parameters.jaw.translation.iter_mut().zip(shift) {
        *t += by;
    }
    Ok(parameters)
}

fn parse_shift(text: &str) -> Result<[f64; 3], Failure> {
    let wrong = || {
        Failure::Input(format!(
            "--jaw-shift \"{text}\": three numbers in millimeters, like 0,0,5"
        ))
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
