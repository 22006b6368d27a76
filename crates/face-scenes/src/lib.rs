//! Scenes: everything a face needs, by name, with every inconsistency an error that says where.
//!
//! A [`Scene`] is read from files or made by the program ([`builtin`]); [`Scene::rig`] makes it a
//! [`Rig`](face_rig::rig::Rig), and [`fit_expression`] fits one of its targets.
//!
//! ```
//! use face_rig::rig::{Direction, Parameters, RigParams};
//! use face_scenes::Scene;
//!
//! let scene = Scene::builtin(5_000)?;
//! let mut rig = scene.rig(RigParams::default())?;
//! let mut pose = Parameters::rest(rig.muscles());
//! let smile = scene.muscles.iter().position(|m| m.name == "zygomaticus_major_L").unwrap();
//! pose.activations[smile] = 0.3;
//! rig.solve(&pose)?;
//!
//! // The left corner of the mouth (landmark 54) rises, and would rise further with more tension.
//! let corner = scene.landmark_points([54]).0[0];
//! let risen = corner.position(&rig.equilibrium().positions())[1] - corner.position(scene.mesh.nodes())[1];
//! let slope = &rig.sensitivity()?.columns(&[Direction::Activation(smile)])?[0];
//! assert!(risen > 0.0 && corner.position(slope)[1] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Scene files
//!
//! A scene is one JSON file. Lengths are meters (or `scale` meters per unit), moduli pascals, paths
//! relative to the file. Unknown fields are refused.
//!
//! ```json
//! {
//!   "name": "a head",
//!   "scale": 1.0,
//!   "face": { "files": {
//!     "mesh": "head.vtu",
//!     "bones": { "array": "bone", "free": 0, "cranium": 1, "jaw": 2 },
//!     "hinge": { "line": { "point": [0, -0.0055, 0.018], "axis": [1, 0, 0] } },
//!     "muscles": {
//!       "names": { "file": "muscles.json" },
//!       "fibers": { "table": "muscle_tets.csv" }
//!     },
//!     "embedding": "embedding.csv",
//!     "landmarks": { "file": "landmarks.csv", "rest": "rest" }
//!   } },
//!   "material": { "stable_neo_hookean": { "young": 30e3, "poisson": 0.47 } },
//!   "regions": { "array": "layer", "labels": [
//!     { "label": 2, "name": "fat", "material": { "preset": "soft_mooney_rivlin" } }
//!   ] },
//!   "fibers": { "curve": "physbam", "stretch": "total", "max_isometric_stress": 200e3, "optimal_stretch": 1.0 },
//!   "targets": {
//!     "landmarks": "landmarks.csv", "skip": ["rest"], "identities": ["identity_"],
//!     "dense": { "file": "targets.vtu", "vertex": "ict_vertex", "prefix": "disp_" },
//!     "truth": "targets.json"
//!   }
//! }
//! ```
//!
//! * `face` is either `files` or `{ "builtin": { "tets": 20000 } }`, the face the program makes. That
//!   one brings its own regions ([`builtin::Tissue`]; `material` is that of `flesh`) and its own
//!   contact with eyeballs, teeth and lips, which a field `contact` replaces.
//! * `inverted`: `"repair"` swaps nodes of elements with negative volume; default `"refuse"`.
//! * `hinge` may be `{ "file": "jaw.json" }` with `hinge_point_m` (meters, whatever
//!   `scale` says), `hinge_axis` and, where known, `condyles_m` with `L` and `R`.
//! * `joint`, beside `hinge`, says how the condyles glide while the jaw opens, and how far it goes:
//!   `{ "path": { "length": 0.012, "inclination_deg": 33, "full_at_deg": 35 },
//!   "limits": { "opening_deg": [-2, 40], "protrusion": [-0.002, 0.01], "lateral": [-0.005, 0.005],
//!   "yaw_deg": [-5, 5] }, "condyles": [[0.05, 0, 0.02], [-0.05, 0, 0.02]] }`. Each part may be left out:
//!   without a path the jaw turns about its hinge alone ([`JointSpec`]).
//! * `muscles.names` may be `{ "list": ["frown_L", "frown_R"] }`; `muscles.fibers` may be
//!   `{ "arrays": { "muscle": "muscle", "weight": "muscle_weight", "fiber": "fiber" } }`, cell data
//!   of the mesh with −1 for no muscle. In a table several muscles may share a tet: they add up.
//! * Muscles, ligaments and regions may be drawn as lines; see below.
//! * `material`: `preset` with a name of [`fem_materials::presets`], or any model of
//!   [`fem_materials::registry`] with its parameters, such as
//!   `{ "yeoh": { "c1": 2e5, "c2": -1e4, "c3": 2e3, "K": 2e6 } }`. A model that elastic constants
//!   determine takes `young` and `poisson`, `lambda` and `mu`, or `bulk` and `shear` for them;
//!   lists of numbers are `[…]` or text.
//! * `fibers.curve`: `"physbam"`, `"blemker"` or `{ "table": { "active": [[l, f], …], "passive": … } }`;
//!   `stretch`: `"total"` or `"isochoric"`.
//! * `volume`: `"elements"` (default) or `"patches"`, for flesh near ν = 1/2 that must not lock
//!   ([`Volume`]).
//! * `loads`, `cavities`, `motions`, `strengths` and `stiffnesses`: what acts beside muscles and bones.
//!   Each has a `name` to set it by and may have a `range` that a fit varies it in; see below.
//! * `inversion`: `"barred"` (default) or `"allowed"`, whether elements may end inside out where the
//!   material lets them, or `{ "thresholded": 0.25 }` for the threshold on the stretches of document
//!   000 ([`Inversion`]).
//! * `linear_solver`: `"rig"` (default) or `"qr"`, dense QR inside Newton's method for small meshes
//!   ([`LinearMethod`]).
//! * `fit`: what fits of the scene see and weigh unless they are told otherwise ([`FitSpec`]):
//!   `{ "points": "both", "landmark_weight": 15, "jaw_weight_mm2": 1e4, "orthogonality":
//!   { "cranium_mm2": 1e4, "jaw_mm2": 1e4 } }`; the last are the weights that keep a head or jaw rigid that
//!   may move by an affine map. Options of the program replace them.
//! * `contact`: what flesh may not enter, and with `"flesh": true` or `"flesh": { "surface": "skin",
//!   "near": { "landmarks": [48, 54], "within": 0.02 } }` itself ([`ContactSpec`], [`TouchingSpec`]):
//!   `{ "solids": [{ "shape": { "triangles": { "file": "teeth.vtu", "array": "bone", "label": 2 } },
//!   "moves_with": "jaw" }, { "shape": { "eyeballs": "jaw.json" }, "pressure": 1e4 }] }`; a shape may also
//!   be a `sphere`, `capsule`, `box` or `half_space`, and a solid may have its own `activation`,
//!   `pressure` and `depth`.
//! * `targets.align`: true lays the targets over the face by a motion with scale
//!   ([`TargetsSpec::align`]).
//! * `face.files.strays`: `"repair"` gives vertices of the skin that the embedding lays on other flesh than
//!   what is around them, as of one lip on the other, an element of a neighbor ([`Strays`]).
//! * Without `embedding`, landmarks are placed by their positions at rest.
//!
//! # What is drawn as lines
//!
//! ```json
//! "muscles": {
//!   "names": { "file": "muscles.json" }, "fibers": { "curves": "muscles.json" },
//!   "without": ["orbicularis_oculi_palpebral"],
//!   "drawn": [
//!     { "name": "corrugator_supercilii_L", "mirrored": true,
//!       "along": { "lines": [[{ "landmark": 22, "offset": [-0.006, 0.004, -0.008] },
//!                             { "landmark": 23, "offset": [0, 0, -0.005] }, { "landmark": 24 }]],
//!                  "radius": 0.002 } },
//!     { "name": "ring", "max_isometric_stress": 300e3,
//!       "along": { "lines": [[[0, 0, 0], [0.01, 0.02, 0], [0.02, 0, 0]], [[0, 0, 0.01], [0.01, 0.02, 0.01], [0.02, 0, 0.01]]],
//!                  "closed": true, "thickness": 0.002,
//!                  "over": [{ "shape": { "eyeballs": "jaw.json" }, "clearance": 0.001 }] } }
//!   ],
//!   "own": [{ "muscles": ["levator_palpebrae"], "optimal_stretch": 1.4 }]
//! }
//! ```
//!
//! A [`CourseSpec`] (`along`) is one or more `lines` of two points or more, `smooth` through their points
//! unless `false`, and the flesh around them: bundles of a `radius` about each, a sheet of a `thickness`
//! from each line to the next, or straps of `width`, `thickness` and `normal`. A point is `[x, y, z]`, or
//! a `landmark` by its index, a `vertex` of the embedding, or a place `at` a share `between` two points,
//! with an `offset`. `over` lays the lines over a solid with a `clearance`. With `"mirrored": true` a name
//! that ends in `_L` gets its partner `_R`, mirrored at x = 0; landmarks are those of the 68-point scheme
//! then.
//!
//! The program finds the tetrahedra, the share of each that the drawing fills, and the direction in it
//! ([`Course`](face_rig::anatomy::Course)): shares times volumes sum to length times cross-section but
//! for what lies outside the flesh, and where muscles interlace they share a tetrahedron.
//!
//! * `muscles.fibers` may be `{ "curves": "muscles.json" }`: a list with `name`, `half_thickness_m`,
//!   `closed_loop` and `fibers`, lists of `point_m`; one line is a bundle, several lie in a sheet with
//!   round borders. `without` leaves muscles of file or table out, `drawn` replaces them by name or
//!   adds others ([`DrawnMuscle`]), `own` gives muscles a σ_max or an optimal stretch of their own
//!   ([`OwnFibersSpec`]), `"bundles": [{ "muscles": ["zygomaticus_major"], "count": 4 }]` divides muscles
//!   into parts that contract by themselves ([`BundlesSpec`]). `names` and `fibers` may be left out where
//!   all is drawn.
//! * `ligaments`: passive fibers ([`LigamentSpec`]), `{ "name": "canthal_L", "mirrored": true,
//!   "along": …, "stiffness": 20e6, "toe": 0.03 }`.
//! * `regions.drawn`: regions of another material ([`DrawnRegion`]), cartilage or soft lids:
//!   `{ "name": "lids", "mirrored": true, "along": …, "share": 0.4, "material": … }`: the elements
//!   that are filled to that share (a half by default), over regions before it.
//!
//! # Loads, cavities and other controls
//!
//! ```json
//! "loads": [
//!   { "force": { "name": "finger", "at": { "sphere": { "center": [0, -0.07, 0.1], "radius": 0.006 } },
//!                "newtons": [0, 0, -0.5] } },
//!   { "traction": { "name": "tape", "on": { "box": { "low": [0, 0, 0], "high": [0.1, 0.1, 0.1] } },
//!                   "pascals": [200, 0, 0], "range": [0, 1] } },
//!   { "pressure": { "name": "wind", "on": { "seen_from": [0, 0, 1] }, "pascals": 100 } },
//!   { "gravity": { "name": "weight", "density": 1000, "acceleration": [0, -9.81, 0] } },
//!   { "springs": { "name": "ligament", "at": { "nodes": [17, 18] }, "stiffness": 50 } },
//!   { "penalty": { "name": "wall", "at": { "region": "lips" }, "stiffness": 2000,
//!                  "shape": { "half_space": { "point": [0, 0, 0.1], "normal": [0, 0, -1] } } } }
//! ],
//! "cavities": [
//!   { "name": "mouth", "faces": { "array": { "name": "surface", "labels": [2] } }, "range": [0, 3000] }
//! ],
//! "motions": [
//!   { "name": "pull", "nodes": { "sphere": { "center": [0.03, -0.03, 0.09], "radius": 0.004 } },
//!     "axes": "xy", "by": [0.004, 0.002, 0], "range": [0, 1] }
//! ],
//! "strengths": [ { "name": "chewer", "muscle": "masseter", "change": 0.5, "range": [-0.5, 2] } ],
//! "stiffnesses": [ { "name": "firmness", "region": "fat", "range": [-0.5, 1] } ]
//! ```
//!
//! Nodes and faces are those that meet every condition of a [`PlaceSpec`]: `box`, `sphere`, `array`
//! (point data of the mesh), `region`, `nodes`, and for faces `seen_from`. The factor of a load or a
//! motion is 1, or with a `range` 0 until it is set; a cavity has its pressure in pascals (`pascals`, 0
//! by default), a strength or stiffness its relative change (`change`). A cavity is what the faces
//! enclose, `closed_by` a `"fan"` (default), `"nothing"` or `{ "point": [x, y, z] }`. Which of them are
//! symmetric, and what a fit can tell apart: `docs/loads.md`.
//!
//! Tables are CSV (RFC 4180, one line a row) with a header: fibers `tet,muscle,weight,fx,fy,fz` (unit vectors), embedding
//! `ict_vertex,tet,w0,w1,w2,w3`, landmarks `target,landmark,ict_vertex,x,y,z`.

