//! The scene file: JSON, unknown fields refused. The module's documentation shows one.

use super::contact::ContactSpec;
use super::courses::{BundlesSpec, DrawnMuscle, DrawnRegion, LigamentSpec, OwnFibersSpec};
use super::influences::{CavitySpec, LoadSpec, MotionSpec, StiffnessSpec, StrengthSpec};
use super::material::{Fibers, SceneMaterial};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A scene file as it stands on disk. Paths are relative to the file's folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// A title for reports.
    #[serde(default)]
    pub name: String,
    /// Meters per unit of length in every file named here and in a hinge's `line`; 1 by default, 0.001
    /// for millimeters. A hinge's file is in meters, as its key says.
    #[serde(default = "one")]
    pub scale: f64,
    /// Where the flesh comes from.
    pub face: FaceSource,
    /// What the flesh is made of where no region says otherwise.
    pub material: SceneMaterial,
    /// Regions made of something else.
    #[serde(default)]
    pub regions: Option<RegionsSpec>,
    /// Passive fibers.
    #[serde(default)]
    pub ligaments: Vec<LigamentSpec>,
    /// What all muscles share.
    #[serde(default, alias = "fibres")]
    pub fibers: Fibers,
    /// Which volumes the flesh keeps; those of single elements by default.
    #[serde(default)]
    pub volume: Volume,
    /// Forces, tractions, pressures, weight and springs.
    #[serde(default)]
    pub loads: Vec<LoadSpec>,
    /// Pressures inside cavities.
    #[serde(default)]
    pub cavities: Vec<CavitySpec>,
    /// Free nodes that are put somewhere.
    #[serde(default)]
    pub motions: Vec<MotionSpec>,
    /// Changes of muscles' strengths.
    #[serde(default)]
    pub strengths: Vec<StrengthSpec>,
    /// Changes of regions' stiffnesses.
    #[serde(default)]
    pub stiffnesses: Vec<StiffnessSpec>,
    /// Whether flesh may end inside out; it may not by default.
    #[serde(default)]
    pub inversion: Inversion,
    /// How the linear systems of Newton's method are solved.
    #[serde(default)]
    pub linear_solver: LinearMethod,
    /// What fits of this scene weigh.
    #[serde(default)]
    pub fit: FitSpec,
    /// What the flesh touches; nothing by default.
    #[serde(default)]
    pub contact: Option<ContactSpec>,
    /// Expressions to fit.
    #[serde(default)]
    pub targets: Option<TargetsSpec>,
}

/// Whether flesh may end inside out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Inversion {
    /// No: a barrier acts on elements that have shrunk to a fifth of their volume
    /// ([`fem_materials::inversion::VolumeBarrier`] with the shear modulus of the flesh).
    #[default]
    Barred,
    /// Where the material lets it.
    Allowed,
    /// Every material and every fiber sees U max(F̂, threshold) Vᵀ in place of F = U F̂ Vᵀ (document 000,
    /// 5.5): models with ln J or F⁻¹ go through elements that are inside out. The number is the
    /// threshold, above 0 and below 1; PhysBAM's is 0.25. Below it the forces are no energy's gradient
    /// and the derivatives of the rig those at the threshold
    /// ([`fem_assembly::AssemblyBuilder::thresholded`]).
    Thresholded(f64),
}

/// How the linear systems of Newton's method are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LinearMethod {
    /// As the rig is asked to: sparse factors, or multigrid where that is cheaper.
    #[default]
    Rig,
    /// Dense QR (document 000, 5.1), for at most
    /// [`LARGEST_QR`](fem_solvers::LinearSolver::LARGEST_QR) unknowns. Derivatives are factored in any
    /// case.
    Qr,
}

/// What fits of a scene see and weigh, unless they are told otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitSpec {
    /// Which points of a target are fitted; its landmarks by default.
    pub points: PointsSpec,
    /// How much a landmark counts beside a point of the dense skin, where both are fitted; 1 by default.
    pub landmark_weight: f64,
    /// Tikhonov weight of the joint's protrusion, lateral shift and yaw, each relative to its limit,
    /// millimeters squared; 300 by default, which suits the 68 landmarks of a face.
    pub jaw_weight_mm2: f64,
    /// Weights of ½ w |MᵀM − I|² for a head and a jaw that may move by an affine map M.
    pub orthogonality: OrthogonalitySpec,
}

impl Default for FitSpec {
    fn default() -> Self {
        Self {
            points: PointsSpec::Landmarks,
            landmark_weight: 1.0,
            jaw_weight_mm2: 300.0,
            orthogonality: OrthogonalitySpec::default(),
        }
    }
}

/// Which points of a target are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum PointsSpec {
    /// Its landmarks.
    #[default]
    Landmarks,
    /// Its dense skin.
    Dense,
    /// Both.
    Both,
}

