//! What the flesh of a scene touches: bones and eyeballs that it may not enter, and itself.

use super::defect::{ContactDefect, Location};
use super::load::Place;
use super::outline::Outline;
use super::touching::{self, FleshSpec, SkinOf, Touching};
use super::{SceneError, json};
use face_rig::anatomy::{Bone, Bones, EmbeddedPoint};
use fem_assembly::mesh::{MeshFile, SimplexMesh};
use fem_assembly::{
    AssemblyBuilder, AssemblyError, ContactPoint, FleshContact, FleshContactParams,
    ImplicitSurface, RigidContact, RigidContactParams, RigidFrame, RigidSurface, SampledDistance,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How far from a solid flesh lies at rest that may come to touch it, meters.
const TRAVEL: f64 = 0.03;

/// Field `contact` of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    /// What flesh may not enter.
    #[serde(default)]
    pub solids: Vec<SolidSpec>,
    /// The gap below which solids push, in the scene's unit; 0.5 mm by default.
    #[serde(default)]
    pub activation: Option<f64>,
    /// The pressure where flesh touches a solid, pascals; 100 kPa by default.
    #[serde(default)]
    pub pressure: Option<f64>,
    /// How much deeper than at rest flesh can be in a solid at all, in the scene's unit; 1.5 mm by
    /// default. It should be less than half of the thinnest solid.
    #[serde(default)]
    pub depth: Option<f64>,
    /// Distance of the samples of triangle surfaces, in the scene's unit; 1 mm by default.
    #[serde(default)]
    pub spacing: Option<f64>,
    /// Whether flesh pushes flesh away, and with which surface; not by default.
    #[serde(default)]
    pub flesh: FleshSpec,
}

/// A rigid solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidSpec {
    /// Its form.
    pub shape: ShapeSpec,
    /// The bone that it moves with; the cranium by default.
    #[serde(default)]
    pub moves_with: MovesWith,
}

/// A bone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MovesWith {
    /// The skull.
    #[default]
    Cranium,
    /// The lower jaw.
    Jaw,
}

/// The form of a solid; lengths in the scene's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum ShapeSpec {
    /// A surface of triangles in a VTU or VTK file: all, or those whose corners all have a label in
    /// a point data array of whole numbers. Parts may overlap; holes are closed.
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

/// What flesh touches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// What it may not enter.
    pub solids: Vec<Solid>,
    /// How hard these push.
    pub params: RigidContactParams,
    /// How surfaces of flesh push each other, if they do.
    pub flesh: Option<FleshContactParams>,
    /// What they push with.
    pub touching: Touching,
}

/// A rigid solid in its place at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Its surface.
    pub surface: RigidSurface,
    /// The bone that it moves with: cranium or jaw.
    pub moves_with: Bone,
    /// The lowest and the highest corner of a box around it, meters.
    pub bounds: [[f64; 3]; 2],
    /// What pictures show of it: eyeballs and surfaces of triangles.
    pub outline: Option<Arc<Outline>>,
}

pub(super) fn load(
    place: &Place,
    spec: &ContactSpec,
    skin: &SkinOf,
) -> Result<Contact, SceneError> {
    let defaults = RigidContactParams::default();
    let length = |given: Option<f64>, otherwise: f64| given.map_or(otherwise, |v| v * place.scale);
    let params = RigidContactParams {
        activation: length(spec.activation, defaults.activation),
        pressure: spec.pressure.unwrap_or(defaults.pressure),
        depth: length(spec.depth, defaults.depth),
    };
    let spacing = length(spec.spacing, 1e-3);
    for (field, value) in [
        ("contact.activation", params.activation),
        ("contact.pressure", params.pressure),
        ("contact.depth", params.depth),
        ("contact.spacing", spacing),
    ] {
        if !(value > 0.0 && value < f64::INFINITY) {
            return Err(place.field(field, ContactDefect::NotPositive { value }));
        }
    }
    let mut solids = Vec::new();
    for (k, solid) in spec.solids.iter().enumerate() {
        let field = format!("contact.solids[{k}]");
        let moves_with = match solid.moves_with {
            MovesWith::Cranium => Bone::Cranium,
            MovesWith::Jaw => Bone::Jaw,
        };
        let shapes = shapes(place, &field, &solid.shape, spacing, params.activation)?;
        solids.extend(shapes.into_iter().map(|shape| Solid {
            surface: shape.surface,
            moves_with,
            bounds: shape.bounds,
            outline: shape.outline.map(Arc::new),
        }));
    }
    let (flesh, touching) = touching::load(place, &spec.flesh, skin)?;
    Ok(Contact {
        solids,
        params,
        flesh,
        touching,
    })
}

