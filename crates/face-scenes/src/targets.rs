//! Points on the skin of a scene: embedding, landmarks and the expressions to fit.

use super::alignment::Pairs;
use super::defect::{EmbeddingDefect, LandmarkDefect, Location, TableDefect, TargetDefect};
use super::distance::distance;
use super::format::{DenseSpec, FilesSpec, LandmarksSpec, Strays, TargetsSpec};
use super::load::Place;
use super::strays::{self, Named};
use super::table::Table;
use super::{Landmark, SceneError, Skin, Target, TargetKind, json};
use face_rig::anatomy::{AffineMap, EmbeddedPoint, TetLocator};
use face_rig::fit::{Goal, Similarity};
use fem_assembly::mesh::{MeshFile, Repairs, SimplexMesh};
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// A landmark may lie this share of the face's diagonal beside the mesh, or its embedded place beside
/// the stated one: 3 mm on a head.
const TOLERANCE: f64 = 0.01;
/// The field that says what becomes of them.
pub(super) const STRAYS: &str = "face.files.strays";

/// The embedding table and the landmarks of a face in files.
pub(super) fn points(
    place: &Place,
    files: &FilesSpec,
    mesh: &SimplexMesh<3>,
    repairs: &Repairs,
) -> Result<(BTreeMap<u32, EmbeddedPoint>, Vec<Landmark>), SceneError> {
    let diagonal = diagonal(mesh);
    let embedding = match &files.embedding {
        Some(file) => embedding(&place.file(file), mesh, repairs)?,
        None => BTreeMap::new(),
    };
    let landmarks = match &files.landmarks {
        Some(spec) => {
            let known = files.embedding.is_some().then_some(&embedding);
            landmarks(place, spec, known, mesh, TOLERANCE * diagonal)?
        }
        None => Vec::new(),
    };
    Ok((embedding, landmarks))
}

/// The size of a face, meters.
fn diagonal(mesh: &SimplexMesh<3>) -> f64 {
    let (low, high) = mesh.bounding_box();
    distance(low, high)
}

/// A target's name becomes that of its result files.
fn usable_name(name: &str) -> bool {
    let forbidden = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    !name.is_empty() && !name.starts_with('.') && !name.contains(forbidden)
}

/// What is read of the targets of a face.
#[derive(Default)]
pub(super) struct Read {
    /// That of dense targets.
    pub skin: Option<Skin>,
    pub targets: Vec<Target>,
    /// The numbers of vertices that were given other flesh.
    pub repaired: Vec<u32>,
}

/// The targets of a face, and the skin of the dense ones; strays of it are repaired before anything is
/// aimed at.
pub(super) fn load(
    place: &Place,
    spec: &TargetsSpec,
    mesh: &SimplexMesh<3>,
    known: Named,
    on_strays: Strays,
) -> Result<Read, SceneError> {
    if known.landmarks.is_empty() {
        return Err(place.field("targets", TargetDefect::NoLandmarks));
    }
    let dense = spec.dense.as_ref();
    let mut dense = dense
        .map(|spec| Dense::read(place, spec, known.embedding))
        .transpose()?;
    let (embedding, landmarks) = (known.embedding, known.landmarks);
    let repaired = match (on_strays, &mut dense) {
        (Strays::Keep, _) => Vec::new(),
        (Strays::Repair, None) => return Err(place.field(STRAYS, TargetDefect::StraysWithoutSkin)),
        (Strays::Repair, Some(dense)) => {
            let named = Named {
                embedding,
                landmarks,
            };
            strays::repair(&mut dense.skin, &dense.numbers, mesh.nodes(), named)
        }
    };
    let mut targets = sparse(place, spec, landmarks, mesh, !embedding.is_empty())?;
    if let Some(dense) = &dense {
        dense.aim(place, &mut targets)?;
    }
    for target in &mut targets {
        if let (Some(alignment), Some(dense)) = (&target.alignment, &mut target.dense) {
            dense.iter_mut().for_each(|x| *x = alignment.map.apply(*x));
        }
    }
    if let Some(file) = &spec.truth {
        truth(&place.file(file), &mut targets)?;
    }
    Ok(Read {
        skin: dense.map(|dense| dense.skin),
        targets,
        repaired,
    })
}

