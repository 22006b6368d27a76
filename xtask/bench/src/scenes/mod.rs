//! The scenes: each has a truth, and curves of time against the distance from it.

mod bar;
mod bars;
mod crack;
mod derivative;
pub mod elastic;
mod faces;
mod hertz;
mod mpm;
mod muscle;
pub mod radial;
pub mod shell;
mod sphere;
mod spp;

use crate::curve::Curve;
use crate::failure::Failure;
use crate::settings::Settings;

/// A scene.
#[derive(Clone)]
pub struct Scene {
    /// What it is called.
    pub name: &'static str,
    /// What is in it.
    pub about: &'static str,
    /// What an error is, and its unit.
    pub measure: &'static str,
    /// What errors are measured against, and what is left of its own.
    pub truth: &'static str,
    /// Measures all its curves.
    pub run: fn(&Settings) -> Result<Vec<Curve>, Failure>,
    /// A small case that does the same work every time: its instructions are counted, where it has one
    /// that takes minutes at most when it is.
    pub counted: Option<fn() -> Result<(), Failure>>,
}

/// All scenes.
pub fn all() -> Vec<Scene> {
    let mut all = vec![
        bars::TWIST,
        bars::BEND,
        spp::SCENE,
        sphere::SCENE,
        muscle::SCENE,
        hertz::SCENE,
        derivative::SCENE,
    ];
    all.extend(faces::SCENES);
    all.extend([mpm::SCENE, crack::SCENE]);
    all
}