/// A surface with a box around it and what is drawn of it, as in [`Solid`].
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

impl Contact {
    /// Adds a term for the solids of each bone, and one for the flesh itself; `embedding` has points of
    /// the skin that solids push beside the faces of the mesh.
    ///
    /// # Errors
    /// As [`RigidContact::new`] and [`FleshContact::carried`].
    pub fn add_to(
        &self,
        mut builder: AssemblyBuilder<3>,
        mesh: &SimplexMesh<3>,
        bones: &Bones,
        embedding: &BTreeMap<u32, EmbeddedPoint>,
    ) -> Result<AssemblyBuilder<3>, AssemblyError> {
        if self.solids.is_empty() && self.flesh.is_none() {
            return Ok(builder);
        }
        let free = |n: u32| bones.of_node()[n as usize] == Bone::Free;
        let faces = mesh.boundary().faces.into_iter();
        let faces: Vec<[u32; 3]> = faces.filter(|f| f.iter().any(|&n| free(n))).collect();
        if !self.solids.is_empty() {
            let carried = embedding.values().copied();
            let mut points = ContactPoint::carried(mesh, &faces, carried);
            points.retain(|p| p.point.nodes.iter().any(|&n| free(n)));
            for bone in [Bone::Cranium, Bone::Jaw] {
                let solids = self.solids.iter().filter(|s| s.moves_with == bone);
                let solids: Vec<&Solid> = solids.collect();
                if !solids.is_empty() {
                    builder = builder.term(rigid(&solids, &points, mesh, bones, self.params)?)?;
                }
            }
        }
        match self.flesh {
            Some(params) => builder.term(match &self.touching {
                Touching::Boundary => FleshContact::new(mesh, &faces, params)?,
                Touching::Faces(some) => FleshContact::new(mesh, some, params)?,
                Touching::Carried { points, triangles } => {
                    FleshContact::carried(mesh, points, triangles, params)?
                }
            }),
            None => Ok(builder),
        }
    }
}

impl Solid {
    /// Is a point so near at rest that it may come to touch?
    fn is_near(&self, x: [f64; 3]) -> bool {
        let [low, high] = self.bounds;
        (0..3).all(|i| x[i] > low[i] - TRAVEL && x[i] < high[i] + TRAVEL)
    }
}

/// The term of the solids that move with one bone.
fn rigid(
    solids: &[&Solid],
    points: &[ContactPoint],
    mesh: &SimplexMesh<3>,
    bones: &Bones,
    params: RigidContactParams,
) -> Result<RigidContact, AssemblyError> {
    let rest = mesh.nodes();
    let near = |p: &&ContactPoint| {
        let x = p.position(rest);
        solids.iter().any(|solid| solid.is_near(x))
    };
    let near: Vec<ContactPoint> = points.iter().filter(near).copied().collect();
    let frame = if solids.iter().any(|solid| solid.moves_with == Bone::Jaw) {
        let taken: BTreeSet<usize> = near.iter().flat_map(ContactPoint::nodes).collect();
        let jaw = bones.jaw.iter().map(|&n| n as usize);
        let untouched: Vec<usize> = jaw.filter(|n| !taken.contains(n)).collect();
        Some(RigidFrame::new(rest, &untouched)?)
    } else {
        None
    };
    let surfaces = solids.iter().map(|solid| solid.surface.clone()).collect();
    RigidContact::new(surfaces, frame, near, rest, params)
}

