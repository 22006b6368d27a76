//! From a scene file to plain data: the flesh, its bones and what it is made of.

use super::courses::{DrawnRegion, Ligament, OwnFibers, Paper};
use super::defect::{Defect, FleshDefect, Location, TargetDefect};
use super::format::{
    BonesSpec, FaceSource, FilesSpec, FitSpec, HingeSpec, Inversion, Inverted, JointLimitsSpec,
    JointSpec, LinearMethod, OrthogonalitySpec, PathSpec, PointsSpec, RegionsSpec, SceneFile,
    Strays, Volume,
};
use super::influences::{self, Ground};
use super::material::{Fibers, NamedMaterial, Region, SceneMaterial};
use super::strays::Named;
use super::touching::SkinOf;
use super::{
    Contact, Landmark, Scene, SceneError, Skin, contact, generated, json, muscles, targets,
};
use face_rig::anatomy::{
    Bone, Bones, CondylarPath, EmbeddedPoint, FiberField, JawHinge, JawJoint, JointError,
    JointLimits, Muscle, TetLocator,
};
use fem_assembly::mesh::{MeshFile, Orientation, Orphans, Repairs, SimplexMesh};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where a scene's files are: relative to the scene file.
pub(super) struct Place<'a> {
    /// The scene file.
    pub path: &'a Path,
    /// Metres per unit of length.
    pub scale: f64,
}

impl Place<'_> {
    pub fn file(&self, relative: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(relative)
    }
    pub fn field(&self, field: impl Into<Location>, defect: impl Into<Defect>) -> SceneError {
        SceneError::invalid(self.path, field, defect)
    }
}

/// A face without its targets.
pub(super) struct Flesh {
    pub mesh: SimplexMesh<3>,
    pub repairs: Repairs,
    pub bones: Bones,
    pub joint: JawJoint,
    pub muscles: Vec<Muscle>,
    pub fiber_field: FiberField,
    pub own_fibers: BTreeMap<u32, OwnFibers>,
    pub regions: Vec<Region>,
    pub region_of_tet: Vec<u32>,
    pub embedding: BTreeMap<u32, EmbeddedPoint>,
    pub strays: Strays,
    pub landmarks: Vec<Landmark>,
    pub skin: Option<Skin>,
    pub contact: Contact,
}

/// With `align` the targets are laid over the face whatever the file says.
pub(super) fn load(path: &Path, align: bool) -> Result<Scene, SceneError> {
    let mut file = SceneFile::read(path)?;
    if let Some(targets) = &mut file.targets {
        targets.align |= align;
    }
    let place = Place {
        path,
        scale: file.scale,
    };
    let (mut flesh, mesh_file) = flesh(&place, &file)?;
    let name = match file.name.as_str() {
        "" => path.file_stem().unwrap_or_default().to_string_lossy(),
        name => name.into(),
    };
    let targets = match &file.targets {
        Some(spec) => {
            let known = Named {
                embedding: &mut flesh.embedding,
                landmarks: &mut flesh.landmarks,
            };
            targets::load(&place, spec, &flesh.mesh, known, flesh.strays)?
        }
        None if flesh.strays == Strays::Repair => {
            return Err(place.field(targets::STRAYS, TargetDefect::StraysWithoutSkin));
        }
        None => targets::Read::default(),
    };
    let ground = Ground {
        mesh: &flesh.mesh,
        bones: &flesh.bones,
        muscles: &flesh.muscles,
        regions: &flesh.regions,
        region_of_tet: &flesh.region_of_tet,
    };
    let influences = influences::load(&place, &file, &ground, mesh_file.as_ref())?;
    let ligaments = ligaments(&place, &file, &flesh)?;
    let mut scene = flesh.scene(name.into_owned(), file.fibers);
    scene.repaired_strays = targets.repaired;
    scene.influences = influences;
    scene.ligaments = ligaments;
    scene.path = path.to_path_buf();
    scene.volume = file.volume;
    scene.inversion = inversion(&place, file.inversion)?;
    scene.linear_solver = file.linear_solver;
    let dense = file.targets.as_ref().is_some_and(|t| t.dense.is_some());
    scene.fit = fit(&place, file.fit, dense)?;
    scene.skin = targets.skin.or(scene.skin);
    if let Some(spec) = &file.contact {
        let of = SkinOf {
            skin: scene.skin.as_ref(),
            landmarks: &scene.landmarks,
            rest: scene.mesh.nodes(),
        };
        scene.contact = contact::load(&place, spec, &of)?;
    }
    scene.targets = targets.targets;
    if let Some(spec) = file.targets {
        scene.identities = spec.identities;
        if !spec.skip.is_empty() {
            scene.skip = spec.skip;
        }
    }
    Ok(scene)
}