fn embedding(
    path: &Path,
    mesh: &SimplexMesh<3>,
    repairs: &Repairs,
) -> Result<BTreeMap<u32, EmbeddedPoint>, SceneError> {
    let columns = ["ict_vertex|vertex", "tet", "w0", "w1", "w2", "w3"];
    let table = Table::read(path, &columns)?;
    let mut seen = HashMap::new();
    let mut points = BTreeMap::new();
    for row in table.rows() {
        let row = row?;
        let (id, tet, mut weights) = (row.index(0)?, row.index(1)?, row.numbers::<4>(2)?);
        let tets = mesh.num_elements();
        if tet as usize >= tets {
            return Err(row.error(EmbeddingDefect::NoTet { tet, tets }));
        }
        let sum: f64 = weights.iter().sum();
        let partition = (sum - 1.0).abs() <= 1e-4;
        if !partition {
            return Err(row.error(EmbeddingDefect::Sum { sum }));
        }
        weights = weights.map(|w| w / sum);
        if weights.iter().any(|w| *w < -1.0) {
            return Err(row.error(EmbeddingDefect::FarOutside { tet, weights }));
        }
        if let Some(line) = seen.insert(id, row.line) {
            return Err(row.error(EmbeddingDefect::Twice { vertex: id, line }));
        }
        if repairs.inverted.binary_search(&tet).is_ok() {
            // The table was made for the file's order of the nodes.
            weights.swap(2, 3);
        }
        let nodes = mesh.tet(tet as usize);
        points.insert(id, EmbeddedPoint { nodes, weights });
    }
    if points.is_empty() {
        let defect = TableDefect::NoRows;
        return Err(SceneError::invalid(table.path(), Location::Table, defect));
    }
    Ok(points)
}

/// The rows of a landmark file by target, in order of first appearance.
struct LandmarkRow {
    landmark: u32,
    vertex: u32,
    position: [f64; 3],
    weight: f64,
    line: usize,
}

fn landmark_rows(path: &Path, scale: f64) -> Result<Vec<(String, Vec<LandmarkRow>)>, SceneError> {
    let columns = ["target", "landmark", "ict_vertex|vertex", "x", "y", "z"];
    let table = Table::read_with(path, &columns, "weight")?;
    let mut groups: Vec<(String, Vec<LandmarkRow>)> = Vec::new();
    let mut place: HashMap<String, usize> = HashMap::new();
    for row in table.rows() {
        let row = row?;
        let name = row.text(0).to_owned();
        let next = groups.len();
        let group = *place.entry(name.clone()).or_insert(next);
        if group == next {
            groups.push((name.clone(), Vec::new()));
        }
        let landmark = row.index(1)?;
        let rows = &mut groups[group].1;
        if let Some(twice) = rows.iter().find(|r| r.landmark == landmark) {
            return Err(row.error(TargetDefect::Twice {
                landmark,
                target: name,
                line: twice.line,
            }));
        }
        rows.push(LandmarkRow {
            landmark,
            vertex: row.index(2)?,
            position: row.numbers::<3>(3)?.map(|v| v * scale),
            weight: match row.has(6) {
                true => row.number(6)?,
                false => 1.0,
            },
            line: row.line,
        });
    }
    Ok(groups)
}

fn landmarks(
    place: &Place,
    spec: &LandmarksSpec,
    by_id: Option<&BTreeMap<u32, EmbeddedPoint>>,
    mesh: &SimplexMesh<3>,
    tolerance: f64,
) -> Result<Vec<Landmark>, SceneError> {
    let path = place.file(&spec.file);
    let groups = landmark_rows(&path, place.scale)?;
    let Some((_, rows)) = groups.iter().find(|(name, _)| *name == spec.rest) else {
        let target = spec.rest.clone();
        let defect = TargetDefect::NoRest { target };
        return Err(SceneError::invalid(&path, Location::Table, defect));
    };
    let locator = by_id.is_none().then(|| TetLocator::new(mesh));
    let mut landmarks = Vec::with_capacity(rows.len());
    for row in rows {
        let carried = carried(row, by_id, locator.as_ref(), mesh, tolerance);
        let point = carried.map_err(|defect| {
            let landmark = row.landmark;
            let defect = TargetDefect::Landmark { landmark, defect };
            SceneError::invalid(&path, Location::Line(row.line), defect)
        })?;
        landmarks.push(Landmark {
            index: row.landmark,
            vertex: row.vertex,
            point,
        });
    }
    landmarks.sort_by_key(|l| l.index);
    Ok(landmarks)
}