pub mod builtin;
pub mod defect;

mod alignment;
mod assembly;
mod check;
mod contact;
mod courses;
mod crossings;
mod distance;
mod error;
mod expression;
mod format;
mod generated;
mod influences;
mod json;
mod load;
mod material;
mod muscles;
mod names;
mod outcome;
mod outline;
mod pose;
mod reactions;
mod rig;
mod shape;
mod strays;
mod table;
mod targets;
mod touching;
mod uncrossed;
mod warning;

pub use alignment::Suspicion;
pub use check::{CheckReport, MeshReport, MuscleReport, check};
pub use contact::{Contact, ContactSpec, MovesWith, Solid, SolidSpec};
pub use courses::{
    BundlesSpec, CourseSpec, DrawnMuscle, DrawnRegion, Ligament, LigamentSpec, OverSpec, OwnFibers,
    OwnFibersSpec, PlaceOnFace, PointSpec,
};
pub use crossings::crossing_triangles;
pub use error::SceneError;
pub use expression::{DenseError, ExpressionFit, JawPose, Observed, fit_expression};
pub use format::{
    BonesSpec, BuiltinSpec, DenseSpec, FaceSource, FibersSpec, FilesSpec, FitSpec, HingeSpec,
    Inversion, Inverted, JointLimitsSpec, JointSpec, LandmarksSpec, LinearMethod, MusclesSpec,
    NamesSpec, OrthogonalitySpec, PathSpec, PointsSpec, RegionSpec, RegionsSpec, SceneFile, Strays,
    TargetsSpec, Volume,
};
pub use influences::{
    BoxSpec, CavitySpec, ClosureSpec, Influence, InfluenceKind, LabelsSpec, LoadSpec, MotionSpec,
    PlaceSpec, SphereSpec, StiffnessSpec, StrengthSpec,
};
pub use material::{FiberCurve, FiberStretch, Fibers, NamedMaterial, Region, SceneMaterial};
pub use outcome::{ImpossiblePose, Outcome, Unfinished};
pub use outline::Outline;
pub use pose::{Allowed, SettingError, parse_activations, parse_angle, parse_controls};
pub use rig::RigSceneError;
pub use shape::ShapeSpec;
pub use touching::{FleshSpec, NearSpec, SurfaceOfFlesh, Touching, TouchingSpec};
pub use warning::Warning;

