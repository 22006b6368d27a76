//! Points on the skin of a scene: embedding, landmarks and the expressions to fit.

use super::format::{DenseSpec, FilesSpec, LandmarksSpec, TargetsSpec};
use super::load::Place;
use super::table::Table;
use super::{Landmark, SceneError, Skin, Target, TargetKind, json};
use face_rig::anatomy::{AffineMap, EmbeddedPoint, TetLocator};
use face_rig::fit::Goal;
use fem_assembly::mesh::{MeshFile, Repairs, SimplexMesh};
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// A landmark may lie this share of the face's diagonal beside the mesh, or its embedded place beside
/// the stated one: 3 mm on a head.
const TOLERANCE: f64 = 0.01;

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

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// A target's name becomes that of its result files.
fn usable_name(name: &str) -> bool {
    let forbidden = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    !name.is_empty() && !name.starts_with('.') && !name.contains(forbidden)
}

/// The targets of a face, and the skin of the dense ones.
pub(super) fn load(
    place: &Place,
    spec: &TargetsSpec,
    mesh: &SimplexMesh<3>,
    landmarks: &[Landmark],
    embedding: &BTreeMap<u32, EmbeddedPoint>,
) -> Result<(Option<Skin>, Vec<Target>), SceneError> {
    if landmarks.is_empty() {
        let reason = "targets need landmarks; add \"landmarks\" to the face";
        return Err(place.field("targets", reason));
    }
    let mut targets = sparse(place, spec, landmarks, mesh, !embedding.is_empty())?;
    let skin = match &spec.dense {
        Some(dense_spec) => Some(dense(place, dense_spec, embedding, &mut targets)?),
        None => None,
    };
    if let Some(file) = &spec.truth {
        truth(&place.file(file), &mut targets)?;
    }
    Ok((skin, targets))
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
            let reason = format!(
                "tet {tet} is not in the mesh, which has {tets}; is this the table of another mesh?"
            );
            return Err(row.error(reason));
        }
        let sum: f64 = weights.iter().sum();
        let partition = (sum - 1.0).abs() <= 1e-4;
        if !partition {
            return Err(row.error(format!("the weights sum to {sum}, not to 1")));
        }
        weights = weights.map(|w| w / sum);
        if weights.iter().any(|w| *w < -1.0) {
            let reason = format!("the point lies far outside tet {tet} (weights {weights:?})");
            return Err(row.error(reason));
        }
        if let Some(line) = seen.insert(id, row.line) {
            return Err(row.error(format!("vertex {id} is already on line {line}")));
        }
        if repairs.inverted.binary_search(&tet).is_ok() {
            // The table was made for the file's order of the nodes.
            weights.swap(2, 3);
        }
        let nodes = mesh.tet(tet as usize);
        points.insert(id, EmbeddedPoint { nodes, weights });
    }
    if points.is_empty() {
        return Err(SceneError::invalid(table.path(), "table", "it has no rows"));
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
            let line = twice.line;
            let reason = format!("landmark {landmark} of \"{name}\" is already on line {line}");
            return Err(row.error(reason));
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
        let reason = format!(
            "no rows of target \"{}\", which gives the landmarks at rest",
            spec.rest
        );
        return Err(SceneError::invalid(&path, "table", reason));
    };
    let locator = by_id.is_none().then(|| TetLocator::new(mesh));
    let mut landmarks = Vec::with_capacity(rows.len());
    for row in rows {
        let error = |reason: String| {
            let line = format!("line {}", row.line);
            SceneError::invalid(&path, line, format!("landmark {}: {reason}", row.landmark))
        };
        let point = match (by_id, &locator) {
            (Some(by_id), _) => *by_id.get(&row.vertex).ok_or_else(|| {
                error(format!(
                    "vertex {} is not in the embedding table",
                    row.vertex
                ))
            })?,
            (None, locator) => {
                let found = locator.as_ref().and_then(|l| l.locate(row.position));
                found
                    .filter(|f| f.distance <= tolerance)
                    .map(|f| f.embed(mesh))
                    .ok_or_else(|| {
                        error(format!(
                            "{:?} lies outside the mesh; check units and axes",
                            row.position
                        ))
                    })?
            }
        };
        let embedded = point.position(mesh.nodes());
        let off = distance(embedded, row.position);
        let fits = off <= tolerance;
        if !fits {
            let mm = off * 1e3;
            return Err(error(format!(
                "its embedded place is {mm:.1} mm from its position at rest; the embedding belongs to \
                 another mesh, or the units differ"
            )));
        }
        landmarks.push(Landmark {
            index: row.landmark,
            vertex: row.vertex,
            point,
        });
    }
    landmarks.sort_by_key(|l| l.index);
    Ok(landmarks)
}