/// Where a landmark rides: on its vertex of the table, or without one on the element around it.
fn carried(
    row: &LandmarkRow,
    by_id: Option<&BTreeMap<u32, EmbeddedPoint>>,
    locator: Option<&TetLocator>,
    mesh: &SimplexMesh<3>,
    tolerance: f64,
) -> Result<EmbeddedPoint, LandmarkDefect> {
    let (vertex, position) = (row.vertex, row.position);
    let point = match by_id {
        Some(by_id) => *(by_id.get(&vertex)).ok_or(LandmarkDefect::NoVertex { vertex })?,
        None => {
            let found = locator.and_then(|l| l.locate(position));
            let near = found.filter(|f| f.distance <= tolerance);
            let near = near.ok_or(LandmarkDefect::Outside { position })?;
            near.embed(mesh)
        }
    };
    let distance = distance(point.position(mesh.nodes()), position);
    let fits = distance <= tolerance;
    fits.then_some(point)
        .ok_or(LandmarkDefect::Displaced { distance })
}

fn sparse(
    place: &Place,
    spec: &TargetsSpec,
    landmarks: &[Landmark],
    mesh: &SimplexMesh<3>,
    has_vertices: bool,
) -> Result<Vec<Target>, SceneError> {
    let path = place.file(&spec.landmarks);
    let number: HashMap<u32, usize> = landmarks
        .iter()
        .enumerate()
        .map(|(k, l)| (l.index, k))
        .collect();
    let face = Landmarks {
        all: landmarks,
        number,
        size: diagonal(mesh),
        mesh,
        has_vertices,
    };
    let mut targets = Vec::new();
    let groups = landmark_rows(&path, place.scale)?;
    let invalid = |at, defect| Err(SceneError::invalid(&path, at, defect));
    let shared = match spec.align {
        true => face.shared_alignment(&groups, &spec.skip),
        false => None,
    };
    for (name, mut rows) in groups {
        if spec.skip.contains(&name) {
            continue;
        }
        let alignment = match (spec.align, shared) {
            (true, None) => match face.pairs(&rows).alignment(&name) {
                Ok(own) => Some(own),
                Err(defect) => return invalid(Location::Table, defect),
            },
            (_, shared) => shared,
        };
        move_by(alignment.as_ref(), &mut rows);
        if !usable_name(&name) {
            let line = rows.first().map_or(1, |row| row.line);
            return invalid(Location::Line(line), TargetDefect::Name { name });
        }
        let landmarks = face
            .goals(&name, &rows)
            .map_err(|(line, defect)| SceneError::invalid(&path, Location::Line(line), defect))?;
        if !rows.iter().any(|row| row.weight > 0.0) {
            return invalid(Location::Table, TargetDefect::NoWeight { target: name });
        }
        targets.push(Target {
            kind: kind(spec, &name),
            name,
            landmarks,
            dense: None,
            jaw_truth: None,
            alignment,
        });
    }
    if targets.is_empty() {
        let defect = TargetDefect::NoTargets;
        return Err(SceneError::invalid(&path, Location::Table, defect));
    }
    Ok(targets)
}

fn kind(spec: &TargetsSpec, name: &str) -> TargetKind {
    let mut identities = spec.identities.iter();
    match identities.any(|start| name.starts_with(start.as_str())) {
        true => TargetKind::Identity,
        false => TargetKind::Expression,
    }
}

fn move_by(alignment: Option<&Similarity>, rows: &mut [LandmarkRow]) {
    if let Some(alignment) = alignment {
        for row in rows {
            row.position = alignment.map.apply(row.position);
        }
    }
}

/// The landmarks of a face, to hold goals against.
struct Landmarks<'a> {
    all: &'a [Landmark],
    /// The place of a landmark by its index.
    number: HashMap<u32, usize>,
    /// The face's diagonal, meters.
    size: f64,
    mesh: &'a SimplexMesh<3>,
    has_vertices: bool,
}

