//! With which surface flesh touches flesh.

use super::defect::ContactDefect;
use super::distance::distance;
use super::load::Place;
use super::{Landmark, SceneError, Skin};
use face_rig::anatomy::EmbeddedPoint;
use fem_assembly::FleshContactParams;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// Field `contact.flesh`: `false` for nothing, `true` for the whole boundary of the mesh, or
/// `{ "surface": "skin", … }`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum FleshSpec {
    /// The whole boundary with the defaults, or nothing.
    Switch(bool),
    /// A surface, and how hard it pushes.
    Surface(TouchingSpec),
}

impl Default for FleshSpec {
    fn default() -> Self {
        Self::Switch(false)
    }
}

/// A surface of flesh that touches itself. Lengths in the scene's unit; what is left out is that of
/// [`FleshContactParams`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TouchingSpec {
    /// Which.
    pub surface: SurfaceOfFlesh,
    /// The parts of the skin near landmarks, one or a list of them; all of it by default.
    #[serde(
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "one_or_more"
    )]
    pub near: Vec<NearSpec>,
    /// The gap below which it pushes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub activation: Option<f64>,
    /// The pressure at touch, pascals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// How deep a point may lie behind a surface to be pushed out, with the margin on top.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
    /// How much nearer partners may come before they are looked for again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// Partners within so many edges of the surface are not pushed apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub neighbors: Option<usize>,
    /// Are there pairs of two edges beside those of a point and a triangle? Not on the skin by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edges: Option<bool>,
}

/// Which surface touches itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceOfFlesh {
    /// The boundary of the mesh.
    #[default]
    Boundary,
    /// The skin of dense targets ([`Scene::skin`](crate::Scene::skin)), carried by the mesh.
    Skin,
}

/// What lies near some landmarks at rest, or near places beside them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NearSpec {
    /// Their indices.
    pub landmarks: Vec<u32>,
    /// From each of them to the place that is meant, in the scene's unit; nothing by default.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub offset: [f64; 3],
    /// How far from one of the places the corners of a triangle may be, in the scene's unit.
    pub within: f64,
}

fn is_nothing(offset: &[f64; 3]) -> bool {
    *offset == [0.0; 3]
}

/// An object, or a list of them.
fn one_or_more<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<NearSpec>, D::Error> {
    struct Either;
    impl<'de> Visitor<'de> for Either {
        type Value = Vec<NearSpec>;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("{ \"landmarks\": […], \"within\": … } or a list of those")
        }
        fn visit_unit<E>(self) -> Result<Vec<NearSpec>, E> {
            Ok(Vec::new())
        }
        fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Vec<NearSpec>, A::Error> {
            let near = Vec::deserialize(SeqAccessDeserializer::new(list))?;
            match near.is_empty() {
                true => Err(A::Error::invalid_length(0, &self)),
                false => Ok(near),
            }
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Vec<NearSpec>, A::Error> {
            NearSpec::deserialize(MapAccessDeserializer::new(map)).map(|near| vec![near])
        }
    }
    deserializer.deserialize_any(Either)
}

