//! Muscles of a scene: names, and fibers from a sparse table, dense arrays or curves.

use super::courses::{Anatomy, Paper};
use super::defect::{Location, MuscleDefect};
use super::format::{FibersSpec, MusclesSpec, NamesSpec};
use super::load::Place;
use super::table::Table;
use super::{SceneError, json};
use face_rig::anatomy::{FiberEntry, FiberField, Muscle};
use fem_assembly::mesh::{MeshFile, SimplexMesh};
use serde::Deserialize;
use std::path::Path;

/// Other fields of the file are of no concern here.
#[derive(Deserialize)]
struct NamedMuscle {
    index: usize,
    name: String,
}

/// The muscles, their fibers, and what some have for themselves.
pub(super) fn load(
    paper: &Paper,
    spec: &MusclesSpec,
    file: &MeshFile,
) -> Result<(Anatomy, FiberField), SceneError> {
    let (place, mesh) = (paper.place, paper.mesh);
    let muscles = names(place, &spec.names)?;
    let count = muscles.len();
    let drawn = !spec.drawn.is_empty() || matches!(spec.fibers, Some(FibersSpec::Curves(_)));
    let field = match &spec.fibers {
        None => FiberField::default(),
        Some(FibersSpec::Table(table)) => from_table(&place.file(table), mesh, count)?,
        Some(FibersSpec::Arrays {
            muscle,
            weight,
            fiber,
        }) => from_arrays(file, [muscle, fiber], weight.as_deref(), count)?,
        Some(FibersSpec::Curves(curves)) => {
            let entries = paper.of_file(&place.file(curves), &muscles)?;
            checked(place, entries, mesh, count)?
        }
    };
    let mut anatomy = Anatomy {
        muscles,
        entries: field.entries().to_vec(),
        ..Anatomy::default()
    };
    paper.leave_out(&mut anatomy, &spec.without)?;
    paper.add(&mut anatomy, &spec.drawn)?;
    paper.set_own(&mut anatomy, &spec.own)?;
    if drawn {
        anatomy.make_room();
    }
    paper.divide(&mut anatomy, &spec.bundles)?;
    let entries = std::mem::take(&mut anatomy.entries);
    let field = checked(place, entries, mesh, anatomy.muscles.len())?;
    Ok((anatomy, field))
}

fn checked(
    place: &Place,
    entries: Vec<FiberEntry>,
    mesh: &SimplexMesh<3>,
    muscles: usize,
) -> Result<FiberField, SceneError> {
    let field = FiberField::new(entries, mesh.num_elements(), muscles);
    field.map_err(|error| place.field("face.files.muscles", error))
}

fn names(place: &Place, spec: &NamesSpec) -> Result<Vec<Muscle>, SceneError> {
    let (path, names) = match spec {
        NamesSpec::List(names) => (place.path.to_path_buf(), names.clone()),
        NamesSpec::File(file) => {
            let path = place.file(file);
            let listed: Vec<NamedMuscle> = json::read(&path)?;
            for (expected, muscle) in listed.iter().enumerate() {
                if muscle.index != expected {
                    let defect = MuscleDefect::Order {
                        name: muscle.name.clone(),
                        found: muscle.index,
                        expected,
                    };
                    let field = format!("[{expected}].index");
                    return Err(SceneError::invalid(&path, field, defect));
                }
            }
            (path, listed.into_iter().map(|m| m.name).collect())
        }
    };
    for (k, name) in names.iter().enumerate() {
        let unusable = name.is_empty() || name.contains('=');
        if unusable || names[..k].contains(name) {
            let defect = MuscleDefect::Name { name: name.clone() };
            return Err(SceneError::invalid(&path, Location::Name(k), defect));
        }
    }
    Ok(names.into_iter().map(|name| Muscle { name }).collect())
}

fn from_table(
    path: &Path,
    mesh: &SimplexMesh<3>,
    muscles: usize,
) -> Result<FiberField, SceneError> {
    let table = Table::read(path, &["tet", "muscle", "weight", "fx", "fy", "fz"])?;
    let (mut entries, mut lines) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let row = row?;
        entries.push(FiberEntry {
            tet: row.index(0)?,
            muscle: row.index(1)?,
            weight: row.number(2)?,
            direction: row.numbers(3)?,
        });
        lines.push(row.line);
    }
    if entries.is_empty() {
        let line = Location::Line(2);
        return Err(SceneError::invalid(path, line, MuscleDefect::NoFibers));
    }
    FiberField::new(entries, mesh.num_elements(), muscles).map_err(|error| {
        let line = Location::Line(lines[error.entry()]);
        SceneError::invalid(path, line, error)
    })
}

fn from_arrays(
    file: &MeshFile,
    [muscle, fiber]: [&str; 2],
    weight: Option<&str>,
    muscles: usize,
) -> Result<FiberField, SceneError> {
    let labels = file.cell_integers(muscle)?;
    let directions = file.cell_vectors::<3>(fiber)?;
    let weights = match weight {
        Some(name) => file.cell_scalars(name)?,
        None => vec![1.0; labels.len()],
    };
    let mut entries = Vec::new();
    for (tet, &label) in labels.iter().enumerate() {
        if label == -1 {
            continue;
        }
        let Some(index) = u32::try_from(label).ok() else {
            let name = muscle.to_owned();
            let location = Location::CellArray { name, cell: tet };
            let defect = MuscleDefect::Unknown { label };
            return Err(SceneError::invalid(&file.path, location, defect));
        };
        entries.push(FiberEntry {
            tet: tet as u32,
            muscle: index,
            weight: weights[tet],
            direction: directions[tet],
        });
    }
    let tets: Vec<u32> = entries.iter().map(|e| e.tet).collect();
    FiberField::new(entries, labels.len(), muscles).map_err(|error| {
        let cell = Location::Cell(tets[error.entry()] as usize);
        SceneError::invalid(&file.path, cell, error)
    })
}