/// Weights of the orthogonality of affine maps, millimeters squared: larger keeps a map rigid, 0 lets it
/// stretch and shear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OrthogonalitySpec {
    /// Of the head; 10,000 by default.
    pub cranium_mm2: f64,
    /// Of the jaw; 10,000 by default.
    pub jaw_mm2: f64,
}

impl Default for OrthogonalitySpec {
    fn default() -> Self {
        Self {
            cranium_mm2: 1e4,
            jaw_mm2: 1e4,
        }
    }
}

/// Which volumes the flesh keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Volume {
    /// Those of small patches of elements ([`fem_assembly::VolumePatches::around_edges`]): what λ
    /// exceeds μ by resists the change of a patch's volume, (J̄ − 1)², and the elements have λ = μ at
    /// most. Linear tetrahedra do not lock then. A model that a pair of elastic constants does not
    /// determine keeps its elements' volumes.
    Patches,
    /// Those of single elements, the model as it stands: near ν = 1/2 linear tetrahedra lock.
    #[default]
    Elements,
}

fn one() -> f64 {
    1.0
}

/// Where the flesh with its bones, muscles and landmarks comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum FaceSource {
    /// The face that the program makes itself.
    Builtin(BuiltinSpec),
    /// Files.
    Files(Box<FilesSpec>),
}

/// The built-in face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BuiltinSpec {
    /// About how many tetrahedra, 4,000 to 2,000,000.
    pub tets: usize,
}

/// A face in files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilesSpec {
    /// VTU or VTK file of tetrahedra.
    pub mesh: PathBuf,
    /// What to do with elements of negative volume; refused by default.
    #[serde(default, alias = "turned_over")]
    pub inverted: Inverted,
    /// Which nodes hang on which bone.
    pub bones: BonesSpec,
    /// The jaw's hinge.
    pub hinge: HingeSpec,
    /// How the jaw glides and how far it goes; without it a pure rotation within the limits of an
    /// adult joint.
    #[serde(default)]
    pub joint: JointSpec,
    /// The muscles.
    pub muscles: MusclesSpec,
    /// CSV `ict_vertex,tet,w0,w1,w2,w3` (or `vertex,…`): points on the mesh by number.
    #[serde(default)]
    pub embedding: Option<PathBuf>,
    /// What to do with vertices of the skin that ride on other flesh than what is around them; kept,
    /// with a warning of `check`, by default.
    #[serde(default)]
    pub strays: Strays,
    /// The landmarks.
    #[serde(default)]
    pub landmarks: Option<LandmarksSpec>,
}

/// What to do with elements of negative volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Inverted {
    /// Refuse the mesh.
    #[default]
    Refuse,
    /// Swap two nodes and count them.
    Repair,
}

/// What to do with vertices of the skin of dense targets that ride on other flesh than their neighbors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Strays {
    /// Leave them where the embedding lays them.
    #[default]
    Keep,
    /// Give each the element of the neighbor that carries it best, and count them. At rest nothing moves.
    Repair,
}

/// A point data array of whole numbers, and what they mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BonesSpec {
    /// Name of the array.
    pub array: String,
    /// Label of free nodes.
    pub free: i64,
    /// Label of nodes on the skull.
    pub cranium: i64,
    /// Label of nodes on the jaw.
    pub jaw: i64,
}

/// The hinge, given here or in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum HingeSpec {
    /// A JSON file with `hinge_point_m`, meters whatever the scene's `scale`, and `hinge_axis`.
    File(PathBuf),
    /// A line.
    Line {
        /// A point on it.
        point: [f64; 3],
        /// Its direction; a positive angle opens the mouth by the right-hand rule.
        axis: [f64; 3],
    },
}

/// How the jaw glides and how far it goes, beside its hinge. Lengths are in the scene's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointSpec {
    /// The way of the condyles; none by default.
    pub path: Option<PathSpec>,
    /// The limits; those of an adult joint by default.
    pub limits: JointLimitsSpec,
    /// The condyles, left and right, for comparisons; by default those of the hinge's file, or 5 cm
    /// beside the hinge's point.
    pub condyles: Option<[[f64; 3]; 2]>,
}

/// The way of the condyles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathSpec {
    /// How far they glide while the jaw opens.
    pub length: f64,
    /// How much the way descends from straight forward, degrees.
    pub inclination_deg: f64,
    /// The opening at which it ends, degrees.
    pub full_at_deg: f64,
}

/// Limits of a joint's numbers, `[lower, upper]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointLimitsSpec {
    /// Degrees; positive opens.
    pub opening_deg: Option<[f64; 2]>,
    /// Along the path, beyond what the opening brings with it.
    pub protrusion: Option<[f64; 2]>,
    /// Along the axis.
    pub lateral: Option<[f64; 2]>,
    /// Degrees; positive turns the chin to the side that the axis points to.
    pub yaw_deg: Option<[f64; 2]>,
}