impl<'de> Deserialize<'de> for FleshSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = FleshSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("true, false or { \"surface\": \"skin\", … }")
            }
            fn visit_bool<E>(self, on: bool) -> Result<FleshSpec, E> {
                Ok(FleshSpec::Switch(on))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<FleshSpec, A::Error> {
                TouchingSpec::deserialize(MapAccessDeserializer::new(map)).map(FleshSpec::Surface)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// The surface with which flesh touches flesh.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Touching {
    /// The whole boundary of the mesh.
    #[default]
    Boundary,
    /// These faces of it.
    Faces(Vec<[u32; 3]>),
    /// Triangles between points that the mesh carries.
    Carried {
        /// The points.
        points: Vec<EmbeddedPoint>,
        /// The triangles, counter-clockwise from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// The skin of a face and its landmarks.
pub(super) struct SkinOf<'a> {
    pub skin: Option<&'a Skin>,
    pub landmarks: &'a [Landmark],
    pub rest: &'a [[f64; 3]],
}

pub(super) fn load(
    place: &Place,
    spec: &FleshSpec,
    of: &SkinOf,
) -> Result<(Option<FleshContactParams>, Touching), SceneError> {
    let spec = match spec {
        FleshSpec::Switch(on) => {
            let params = on.then(FleshContactParams::default);
            return Ok((params, Touching::Boundary));
        }
        FleshSpec::Surface(spec) => spec,
    };
    let params = params(place, spec)?;
    let refuse = |field: &str, defect| place.field(format!("contact.flesh.{field}"), defect);
    let touching = match (spec.surface, spec.near.is_empty()) {
        (SurfaceOfFlesh::Boundary, true) => Touching::Boundary,
        (SurfaceOfFlesh::Boundary, false) => {
            return Err(refuse("near", ContactDefect::NearOnSkinAlone));
        }
        (SurfaceOfFlesh::Skin, all) => {
            let skin = of.skin;
            let skin = skin.ok_or_else(|| refuse("surface", ContactDefect::NoSkin))?;
            let mut triangles = skin.triangles.clone();
            if !all {
                let places = places(&spec.near, of, place.scale)
                    .map_err(|(k, defect)| refuse(&format!("near[{k}]"), defect))?;
                let is_near = |n: u32| places.iter().any(|p| p.is_near(skin.rest[n as usize]));
                triangles.retain(|t| t.iter().all(|&n| is_near(n)));
                let corners = || triangles.as_flattened().iter();
                let has_some = |entry: usize| {
                    let own = || places.iter().filter(|p| p.entry == entry);
                    corners().any(|&n| own().any(|p| p.is_near(skin.rest[n as usize])))
                };
                if let Some(k) = (0..spec.near.len()).find(|&k| !has_some(k)) {
                    return Err(refuse(&format!("near[{k}]"), ContactDefect::NothingNear));
                }
            }
            Touching::Carried {
                points: skin.points.clone(),
                triangles,
            }
        }
    };
    Ok((Some(params), touching))
}

fn params(place: &Place, spec: &TouchingSpec) -> Result<FleshContactParams, SceneError> {
    let defaults = FleshContactParams::default();
    let length = |given: Option<f64>, otherwise: f64| given.map_or(otherwise, |v| v * place.scale);
    let params = FleshContactParams {
        activation: length(spec.activation, defaults.activation),
        pressure: spec.pressure.unwrap_or(defaults.pressure),
        depth: length(spec.depth, defaults.depth),
        margin: length(spec.margin, defaults.margin),
        neighbors: spec.neighbors.unwrap_or(defaults.neighbors),
        edges: spec
            .edges
            .unwrap_or(spec.surface == SurfaceOfFlesh::Boundary),
    };
    for (field, value) in [
        ("activation", params.activation),
        ("pressure", params.pressure),
        ("depth", params.depth),
        ("margin", params.margin),
    ] {
        if !(value > 0.0 && value < f64::INFINITY) {
            let field = format!("contact.flesh.{field}");
            return Err(place.field(field, ContactDefect::NotPositive { value }));
        }
    }
    Ok(params)
}

/// A place, and how far from it, meters.
struct Near {
    /// Whose it is in the scene's list.
    entry: usize,
    at: [f64; 3],
    within: f64,
}

impl Near {
    fn is_near(&self, point: [f64; 3]) -> bool {
        distance(point, self.at) <= self.within
    }
}

fn places(near: &[NearSpec], of: &SkinOf, scale: f64) -> Result<Vec<Near>, (usize, ContactDefect)> {
    let mut places = Vec::new();
    for (entry, spec) in near.iter().enumerate() {
        let within = scale * spec.within;
        let finite = spec.offset.iter().all(|o| o.is_finite()) && within < f64::INFINITY;
        if !(finite && within > 0.0) {
            let value = spec.within;
            return Err((entry, ContactDefect::NotPositive { value }));
        }
        for &index in &spec.landmarks {
            let known = of.landmarks.iter().find(|l| l.index == index);
            let landmark = known.ok_or((entry, ContactDefect::NoLandmark { index }))?;
            let rest = landmark.point.position(of.rest);
            let at = std::array::from_fn(|i| rest[i] + scale * spec.offset[i]);
            places.push(Near { entry, at, within });
        }
    }
    Ok(places)
}