use defect::TargetDefect;
use face_rig::anatomy::{AffineMap, Bones, EmbeddedPoint, FiberField, JawJoint, Muscle};
use face_rig::fit::{Goal, Similarity};
use fem_assembly::mesh::{Repairs, SimplexMesh};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A face with everything known about it, as plain data; meters and pascals.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Title for reports.
    pub name: String,
    /// The scene file; empty for a scene made in memory.
    pub path: PathBuf,
    /// The flesh at rest.
    pub mesh: SimplexMesh<3>,
    /// What was repaired in the mesh.
    pub repairs: Repairs,
    /// Which nodes hang on which bone.
    pub bones: Bones,
    /// The jaw's joint.
    pub joint: JawJoint,
    /// The muscles, in the order of the activations.
    pub muscles: Vec<Muscle>,
    /// Which elements they fill.
    pub fiber_field: FiberField,
    /// What all of them share.
    pub fibers: Fibers,
    /// What some of them have for themselves, by their index.
    pub own_fibers: BTreeMap<u32, OwnFibers>,
    /// Passive fibers.
    pub ligaments: Vec<Ligament>,
    /// What the flesh is made of; the first is the scene's own material.
    pub regions: Vec<Region>,
    /// The region of every element.
    pub region_of_tet: Vec<u32>,
    /// Which volumes it keeps.
    pub volume: Volume,
    /// What acts on it beside muscles and bones, in the order of the rig's controls.
    pub influences: Vec<Influence>,
    /// Whether it may end inside out.
    pub inversion: Inversion,
    /// How the linear systems of Newton's method are solved.
    pub linear_solver: LinearMethod,
    /// What fits weigh.
    pub fit: FitSpec,
    /// What it touches.
    pub contact: Contact,
    /// Points on the mesh, by number.
    pub embedding: BTreeMap<u32, EmbeddedPoint>,
    /// The numbers of those that were given the flesh of their neighbors on the skin
    /// ([`Strays::Repair`]).
    pub repaired_strays: Vec<u32>,
    /// The landmarks, ascending by index.
    pub landmarks: Vec<Landmark>,
    /// The skin: of dense targets, or of the built-in face.
    pub skin: Option<Skin>,
    /// The expressions to fit.
    pub targets: Vec<Target>,
    /// Names in a table of targets that are none, such as the rest state.
    pub skip: Vec<String>,
    /// Names that start like this are other people, not expressions.
    pub identities: Vec<String>,
}