/// The muscles: their names and where their fibers run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MusclesSpec {
    /// The names, in the order of the indices; none by default.
    #[serde(default)]
    pub names: NamesSpec,
    /// Where the fibers run; nowhere by default.
    #[serde(default, alias = "fibres")]
    pub fibers: Option<FibersSpec>,
    /// Those of them that are left out; a name without `_L` or `_R` means both sides.
    #[serde(default)]
    pub without: Vec<String>,
    /// Muscles drawn here, which replace those of the same names or come after the others.
    #[serde(default)]
    pub drawn: Vec<DrawnMuscle>,
    /// What some muscles have for themselves.
    #[serde(default)]
    pub own: Vec<OwnFibersSpec>,
    /// Muscles that are divided into bundles.
    #[serde(default)]
    pub bundles: Vec<BundlesSpec>,
}

/// Muscle names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum NamesSpec {
    /// A JSON file: a list of objects with `index` and `name`.
    File(PathBuf),
    /// The names themselves.
    List(Vec<String>),
}

impl Default for NamesSpec {
    fn default() -> Self {
        Self::List(Vec::new())
    }
}

/// Which elements the muscles fill.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum FibersSpec {
    /// CSV `tet,muscle,weight,fx,fy,fz`; several lines for one tet add up.
    Table(PathBuf),
    /// A JSON file: a list of muscles with `name`, `half_thickness_m`, `closed_loop` and `fibers`, lists
    /// of points `point_m`; one line is the axis of a bundle, several lie in a sheet. The muscles are
    /// looked up by name.
    Curves(PathBuf),
    /// Cell data arrays of the mesh: one muscle in each tet at most.
    Arrays {
        /// Index of the muscle, −1 for none.
        muscle: String,
        /// Weight; 1 everywhere if left out.
        #[serde(default)]
        weight: Option<String>,
        /// Unit vectors.
        #[serde(alias = "fibre")]
        fiber: String,
    },
}

/// Which points are landmarks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandmarksSpec {
    /// CSV `target,landmark,ict_vertex,x,y,z` (or `…,vertex,…`).
    pub file: PathBuf,
    /// The rows of this target give the landmarks at rest.
    #[serde(default = "rest")]
    pub rest: String,
}

fn rest() -> String {
    "rest".into()
}

/// Materials by a cell data array of whole numbers, and along lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionsSpec {
    /// Name of the array; needed with `labels`.
    #[serde(default)]
    pub array: String,
    /// What each label means; other labels get the scene's `material`.
    #[serde(default)]
    pub labels: Vec<RegionSpec>,
    /// Regions along lines, each over those before it.
    #[serde(default)]
    pub drawn: Vec<DrawnRegion>,
}

/// One label of a region array.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionSpec {
    /// The label.
    pub label: i64,
    /// A name for reports.
    pub name: String,
    /// What it is made of.
    pub material: SceneMaterial,
}

/// Expressions to fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetsSpec {
    /// CSV `target,landmark,ict_vertex,x,y,z`: where the landmarks go. May be the same file as that
    /// of the landmarks.
    pub landmarks: PathBuf,
    /// Targets of that file to leave out, such as the rest state itself.
    #[serde(default)]
    pub skip: Vec<String>,
    /// Lays the targets over the face at rest, by a motion with scale of each: for tables with other
    /// axes, another unit or another place. A target of `skip` that the table has (the neutral face)
    /// gives one motion for all; without one each target's own landmarks do, those that moved counting
    /// less.
    #[serde(default)]
    pub align: bool,
    /// Names that start like this are other people, not expressions; muscles cannot reach them.
    #[serde(default)]
    pub identities: Vec<String>,
    /// VTU of skin triangles at rest with point data `disp_NAME` and the vertex numbers of the
    /// embedding: dense targets.
    #[serde(default)]
    pub dense: Option<DenseSpec>,
    /// JSON with the rigid jaw motion behind each target (`NAME.jaw.rotation`, `translation_m`), to
    /// compare results with; never used by a fit.
    #[serde(default)]
    pub truth: Option<PathBuf>,
}

/// Dense targets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DenseSpec {
    /// The VTU file.
    pub file: PathBuf,
    /// Name of the point data array of vertex numbers.
    #[serde(default = "ict_vertex")]
    pub vertex: String,
    /// What stands before the target's name in the arrays of displacements.
    #[serde(default = "disp")]
    pub prefix: String,
}

fn ict_vertex() -> String {
    "ict_vertex".into()
}
fn disp() -> String {
    "disp_".into()
}

impl SceneFile {
    /// Reads a scene file without the files that it names.
    ///
    /// # Errors
    /// [`SceneError::Io`](super::SceneError::Io), or [`SceneError::Syntax`](super::SceneError::Syntax)
    /// with the field, line and column.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, super::SceneError> {
        super::json::read(path.as_ref())
    }
}
