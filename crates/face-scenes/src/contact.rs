//! What the flesh of a scene touches: bones and eyeballs that it may not enter, and itself.

use super::SceneError;
use super::defect::ContactDefect;
use super::load::Place;
use super::outline::Outline;
use super::shape::{ShapeSpec, shapes};
use super::touching::{self, FleshSpec, SkinOf, Touching};
use face_rig::anatomy::{Bone, Bones, EmbeddedPoint};
use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{
    AssemblyBuilder, AssemblyError, ContactPoint, FleshContact, FleshContactParams, RigidContact,
    RigidContactParams, RigidFrame, RigidSurface,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
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
    /// The gap below which solids push, in the scene's unit; 0.5 mm by default. This, `pressure` and `depth`
    /// are those of solids that say none of their own.
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
    /// Its own [`ContactSpec::activation`], [`ContactSpec::pressure`] and [`ContactSpec::depth`], where it
    /// has one.
    #[serde(default)]
    pub activation: Option<f64>,
    /// See [`activation`](Self::activation).
    #[serde(default)]
    pub pressure: Option<f64>,
    /// See [`activation`](Self::activation).
    #[serde(default)]
    pub depth: Option<f64>,
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

/// What flesh touches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// What it may not enter.
    pub solids: Vec<Solid>,
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
    /// How hard it pushes.
    pub params: RigidContactParams,
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
    let said = [spec.activation, spec.pressure, spec.depth];
    let params = pushing(place, "contact", said, RigidContactParams::default())?;
    let spacing = spec.spacing.map_or(1e-3, |v| v * place.scale);
    positive(place, "contact.spacing".into(), spacing)?;
    let mut solids = Vec::new();
    for (k, solid) in spec.solids.iter().enumerate() {
        let field = format!("contact.solids[{k}]");
        let moves_with = match solid.moves_with {
            MovesWith::Cranium => Bone::Cranium,
            MovesWith::Jaw => Bone::Jaw,
        };
        let said = [solid.activation, solid.pressure, solid.depth];
        let params = pushing(place, &field, said, params)?;
        let shapes = shapes(place, &field, &solid.shape, spacing, params.activation)?;
        solids.extend(shapes.into_iter().map(|shape| Solid {
            surface: shape.surface,
            moves_with,
            params,
            bounds: shape.bounds,
            outline: shape.outline.map(Arc::new),
        }));
    }
    let (flesh, touching) = touching::load(place, &spec.flesh, skin)?;
    Ok(Contact {
        solids,
        flesh,
        touching,
    })
}

/// Activation, pressure and depth that a file says, lengths in the scene's unit, and the `otherwise` of
/// what it does not say.
fn pushing(
    place: &Place,
    field: &str,
    [activation, pressure, depth]: [Option<f64>; 3],
    otherwise: RigidContactParams,
) -> Result<RigidContactParams, SceneError> {
    let length = |given: Option<f64>, otherwise| given.map_or(otherwise, |v| v * place.scale);
    let params = RigidContactParams {
        activation: length(activation, otherwise.activation),
        pressure: pressure.unwrap_or(otherwise.pressure),
        depth: length(depth, otherwise.depth),
    };
    for (name, value) in [
        ("activation", params.activation),
        ("pressure", params.pressure),
        ("depth", params.depth),
    ] {
        positive(place, format!("{field}.{name}"), value)?;
    }
    Ok(params)
}

fn positive(place: &Place, field: String, value: f64) -> Result<(), SceneError> {
    if value > 0.0 && value < f64::INFINITY {
        Ok(())
    } else {
        Err(place.field(field, ContactDefect::NotPositive { value }))
    }
}

impl Contact {
    /// Solids that move together and push alike, those of the cranium first.
    fn alike(&self) -> Vec<Vec<&Solid>> {
        let mut groups: Vec<Vec<&Solid>> = Vec::new();
        for bone in [Bone::Cranium, Bone::Jaw] {
            for solid in self.solids.iter().filter(|s| s.moves_with == bone) {
                let like = |of: &&mut Vec<&Solid>| {
                    of[0].moves_with == bone && of[0].params == solid.params
                };
                match groups.iter_mut().find(like) {
                    Some(group) => group.push(solid),
                    None => groups.push(vec![solid]),
                }
            }
        }
        groups
    }

    /// Adds a term for the solids of each bone that push alike, and one for the flesh itself; `embedding` has points of
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
            for solids in self.alike() {
                builder = builder.term(rigid(&solids, &points, mesh, bones)?)?;
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

/// The term of some solids that are alike.
fn rigid(
    solids: &[&Solid],
    points: &[ContactPoint],
    mesh: &SimplexMesh<3>,
    bones: &Bones,
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
    let params = solids
        .first()
        .map_or_else(RigidContactParams::default, |solid| solid.params);
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
                "own",
                r#"{ "solids": [{ "shape": { "sphere": { "center": [0, 0, 0], "radius": 1 } }, "depth": -1 }] }"#,
                "contact.solids[0].depth",
            ),
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

    #[test]
    fn solids_that_push_unlike_are_not_one_term() {
        let balls = |own: &str| {
            let ball = r#""shape": { "sphere": { "center": [0, 0, 0], "radius": 20 } }"#;
            let contact =
                format!(r#"{{ "activation": 2, "solids": [{{ {ball} }}, {{ {ball}{own} }}] }}"#);
            load("unlike", &contact).expect("a scene").contact
        };
        let alike = balls("");
        assert_eq!(alike.alike().len(), 1);
        let unlike = balls(r#", "pressure": 3e4, "depth": 4"#);
        let groups = unlike.alike();
        let [first, second] = &groups[..] else {
            panic!("two terms");
        };
        assert_eq!(first[0].params, alike.solids[0].params);
        let own = second[0].params;
        assert_eq!((own.activation, own.pressure, own.depth), (2e-3, 3e4, 4e-3));
    }
}