impl Landmarks<'_> {
    /// The rows of landmarks that the face has and that count, beside their places at rest.
    fn pairs(&self, rows: &[LandmarkRow]) -> Pairs {
        let mut pairs = Pairs::default();
        for row in rows.iter().filter(|row| row.weight > 0.0) {
            if let Some(&k) = self.number.get(&row.landmark) {
                pairs.target.push(row.position);
                pairs
                    .rest
                    .push(self.all[k].point.position(self.mesh.nodes()));
            }
        }
        pairs
    }

    /// That of the first target left out that has one: the neutral face of whoever made the others.
    fn shared_alignment(
        &self,
        groups: &[(String, Vec<LandmarkRow>)],
        skip: &[String],
    ) -> Option<Similarity> {
        let mut neutral = groups.iter().filter(|(name, _)| skip.contains(name));
        neutral.find_map(|(name, rows)| self.pairs(rows).alignment(name).ok())
    }

    /// The goals of a target in the order of the landmarks, or the line with what is wrong.
    fn goals(
        &self,
        target: &str,
        rows: &[LandmarkRow],
    ) -> Result<Vec<Goal>, (usize, TargetDefect)> {
        let of = |row: &LandmarkRow| self.goal(target, row).map_err(|defect| (row.line, defect));
        let mut goals: Vec<(usize, Goal)> = rows.iter().map(of).collect::<Result<_, _>>()?;
        goals.sort_by_key(|&(k, _)| k);
        Ok(goals.into_iter().map(|(_, goal)| goal).collect())
    }

    /// The place of the row's landmark, and its goal.
    fn goal(&self, target: &str, row: &LandmarkRow) -> Result<(usize, Goal), TargetDefect> {
        let (landmark, position, weight) = (row.landmark, row.position, row.weight);
        let target = || target.to_owned();
        let Some(&k) = self.number.get(&landmark) else {
            return Err(TargetDefect::UnknownLandmark {
                target: target(),
                landmark,
            });
        };
        let own = &self.all[k];
        if self.has_vertices && own.vertex != row.vertex {
            return Err(TargetDefect::OtherVertex {
                landmark,
                expected: own.vertex,
                found: row.vertex,
            });
        }
        let distance = distance(position, own.point.position(self.mesh.nodes()));
        if !(distance <= self.size) {
            return Err(TargetDefect::TooFar {
                landmark,
                target: target(),
                distance,
                size: self.size,
            });
        }
        if !(weight >= 0.0) {
            return Err(TargetDefect::Weight { weight });
        }
        let point = own.point;
        let goal = Goal {
            point,
            position,
            weight,
        };
        Ok((k, goal))
    }
}

/// The file of dense targets.
struct Dense<'a> {
    spec: &'a DenseSpec,
    file: MeshFile,
    skin: Skin,
    /// Of the skin's vertices, in the embedding.
    numbers: Vec<u32>,
}

impl<'a> Dense<'a> {
    fn read(
        place: &Place,
        spec: &'a DenseSpec,
        by_id: &BTreeMap<u32, EmbeddedPoint>,
    ) -> Result<Self, SceneError> {
        let path: PathBuf = place.file(&spec.file);
        let file = MeshFile::read(&path)?;
        let triangles = file.triangles()?;
        let vertices = file.point_integers(&spec.vertex)?;
        let (mut points, mut numbers) = (Vec::new(), Vec::new());
        for (n, vertex) in vertices.iter().enumerate() {
            let id = u32::try_from(*vertex).ok();
            let found = id.and_then(|id| Some((id, by_id.get(&id)?)));
            let (id, point) = found.ok_or_else(|| {
                let vertex = *vertex;
                SceneError::invalid(&path, Location::Point(n), TargetDefect::NoVertex { vertex })
            })?;
            points.push(*point);
            numbers.push(id);
        }
        let meters = |x: &[f64; 3]| x.map(|v| v * place.scale);
        let rest: Vec<[f64; 3]> = file.points.iter().map(meters).collect();
        if let Some(n) = rest.iter().position(|x| !x.iter().all(|v| v.is_finite())) {
            let point = Location::Point(n);
            return Err(SceneError::invalid(&path, point, TargetDefect::NotFinite));
        }
        let skin = Skin {
            points,
            rest,
            triangles,
        };
        Ok(Self {
            spec,
            file,
            skin,
            numbers,
        })
    }

    /// Where the skin's vertices should be, for each target.
    fn aim(&self, place: &Place, targets: &mut [Target]) -> Result<(), SceneError> {
        for target in targets {
            let name = format!("{}{}", self.spec.prefix, target.name);
            let displacement = self.file.point_vectors::<3>(&name)?;
            let goal =
                |(x, d): (&[f64; 3], &[f64; 3])| std::array::from_fn(|i| x[i] + place.scale * d[i]);
            target.dense = Some(self.skin.rest.iter().zip(&displacement).map(goal).collect());
        }
        Ok(())
    }
}

/// Other fields of the file are of no concern here.
#[derive(Deserialize)]
struct TruthEntry {
    jaw: Option<JawTruth>,
}
#[derive(Deserialize)]
struct JawTruth {
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
}

fn truth(path: &Path, targets: &mut [Target]) -> Result<(), SceneError> {
    let mut entries: BTreeMap<String, TruthEntry> = json::read(path)?;
    for target in targets {
        let jaw = entries.remove(&target.name).and_then(|entry| entry.jaw);
        target.jaw_truth = jaw.map(|jaw| AffineMap {
            matrix: jaw.rotation,
            // Meters by its name, whatever unit the scene's lengths have.
            translation: jaw.translation_m,
        });
    }
    Ok(())
}