/// A threshold of 1 or more would strain flesh at rest.
fn inversion(place: &Place, said: Inversion) -> Result<Inversion, SceneError> {
    match said {
        Inversion::Thresholded(threshold) if !(threshold > 0.0 && threshold < 1.0) => Err(place
            .field(
                "inversion.thresholded",
                FleshDefect::Threshold { threshold },
            )),
        _ => Ok(said),
    }
}

fn fit(place: &Place, said: FitSpec, dense: bool) -> Result<FitSpec, SceneError> {
    if said.points != PointsSpec::Landmarks && !dense {
        return Err(place.field("fit.points", FleshDefect::NoDenseTargets));
    }
    let OrthogonalitySpec {
        cranium_mm2,
        jaw_mm2,
    } = said.orthogonality;
    for (field, weight) in [("cranium_mm2", cranium_mm2), ("jaw_mm2", jaw_mm2)] {
        if !(weight >= 0.0 && weight.is_finite()) {
            let field = format!("fit.orthogonality.{field}");
            return Err(place.field(field, FleshDefect::Weight { weight }));
        }
    }
    let weight = said.jaw_weight_mm2;
    if !(weight >= 0.0 && weight.is_finite()) {
        return Err(place.field("fit.jaw_weight_mm2", FleshDefect::Weight { weight }));
    }
    let weight = said.landmark_weight;
    if !(weight > 0.0 && weight.is_finite()) {
        let defect = FleshDefect::LandmarkWeight { weight };
        return Err(place.field("fit.landmark_weight", defect));
    }
    Ok(said)
}

fn ligaments(place: &Place, file: &SceneFile, flesh: &Flesh) -> Result<Vec<Ligament>, SceneError> {
    if file.ligaments.is_empty() {
        return Ok(Vec::new());
    }
    let paper = Paper {
        place,
        mesh: &flesh.mesh,
        locator: TetLocator::new(&flesh.mesh),
        landmarks: &flesh.landmarks,
        embedding: &flesh.embedding,
    };
    paper.ligaments(&file.ligaments, flesh.muscles.len())
}

/// The face itself, and the mesh file that it comes from, if any.
fn flesh(place: &Place, file: &SceneFile) -> Result<(Flesh, Option<MeshFile>), SceneError> {
    let scale = file.scale;
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(place.field("scale", FleshDefect::Scale { scale }));
    }
    if let Some(defect) = file.fibers.defect() {
        return Err(place.field("fibers", defect));
    }
    let material = material(place, "material", &file.material)?;
    match &file.face {
        FaceSource::Files(files) => {
            let read = MeshFile::read(place.file(&files.mesh))?;
            let flesh = from_files(place, files, &read, file.regions.as_ref(), material)?;
            Ok((flesh, Some(read)))
        }
        FaceSource::Builtin(_) if file.regions.is_some() => {
            Err(place.field("regions", FleshDefect::RegionsOfBuiltin))
        }
        FaceSource::Builtin(spec) => Ok((generated::flesh(place, spec.tets, material)?, None)),
    }
}

impl Flesh {
    /// The scene without targets.
    pub fn scene(self, name: String, fibers: Fibers) -> Scene {
        Scene {
            name,
            path: PathBuf::new(),
            mesh: self.mesh,
            repairs: self.repairs,
            bones: self.bones,
            joint: self.joint,
            muscles: self.muscles,
            fiber_field: self.fiber_field,
            own_fibers: self.own_fibers,
            ligaments: Vec::new(),
            fibers,
            regions: self.regions,
            region_of_tet: self.region_of_tet,
            volume: Volume::default(),
            influences: Vec::new(),
            inversion: Inversion::default(),
            linear_solver: LinearMethod::default(),
            fit: FitSpec::default(),
            contact: self.contact,
            embedding: self.embedding,
            repaired_strays: Vec::new(),
            landmarks: self.landmarks,
            skin: self.skin,
            targets: Vec::new(),
            skip: vec!["rest".into()],
            identities: Vec::new(),
        }
    }
}