#[cfg(test)]
mod tests {
    use crate::{Scene, SceneError};

    /// The built-in face with this field `contact`.
    fn load(name: &str, contact: &str) -> Result<Scene, SceneError> {
        let folder = std::env::temp_dir().join(format!("contact_{}_{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("scene.json");
        let text = format!(
            r#"{{ "face": {{ "builtin": {{ "tets": 5000 }} }}, "scale": 0.001,
                 "material": {{ "preset": "soft_tissue" }}, "contact": {contact} }}"#
        );
        std::fs::write(&path, text).expect("a file");
        let scene = Scene::load(&path);
        std::fs::remove_dir_all(&folder).expect("the folder");
        scene
    }

    #[test]
    fn what_makes_no_sense_is_named_by_its_field() {
        for (name, contact, place) in [
            (
                "radius",
                r#"{ "solids": [{ "shape": { "sphere": { "center": [0, 0, 0], "radius": -1 } } }] }"#,
                "contact.solids[0].shape",
            ),
            ("pressure", r#"{ "pressure": 0 }"#, "contact.pressure"),
            (
                "label",
                r#"{ "solids": [{ "shape": { "triangles": { "file": "a.vtu", "label": 1 } } }] }"#,
                "contact.solids[0].shape.triangles",
            ),
            (
                "file",
                r#"{ "solids": [{ "shape": { "triangles": { "file": "a.vtu" } } }] }"#,
                "a.vtu",
            ),
            (
                "eyes",
                r#"{ "solids": [{ "shape": { "eyeballs": "b.json" } }] }"#,
                "b.json",
            ),
            (
                "bone",
                r#"{ "solids": [{ "shape": { "eyeballs": "b.json" }, "moves_with": "ear" }] }"#,
                "moves_with",
            ),
        ] {
            let error = load(name, contact).expect_err(name).to_string();
            assert!(error.contains(place), "{name}: {error}");
        }
    }

    /// A ball of 20 mm that the tip of the nose touches from 5 mm inside at rest: silent, but the
    /// face may not move on into it.
    #[test]
    fn a_solid_of_a_scene_is_silent_at_rest_and_stiff_beyond() {
        let contact =
            r#"{ "solids": [{ "shape": { "sphere": { "center": [0, 0, 0], "radius": 20 } } }] }"#;
        let mut scene = load("ball", contact).expect("a scene");
        let points = scene.mesh.nodes();
        let front = (0..points.len())
            .max_by(|&a, &b| points[a][2].total_cmp(&points[b][2]))
            .expect("a node");
        let [x, y, z] = points[front];
        let center = [x, y, z + 0.015];
        scene.contact.solids[0].surface =
            fem_assembly::RigidSurface::Implicit(fem_assembly::ImplicitSurface::Sphere {
                center,
                radius: 0.02,
            });
        scene.contact.solids[0].bounds = [center.map(|c| c - 0.02), center.map(|c| c + 0.02)];
        let with = scene.assembly().expect("an assembly");
        scene.contact.solids.clear();
        let without = scene.assembly().expect("an assembly");
        let quiet = vec![0.0; with.controls()];
        let difference = |by: f64| {
            let moved: Vec<[f64; 3]> = with
                .rest()
                .iter()
                .map(|p| [p[0], p[1], p[2] + by])
                .collect();
            let energy = |a: &fem_assembly::Assembly<3>| {
                a.energy(a.configuration(&moved, &quiet).expect("finite"))
            };
            energy(&with) - energy(&without)
        };
        assert!(difference(0.0).abs() < 1e-12);
        assert!(difference(0.5e-3) > 1e-6 && difference(-0.5e-3).abs() < 1e-9);
    }
}
