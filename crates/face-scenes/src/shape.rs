//! The forms of solids: spheres, capsules, boxes, half-spaces, eyeballs, surfaces of triangles.

use super::defect::{ContactDefect, Location};
use super::load::Place;
use super::outline::Outline;
use super::{SceneError, json};
use fem_assembly::mesh::MeshFile;
use fem_assembly::{ImplicitSurface, RigidSurface, SampledDistance};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The form of a solid; lengths in the scene's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum ShapeSpec {
    /// A surface of triangles in a VTU or VTK file: all, or those whose corners all have a label in
    /// a point data array of whole numbers. Parts may overlap; holes are closed
    /// ([`SampledDistance`]).
    Triangles {
        /// The file.
        file: PathBuf,
        /// The array.
        #[serde(default)]
        array: Option<String>,
        /// The label.
        #[serde(default)]
        label: Option<i64>,
    },
    /// A JSON file with `eyeballs.NAME.centre_m` and `radius_m`, meters whatever the scene's `scale`.
    Eyeballs(PathBuf),
    /// A ball.
    Sphere {
        /// Its center.
        center: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// All points nearer than the radius to a segment.
    Capsule {
        /// The segment's ends.
        ends: [[f64; 3]; 2],
        /// The radius.
        radius: f64,
    },
    /// A box along the axes.
    Box {
        /// Lowest corner.
        min: [f64; 3],
        /// Highest corner.
        max: [f64; 3],
    },
    /// What is behind a plane.
    HalfSpace {
        /// A point of the plane.
        point: [f64; 3],
        /// Unit normal out of the solid.
        normal: [f64; 3],
    },
}

/// A surface with a box around it and what is drawn of it, as a solid has them.
pub(super) struct Shape {
    pub surface: RigidSurface,
    pub bounds: [[f64; 3]; 2],
    pub outline: Option<Outline>,
}

impl Shape {
    fn implicit(surface: ImplicitSurface<3>, outline: Option<Outline>) -> Self {
        Self {
            bounds: bounds(&surface),
            surface: RigidSurface::Implicit(surface),
            outline,
        }
    }
}

/// What one shape of a scene stands for.
pub(super) fn shapes(
    place: &Place,
    field: &str,
    spec: &ShapeSpec,
    spacing: f64,
    activation: f64,
) -> Result<Vec<Shape>, SceneError> {
    let meters = |x: &[f64; 3]| x.map(|c| c * place.scale);
    let implicit = match spec {
        ShapeSpec::Triangles { file, array, label } => {
            let path = place.file(file);
            let chosen = match (array, label) {
                (Some(array), Some(label)) => Some((array.as_str(), *label)),
                (None, None) => None,
                _ => {
                    let field = format!("{field}.shape.triangles");
                    return Err(place.field(field, ContactDefect::HalfChosen));
                }
            };
            return Ok(vec![triangles(place, &path, chosen, spacing, activation)?]);
        }
        ShapeSpec::Eyeballs(file) => return eyeballs(&place.file(file)),
        ShapeSpec::Sphere { center, radius } => ImplicitSurface::Sphere {
            center: meters(center),
            radius: radius * place.scale,
        },
        ShapeSpec::Capsule { ends, radius } => ImplicitSurface::Capsule {
            ends: [meters(&ends[0]), meters(&ends[1])],
            radius: radius * place.scale,
        },
        ShapeSpec::Box { min, max } => ImplicitSurface::Box {
            min: meters(min),
            max: meters(max),
        },
        ShapeSpec::HalfSpace { point, normal } => ImplicitSurface::HalfSpace {
            point: meters(point),
            normal: *normal,
        },
    };
    implicit
        .check(1e-3)
        .map_err(|e| place.field(format!("{field}.shape"), ContactDefect::from(e)))?;
    Ok(vec![Shape::implicit(implicit, None)])
}

pub(super) fn bounds(surface: &ImplicitSurface<3>) -> [[f64; 3]; 2] {
    let around =
        |low: [f64; 3], high: [f64; 3], by: f64| [low.map(|c| c - by), high.map(|c| c + by)];
    match surface {
        ImplicitSurface::Sphere { center, radius } => around(*center, *center, *radius),
        ImplicitSurface::Capsule {
            ends: [a, b],
            radius,
        } => around(
            std::array::from_fn(|i| a[i].min(b[i])),
            std::array::from_fn(|i| a[i].max(b[i])),
            *radius,
        ),
        ImplicitSurface::Box { min, max } => [*min, *max],
        // A half-space has no bounds, and of a shape that is new here none are known.
        _ => [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]],
    }
}

fn triangles(
    place: &Place,
    path: &Path,
    chosen: Option<(&str, i64)>,
    spacing: f64,
    activation: f64,
) -> Result<Shape, SceneError> {
    let file = MeshFile::read(path)?;
    let mut triangles = file.triangles()?;
    if let Some((array, label)) = chosen {
        let labels = file.point_integers(array)?;
        triangles.retain(|t| t.iter().all(|&n| labels[n as usize] == label));
        if triangles.is_empty() {
            let name = array.to_owned();
            let location = Location::PointArray { name, point: None };
            let defect = ContactDefect::NoTriangle { label };
            return Err(SceneError::invalid(path, location, defect));
        }
    }
    let points: Vec<[f64; 3]> = file
        .points
        .iter()
        .map(|p| p.map(|c| c * place.scale))
        .collect();
    let sampled = SampledDistance::new(&points, &triangles, spacing, activation)
        .map_err(|e| SceneError::invalid(path, Location::Triangles, e))?;
    let corners = || triangles.as_flattened().iter().map(|&n| points[n as usize]);
    let least = |i: usize| corners().map(|p| p[i]).fold(f64::INFINITY, f64::min);
    let most = |i: usize| corners().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max);
    let bounds = [std::array::from_fn(least), std::array::from_fn(most)];
    Ok(Shape {
        surface: RigidSurface::Sampled(Arc::new(sampled)),
        bounds,
        outline: Some(Outline::of(&points, &triangles)),
    })
}

/// Other fields of the file are of no concern here.
#[derive(Deserialize)]
struct EyeballFile {
    eyeballs: BTreeMap<String, Eyeball>,
}
#[derive(Deserialize)]
struct Eyeball {
    centre_m: [f64; 3],
    radius_m: f64,
}

fn eyeballs(path: &Path) -> Result<Vec<Shape>, SceneError> {
    let read: EyeballFile = json::read(path)?;
    let ball = |(name, eye): (String, Eyeball)| {
        let ball = ImplicitSurface::Sphere {
            center: eye.centre_m,
            radius: eye.radius_m,
        };
        ball.check(1e-3).map_err(|e| {
            SceneError::invalid(path, format!("eyeballs.{name}"), ContactDefect::from(e))
        })?;
        let outline = Outline::eyeball(eye.centre_m, eye.radius_m);
        Ok(Shape::implicit(ball, Some(outline)))
    };
    read.eyeballs.into_iter().map(ball).collect()
}