fn from_files(
    place: &Place,
    files: &FilesSpec,
    mesh_file: &MeshFile,
    region_spec: Option<&RegionsSpec>,
    material: NamedMaterial,
) -> Result<Flesh, SceneError> {
    let (mesh, repairs) = mesh(place, files, mesh_file)?;
    let bones = bones(mesh_file, &files.bones)?;
    let joint = joint(place, &files.hinge, &files.joint)?;
    let (embedding, landmarks) = targets::points(place, files, &mesh, &repairs)?;
    let paper = Paper {
        place,
        mesh: &mesh,
        locator: TetLocator::new(&mesh),
        landmarks: &landmarks,
        embedding: &embedding,
    };
    let (anatomy, fiber_field) = muscles::load(&paper, &files.muscles, mesh_file)?;
    let (mut regions, mut region_of_tet) = regions(place, region_spec, mesh_file, material)?;
    for (k, drawn) in region_spec.iter().flat_map(|spec| &spec.drawn).enumerate() {
        draw(
            &paper,
            &format!("regions.drawn[{k}]"),
            drawn,
            &mut regions,
            &mut region_of_tet,
        )?;
    }
    drop(paper);
    Ok(Flesh {
        mesh,
        repairs,
        bones,
        joint,
        muscles: anatomy.muscles,
        fiber_field,
        own_fibers: anatomy.own,
        regions,
        region_of_tet,
        embedding,
        strays: files.strays,
        landmarks,
        skin: None,
        contact: Contact::default(),
    })
}

fn mesh(
    place: &Place,
    files: &FilesSpec,
    file: &MeshFile,
) -> Result<(SimplexMesh<3>, Repairs), SceneError> {
    let orientation = match files.inverted {
        Inverted::Refuse => Orientation::Refuse,
        Inverted::Repair => Orientation::Repair,
    };
    let (mesh, repairs) = file.tet_mesh(orientation, Orphans::Refuse)?;
    let scaled = mesh.scaled(place.scale);
    let overflows = || {
        let scale = place.scale;
        place.field("scale", FleshDefect::ScaleOverflows { scale })
    };
    Ok((scaled.ok_or_else(overflows)?, repairs))
}

fn bones(file: &MeshFile, spec: &BonesSpec) -> Result<Bones, SceneError> {
    let labels = file.point_integers(&spec.array)?;
    let array = |point| Location::PointArray {
        name: spec.array.clone(),
        point,
    };
    let known = [
        (spec.free, Bone::Free),
        (spec.cranium, Bone::Cranium),
        (spec.jaw, Bone::Jaw),
    ];
    let bone = |(node, label): (usize, &i64)| {
        let found = known.iter().find(|(l, _)| l == label);
        found.map(|&(_, bone)| bone).ok_or_else(|| {
            let defect = FleshDefect::UnknownBone {
                label: *label,
                free: spec.free,
                cranium: spec.cranium,
                jaw: spec.jaw,
            };
            SceneError::invalid(&file.path, array(Some(node)), defect)
        })
    };
    let of_node = labels
        .iter()
        .enumerate()
        .map(bone)
        .collect::<Result<_, _>>()?;
    let bones = Bones::new(of_node);
    let missing = |defect: FleshDefect| Err(SceneError::invalid(&file.path, array(None), defect));
    if bones.cranium.is_empty() {
        let label = spec.cranium;
        return missing(FleshDefect::NoCranium { label });
    }
    if bones.free.is_empty() {
        let label = spec.free;
        return missing(FleshDefect::NoFreeNode { label });
    }
    Ok(bones)
}

/// Other fields of the file are of no concern here.
#[derive(Deserialize)]
struct HingeFile {
    hinge_point_m: [f64; 3],
    hinge_axis: [f64; 3],
    condyles_m: Option<CondylesFile>,
}
#[derive(Deserialize)]
struct CondylesFile {
    #[serde(rename = "L")]
    left: [f64; 3],
    #[serde(rename = "R")]
    right: [f64; 3],
}