/// A landmark that rides on the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Its index, 0 to 67 in Multi-PIE order.
    pub index: u32,
    /// Its number among the points of the embedding.
    pub vertex: u32,
    /// Where it rides.
    pub point: EmbeddedPoint,
}

/// A skin surface that rides on the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Its vertices.
    pub points: Vec<EmbeddedPoint>,
    /// Where they are at rest, meters.
    pub rest: Vec<[f64; 3]>,
    /// Triangles between them.
    pub triangles: Vec<[u32; 3]>,
}

impl Skin {
    /// How many of its triangles pass through others when the nodes of the mesh are at `x`
    /// ([`crossing_triangles`]).
    pub fn crossings(&self, x: &[[f64; 3]]) -> usize {
        let at: Vec<[f64; 3]> = self.points.iter().map(|p| p.position(x)).collect();
        crossing_triangles(&at, &self.triangles).len()
    }

    /// A surface whose vertices are nodes of the mesh, in their order.
    ///
    /// # Panics
    /// If a triangle names a node that the mesh does not have.
    pub fn of_nodes(mesh: &SimplexMesh<3>, triangles: &[[u32; 3]]) -> Self {
        let mut nodes: Vec<u32> = triangles.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |n: &u32| nodes.partition_point(|m| m < n) as u32;
        Self {
            points: nodes.iter().map(|&n| EmbeddedPoint::node(n)).collect(),
            rest: nodes.iter().map(|&n| mesh.node(n)).collect(),
            triangles: triangles
                .iter()
                .map(|t| [place(&t[0]), place(&t[1]), place(&t[2])])
                .collect(),
        }
    }
}

