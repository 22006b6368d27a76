//! With which surface flesh touches flesh.

use super::defect::ContactDefect;
use super::distance::distance;
use super::load::Place;
use super::{Landmark, SceneError, Skin};
use face_rig::anatomy::EmbeddedPoint;
use fem_assembly::FleshContactParams;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
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
    /// The part of the skin near landmarks; all of it by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near: Option<NearSpec>,
    /// The gap below which it pushes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub activation: Option<f64>,
    /// The pressure at touch, pascals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
    /// How deep a point may lie behind a surface to be pushed out.
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

/// What lies near some landmarks at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NearSpec {
    /// Their indices.
    pub landmarks: Vec<u32>,
    /// How far from one of them all corners of a triangle may be, in the scene's unit.
    pub within: f64,
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
    let touching = match (spec.surface, &spec.near) {
        (SurfaceOfFlesh::Boundary, None) => Touching::Boundary,
        (SurfaceOfFlesh::Boundary, Some(_)) => {
            return Err(refuse("near", ContactDefect::NearOnSkinAlone));
        }
        (SurfaceOfFlesh::Skin, near) => {
            let skin = of.skin;
            let skin = skin.ok_or_else(|| refuse("surface", ContactDefect::NoSkin))?;
            let mut triangles = skin.triangles.clone();
            if let Some(near) = near {
                let centers = centers(near, of).map_err(|defect| refuse("near", defect))?;
                let within = near.within * place.scale;
                let is_near = |n: u32| {
                    centers
                        .iter()
                        .any(|c| distance(skin.rest[n as usize], *c) <= within)
                };
                triangles.retain(|t| t.iter().all(|&n| is_near(n)));
                if triangles.is_empty() {
                    return Err(refuse("near", ContactDefect::NothingNear));
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

fn centers(near: &NearSpec, of: &SkinOf) -> Result<Vec<[f64; 3]>, ContactDefect> {
    let center = |&index: &u32| {
        let known = of.landmarks.iter().find(|l| l.index == index);
        let landmark = known.ok_or(ContactDefect::NoLandmark { index })?;
        Ok(landmark.point.position(of.rest))
    };
    near.landmarks.iter().map(center).collect()
}