/// A line is in the scene's unit; the keys of a file say meters.
fn joint(place: &Place, spec: &HingeSpec, joint: &JointSpec) -> Result<JawJoint, SceneError> {
    let (path, field, point, axis, condyles) = match spec {
        HingeSpec::Line { point, axis } => (
            place.path.to_path_buf(),
            "face.files.hinge.line",
            point.map(|v| v * place.scale),
            *axis,
            None,
        ),
        HingeSpec::File(file) => {
            let path = place.file(file);
            let read: HingeFile = json::read(&path)?;
            let condyles = read.condyles_m.map(|c| [c.left, c.right]);
            (path, "hinge", read.hinge_point_m, read.hinge_axis, condyles)
        }
    };
    let hinge = JawHinge::new(point, axis).map_err(|e| SceneError::invalid(&path, field, e))?;
    let of_joint = |e: JointError| match e {
        JointError::Upright(_) => SceneError::invalid(&path, field, e),
        _ => place.field("face.files.joint", e),
    };
    let way = joint.path.map(|p| condylar(&p, place.scale));
    let limits = limits(&joint.limits, place.scale);
    let built = JawJoint::new(hinge, way.unwrap_or_default(), limits).map_err(of_joint)?;
    let said = joint
        .condyles
        .map(|c| c.map(|c| c.map(|v| v * place.scale)));
    match said.or(condyles) {
        Some(condyles) => built.with_condyles(condyles).map_err(of_joint),
        None => Ok(built),
    }
}

fn condylar(spec: &PathSpec, scale: f64) -> CondylarPath {
    CondylarPath {
        length: spec.length * scale,
        inclination: spec.inclination_deg.to_radians(),
        full_at: spec.full_at_deg.to_radians(),
    }
}

fn limits(spec: &JointLimitsSpec, scale: f64) -> JointLimits {
    let adult = JointLimits::ADULT;
    let angles = |said: Option<[f64; 2]>, known| said.map_or(known, |v| v.map(f64::to_radians));
    let lengths = |said: Option<[f64; 2]>, known| said.map_or(known, |v| v.map(|v| v * scale));
    JointLimits {
        opening: angles(spec.opening_deg, adult.opening),
        protrusion: lengths(spec.protrusion, adult.protrusion),
        lateral: lengths(spec.lateral, adult.lateral),
        yaw: angles(spec.yaw_deg, adult.yaw),
    }
}

fn material(place: &Place, field: &str, spec: &SceneMaterial) -> Result<NamedMaterial, SceneError> {
    spec.resolve().map_err(|defect| place.field(field, defect))
}

/// Puts a region along lines over those that are there.
fn draw(
    paper: &Paper,
    field: &str,
    drawn: &DrawnRegion,
    regions: &mut Vec<Region>,
    region_of_tet: &mut [u32],
) -> Result<(), SceneError> {
    let index = regions.len() as u32;
    regions.push(Region {
        name: drawn.name.clone(),
        material: material(paper.place, field, &drawn.material)?,
    });
    for tet in paper.region(field, drawn)? {
        region_of_tet[tet as usize] = index;
    }
    Ok(())
}

/// Region 0 is the scene's own material; labels follow in their order.
fn regions(
    place: &Place,
    spec: Option<&RegionsSpec>,
    file: &MeshFile,
    flesh: NamedMaterial,
) -> Result<(Vec<Region>, Vec<u32>), SceneError> {
    let mut regions = vec![Region::of_all(flesh)];
    let Some(spec) = spec else {
        return Ok((regions, vec![0; file.cell_types.len()]));
    };
    for (k, region) in spec.labels.iter().enumerate() {
        let field = format!("regions.labels[{k}]");
        if spec.labels[..k]
            .iter()
            .any(|other| other.label == region.label)
        {
            let label = region.label;
            return Err(place.field(field, FleshDefect::RegionTwice { label }));
        }
        regions.push(Region {
            name: region.name.clone(),
            material: material(place, &field, &region.material)?,
        });
    }
    if spec.labels.is_empty() {
        return Ok((regions, vec![0; file.cell_types.len()]));
    }
    let labels = file.cell_integers(&spec.array)?;
    let region_of = |label: &i64| {
        let known = spec.labels.iter().position(|r| r.label == *label);
        known.map_or(0, |k| k as u32 + 1)
    };
    let of_tet: Vec<u32> = labels.iter().map(region_of).collect();
    for (k, region) in spec.labels.iter().enumerate() {
        if !of_tet.contains(&(k as u32 + 1)) {
            let (label, name) = (region.label, region.name.clone());
            let defect = FleshDefect::EmptyRegion { label, name };
            return Err(place.field(format!("regions.labels[{k}]"), defect));
        }
    }
    Ok((regions, of_tet))
}