/// What a target shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum TargetKind {
    /// The same person with another expression.
    Expression,
    /// Another person, whom muscles cannot reach.
    Identity,
}

/// An expression to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub kind: TargetKind,
    /// Goals of landmarks, in the order of [`Scene::landmarks`].
    pub landmarks: Vec<Goal>,
    /// Goals of the vertices of [`Scene::skin`], meters, one each.
    pub dense: Option<Vec<[f64; 3]>>,
    /// The rigid jaw motion behind it where known: to compare with, not to fit with.
    pub jaw_truth: Option<AffineMap>,
    /// What laid it over the face, if it was asked for.
    pub alignment: Option<Similarity>,
}

impl Scene {
    /// Reads a scene file and all files that it names.
    ///
    /// # Errors
    /// [`SceneError`]: every inconsistency, with file, place and cure.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        load::load(path.as_ref(), false)
    }

    /// The same with the targets laid over the face at rest, whatever the scene says of that
    /// ([`TargetsSpec::align`]).
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_aligned(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        load::load(path.as_ref(), true)
    }

    /// Replaces the targets by those of a landmark table (`target,landmark,ict_vertex,x,y,z`, optionally `weight`; meters;
    /// a path from the current folder), in order of first appearance; the scene's own names to
    /// skip (`rest` if it has none) and of identities hold for it too. With `align` they are laid over
    /// the face first ([`TargetsSpec::align`]).
    ///
    /// # Errors
    /// [`SceneError`] with file, line and cure.
    pub fn read_targets(&mut self, file: &Path, align: bool) -> Result<(), SceneError> {
        let place = load::Place {
            path: &self.path,
            scale: 1.0,
        };
        let spec = TargetsSpec {
            align,
            landmarks: std::path::absolute(file).map_err(SceneError::io(file))?,
            skip: self.skip.clone(),
            identities: self.identities.clone(),
            dense: None,
            truth: None,
        };
        let known = strays::Named {
            embedding: &mut self.embedding,
            landmarks: &mut self.landmarks,
        };
        self.targets = targets::load(&place, &spec, &self.mesh, known, Strays::Keep)?.targets;
        Ok(())
    }

    /// The built-in face of about `tets` tetrahedra as a scene: soft tissue with softer lids, ligaments
    /// and cartilage, in touch with eyeballs, teeth and its own lips; no targets, its skin as
    /// [`Scene::skin`].
    ///
    /// # Errors
    /// [`SceneError::Invalid`] for a number of tetrahedra that cannot be made.
    pub fn builtin(tets: usize) -> Result<Self, SceneError> {
        generated::scene(tets)
    }

    /// The surface to draw: [`Scene::skin`], or else the whole boundary of the mesh.
    pub fn surface(&self) -> Skin {
        self.skin
            .clone()
            .unwrap_or_else(|| Skin::of_nodes(&self.mesh, &self.mesh.boundary().faces))
    }

    /// The target of that name.
    ///
    /// # Errors
    /// [`SceneError::Invalid`], with a suggestion for names that are almost right.
    pub fn target(&self, name: &str) -> Result<&Target, SceneError> {
        self.targets.iter().find(|t| t.name == name).ok_or_else(|| {
            let place = if self.path.as_os_str().is_empty() {
                Path::new(&self.name)
            } else {
                &self.path
            };
            let defect = match self.targets.as_slice() {
                [] => TargetDefect::None,
                targets => TargetDefect::Unknown {
                    name: name.to_owned(),
                    similar: names::similar(name, targets.iter().map(|t| t.name.as_str())),
                },
            };
            SceneError::invalid(place, "targets", defect)
        })
    }
}

#[cfg(test)]
mod tests;
