//! What a scene file says of muscles, ligaments and regions that are drawn as lines.

use crate::material::SceneMaterial;
use crate::shape::ShapeSpec;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Lines and what lies around them; lengths in the scene's unit. `radius` makes a bundle of each line,
/// `thickness` alone a sheet from each line to the next, `thickness`, `width` and `normal` a strap of
/// each line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CourseSpec {
    /// The lines, each of two points or more.
    pub lines: Vec<Vec<PointSpec>>,
    /// Does every line return to its first point?
    #[serde(default)]
    pub closed: bool,
    /// Are the lines smooth through their points (a centripetal Catmull-Rom spline, the default), or
    /// straight between them?
    #[serde(default = "yes")]
    pub smooth: bool,
    /// Of the bundle about each line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Of the sheet or strap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Of the strap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// The side that the strap turns to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// What the lines are laid over.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub over: Vec<OverSpec>,
}

fn yes() -> bool {
    true
}

/// A solid that lines are laid over: points nearer than `clearance` go out to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverSpec {
    /// Its form.
    pub shape: ShapeSpec,
    /// How far from it the lines stay, in the scene's unit.
    pub clearance: f64,
}

/// A point of a line: `[x, y, z]`, or a place on the face.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum PointSpec {
    /// Coordinates, in the scene's unit.
    At([f64; 3]),
    /// A place on the face.
    On(Box<PlaceOnFace>),
}

/// A place on the face: one of `landmark`, `vertex` and `between`, and an `offset` from it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlaceOnFace {
    /// A landmark by its index.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landmark: Option<u32>,
    /// A point of the embedding by its number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertex: Option<u32>,
    /// Two points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[PointSpec; 2]>,
    /// How far from the first to the second of `between`: a half by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Added to it, in the scene's unit.
    pub offset: [f64; 3],
}

impl<'de> Deserialize<'de> for PointSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = PointSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("[x, y, z], or { \"landmark\": …, \"offset\": [x, y, z] }")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<PointSpec, A::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(PointSpec::At)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PointSpec, A::Error> {
                let place = PlaceOnFace::deserialize(MapAccessDeserializer::new(map))?;
                Ok(PointSpec::On(Box::new(place)))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// A muscle drawn in the scene. It replaces the muscle of that name, or comes after the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnMuscle {
    /// Its name; the left one's, ending in `_L`, where it is mirrored.
    pub name: String,
    /// Where it runs.
    pub along: CourseSpec,
    /// Is there one on the other side too, mirrored at x = 0? Landmarks are those of the 68-point
    /// scheme then.
    #[serde(default)]
    pub mirrored: bool,
    /// σ_max, Pa; that of `fibers` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_isometric_stress: Option<f64>,
    /// λ_ofl; that of `fibers` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optimal_stretch: Option<f64>,
}

/// What some muscles have for themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnFibersSpec {
    /// Their names; one without `_L` or `_R` means both sides.
    pub muscles: Vec<String>,
    /// σ_max, Pa.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_isometric_stress: Option<f64>,
    /// λ_ofl.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optimal_stretch: Option<f64>,
}

/// Muscles of which parts contract by themselves, as motor units of a broad muscle do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BundlesSpec {
    /// Their names; one without `_L` or `_R` means both sides.
    pub muscles: Vec<String>,
    /// Into how many bundles each is divided, at most: no more than one for every eight elements that it
    /// fills. A strap is cut lengthwise, a ring into sectors ([`bundles`](face_rig::anatomy::bundles)). They
    /// are named `zygomaticus_major.1_L` and so on, those of each side by themselves, along the axis in
    /// which they lie farthest apart; the muscle's own name means all of them.
    pub count: usize,
}

/// Passive fibers: no tension up to their length at rest, beyond it σ = E (e − toe/2), with a
/// parabola for strains e below `toe`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LigamentSpec {
    /// A name for reports.
    pub name: String,
    /// Where it runs.
    pub along: CourseSpec,
    /// Is there one on the other side too?
    #[serde(default)]
    pub mirrored: bool,
    /// E, Pa.
    pub stiffness: f64,
    /// The strain that straightens the fibers; 0.03 by default.
    #[serde(default = "three_percent")]
    pub toe: f64,
}

fn three_percent() -> f64 {
    0.03
}

/// A region along lines: the elements that these fill to a `share` at least.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnRegion {
    /// A name for reports.
    pub name: String,
    /// Where it lies.
    pub along: CourseSpec,
    /// Does it lie on the other side too?
    #[serde(default)]
    pub mirrored: bool,
    /// Of an element's volume; a half by default.
    #[serde(default = "half")]
    pub share: f64,
    /// What it is made of.
    pub material: SceneMaterial,
}

fn half() -> f64 {
    0.5
}