fn sparse(
    place: &Place,
    spec: &TargetsSpec,
    landmarks: &[Landmark],
    mesh: &SimplexMesh<3>,
    has_vertices: bool,
) -> Result<Vec<Target>, SceneError> {
    let path = place.file(&spec.landmarks);
    let size = diagonal(mesh);
    let number: HashMap<u32, usize> = landmarks
        .iter()
        .enumerate()
        .map(|(k, l)| (l.index, k))
        .collect();
    let mut targets = Vec::new();
    for (name, rows) in landmark_rows(&path, place.scale)? {
        if spec.skip.contains(&name) {
            continue;
        }
        if !usable_name(&name) {
            let line = rows.first().map_or(1, |row| row.line);
            let reason = format!(
                "\"{name}\" cannot be a target's name, because result files are named after it; use \
                 letters, digits, spaces, - and _"
            );
            return Err(SceneError::invalid(&path, format!("line {line}"), reason));
        }
        let mut goals = Vec::with_capacity(rows.len());
        for row in &rows {
            let error = |reason: String| {
                let line = format!("line {}", row.line);
                Err(SceneError::invalid(&path, line, reason))
            };
            let Some(&k) = number.get(&row.landmark) else {
                let reason = format!(
                    "target \"{name}\" names landmark {}, which the face does not have",
                    row.landmark
                );
                return error(reason);
            };
            let own = &landmarks[k];
            if has_vertices && own.vertex != row.vertex {
                return error(format!(
                    "landmark {} is vertex {} of the face, not {}",
                    row.landmark, own.vertex, row.vertex
                ));
            }
            let off = distance(row.position, own.point.position(mesh.nodes()));
            if !(off <= size) {
                return error(format!(
                    "landmark {} of \"{name}\" lies {off:.3} m from its place at rest, and the whole \
                     face is {size:.3} m large; are these meters, and the same axes?",
                    row.landmark
                ));
            }
            if !(row.weight >= 0.0) {
                return error(format!("weight {} is not 0 or more", row.weight));
            }
            let point = own.point;
            let (position, weight) = (row.position, row.weight);
            let goal = Goal {
                point,
                position,
                weight,
            };
            goals.push((k, goal));
        }
        goals.sort_by_key(|&(k, _)| k);
        if !rows.iter().any(|row| row.weight > 0.0) {
            let reason = format!("all weights of target \"{name}\" are 0");
            return Err(SceneError::invalid(&path, "table", reason));
        }
        let identity = spec
            .identities
            .iter()
            .any(|start| name.starts_with(start.as_str()));
        targets.push(Target {
            name,
            kind: if identity {
                TargetKind::Identity
            } else {
                TargetKind::Expression
            },
            landmarks: goals.into_iter().map(|(_, goal)| goal).collect(),
            dense: None,
            jaw_truth: None,
        });
    }
    if targets.is_empty() {
        let reason = "there is no target in it (apart from those skipped)";
        return Err(SceneError::invalid(&path, "table", reason));
    }
    Ok(targets)
}

fn dense(
    place: &Place,
    spec: &DenseSpec,
    by_id: &BTreeMap<u32, EmbeddedPoint>,
    targets: &mut [Target],
) -> Result<Skin, SceneError> {
    let path: PathBuf = place.file(&spec.file);
    let file = MeshFile::read(&path)?;
    let triangles = file.triangles()?;
    let vertices = file.point_integers(&spec.vertex)?;
    let mut points = Vec::with_capacity(vertices.len());
    for (n, vertex) in vertices.iter().enumerate() {
        let found = u32::try_from(*vertex).ok().and_then(|id| by_id.get(&id));
        points.push(*found.ok_or_else(|| {
            let reason = format!("vertex {vertex} is not in the face's embedding table");
            SceneError::invalid(&path, format!("point {n}"), reason)
        })?);
    }
    let meters = |x: &[f64; 3]| x.map(|v| v * place.scale);
    let rest: Vec<[f64; 3]> = file.points.iter().map(meters).collect();
    if let Some(n) = rest.iter().position(|x| !x.iter().all(|v| v.is_finite())) {
        let reason = "its coordinates are not finite numbers";
        return Err(SceneError::invalid(&path, format!("point {n}"), reason));
    }
    for target in targets {
        let name = format!("{}{}", spec.prefix, target.name);
        let displacement = file.point_vectors::<3>(&name)?;
        let goal =
            |(x, d): (&[f64; 3], &[f64; 3])| std::array::from_fn(|i| x[i] + place.scale * d[i]);
        target.dense = Some(rest.iter().zip(&displacement).map(goal).collect());
    }
    Ok(Skin {
        points,
        rest,
        triangles,
    })
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
