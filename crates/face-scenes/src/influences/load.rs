//! From a scene file to its influences, with every inconsistency an error that says where.

use super::places::Body;
use super::spec::{
    CavitySpec, ClosureSpec, LoadSpec, MotionSpec, PlaceSpec, StiffnessSpec, StrengthSpec,
};
use super::{Influence, InfluenceKind};
use crate::defect::InfluenceDefect;
use crate::load::Place;
use crate::names::{meant, similar};
use crate::shape::{Shape, ShapeSpec, shapes};
use crate::{Region, SceneError, SceneFile};
use face_rig::anatomy::{Bone, Bones, Muscle};
use fem_assembly::mesh::{MeshFile, SimplexMesh};
use fem_assembly::{AssemblyError, Cavity, NodalLoads, RigidSurface};

/// A face as far as influences ask for it.
pub(crate) struct Ground<'a> {
    pub mesh: &'a SimplexMesh<3>,
    pub bones: &'a Bones,
    pub muscles: &'a [Muscle],
    pub regions: &'a [Region],
    pub region_of_tet: &'a [u32],
}

pub(crate) fn load(
    place: &Place,
    scene: &SceneFile,
    ground: &Ground,
    file: Option<&MeshFile>,
) -> Result<Vec<Influence>, SceneError> {
    let reader = Reader {
        body: Body {
            place,
            mesh: ground.mesh,
            file,
            regions: ground.regions,
            region_of_tet: ground.region_of_tet,
        },
        ground,
    };
    let mut all = Vec::new();
    for (k, spec) in scene.loads.iter().enumerate() {
        all.push((
            format!("loads[{k}]"),
            reader.a_load(&format!("loads[{k}]"), spec)?,
        ));
    }
    for (k, spec) in scene.cavities.iter().enumerate() {
        let field = format!("cavities[{k}]");
        let cavity = reader.a_cavity(&field, spec)?;
        all.push((field, cavity));
    }
    for (k, spec) in scene.motions.iter().enumerate() {
        let field = format!("motions[{k}]");
        let motion = reader.a_motion(&field, spec)?;
        all.push((field, motion));
    }
    for (k, spec) in scene.strengths.iter().enumerate() {
        let field = format!("strengths[{k}]");
        let strength = reader.a_strength(&field, spec)?;
        all.push((field, strength));
    }
    for (k, spec) in scene.stiffnesses.iter().enumerate() {
        let field = format!("stiffnesses[{k}]");
        let stiffness = reader.a_stiffness(&field, spec)?;
        all.push((field, stiffness));
    }
    check_all(place, &all)?;
    Ok(all.into_iter().map(|(_, influence)| influence).collect())
}

/// Names are unique, ranges are ranges, and no muscle or region is changed twice; motions add up.
fn check_all(place: &Place, all: &[(String, Influence)]) -> Result<(), SceneError> {
    for (k, (field, influence)) in all.iter().enumerate() {
        let name = &influence.name;
        let named_before = all[..k].iter().any(|(_, other)| other.name == *name);
        if name.is_empty() || name.contains('=') || named_before {
            let name = name.clone();
            return Err(place.field(format!("{field}.name"), InfluenceDefect::Name { name }));
        }
        let neutral = influence.neutral;
        if let Some([low, high]) = influence.range
            && !(low < high && (high - low).is_finite() && low <= neutral && neutral <= high)
        {
            let defect = InfluenceDefect::Range { low, high, neutral };
            return Err(place.field(format!("{field}.range"), defect));
        }
        if !neutral.is_finite() {
            let value = neutral;
            return Err(place.field(field.as_str(), InfluenceDefect::NotFinite { value }));
        }
        let twice = all[..k].iter().find(|(_, other)| overlap(other, influence));
        if let Some((first, _)) = twice {
            let first = first.clone();
            return Err(place.field(field.as_str(), InfluenceDefect::Twice { first }));
        }
    }
    Ok(())
}

fn overlap(a: &Influence, b: &Influence) -> bool {
    match (&a.kind, &b.kind) {
        (
            InfluenceKind::Strength { muscles },
            InfluenceKind::Strength {
                muscles: others, ..
            },
        ) => muscles.iter().any(|m| others.contains(m)),
        (InfluenceKind::Stiffness { region }, InfluenceKind::Stiffness { region: other }) => {
            region == other
        }
        _ => false,
    }
}

/// A factor is 1, or where it may vary 0 or what is nearest to it.
fn factor(range: Option<[f64; 2]>) -> f64 {
    range.map_or(1.0, |[low, high]| 0.0_f64.max(low).min(high))
}

struct Reader<'a> {
    body: Body<'a>,
    ground: &'a Ground<'a>,
}

impl Reader<'_> {
    fn a_load(&self, field: &str, spec: &LoadSpec) -> Result<Influence, SceneError> {
        match spec {
            LoadSpec::Gravity {
                name,
                density,
                acceleration,
                range,
            } => self.a_weight(field, name, *density, *acceleration, *range),
            LoadSpec::Springs {
                name,
                at,
                stiffness,
                to,
                range,
            } => {
                let nodes = self.body.nodes(&format!("{field}.at"), at)?;
                self.a_spring(field, name, &nodes, *stiffness, *to, *range)
            }
            LoadSpec::Penalty {
                name,
                at,
                stiffness,
                shape,
                range,
            } => {
                let nodes = self.body.nodes(&format!("{field}.at"), at)?;
                let kind = self.penalties(field, &nodes, *stiffness, shape)?;
                if range.is_some_and(|[low, _]| low < 0.0) {
                    let place = self.body.place;
                    return Err(place.field(format!("{field}.range"), InfluenceDefect::Pulls));
                }
                Ok(Influence {
                    name: name.clone(),
                    neutral: factor(*range),
                    range: *range,
                    kind,
                })
            }
            LoadSpec::Force { name, range, .. }
            | LoadSpec::Traction { name, range, .. }
            | LoadSpec::Pressure { name, range, .. } => Ok(Influence {
                name: name.clone(),
                neutral: factor(*range),
                range: *range,
                kind: InfluenceKind::Forces(self.forces(field, spec)?),
            }),
        }
    }

    /// Dead forces on nodes, newtons; none of what is no force.
    fn forces(&self, field: &str, spec: &LoadSpec) -> Result<Vec<(usize, [f64; 3])>, SceneError> {
        let rest = self.ground.mesh.nodes();
        let faces = |on: &PlaceSpec| self.body.faces(&format!("{field}.on"), on);
        let loads = match spec {
            LoadSpec::Force { at, newtons, .. } => {
                let nodes = self.body.nodes(&format!("{field}.at"), at)?;
                let share = newtons.map(|f| f / nodes.len() as f64);
                NodalLoads::new(nodes.into_iter().map(|n| (n as usize, share)).collect())
            }
            LoadSpec::Traction { on, pascals, .. } => {
                NodalLoads::traction(rest, &faces(on)?, *pascals)
            }
            LoadSpec::Pressure { on, pascals, .. } => {
                NodalLoads::pressure(rest, &faces(on)?, *pascals)
            }
            _ => return Ok(Vec::new()),
        };
        let loads = loads.map_err(|e: AssemblyError| self.body.place.field(field, e))?;
        Ok(loads.into_forces())
    }

    fn a_weight(
        &self,
        field: &str,
        name: &str,
        density: f64,
        acceleration: [f64; 3],
        range: Option<[f64; 2]>,
    ) -> Result<Influence, SceneError> {
        if !(density > 0.0 && density.is_finite() && acceleration.iter().all(|g| g.is_finite())) {
            return Err(self.body.place.field(field, InfluenceDefect::Gravity));
        }
        Ok(Influence {
            name: name.into(),
            neutral: factor(range),
            range,
            kind: InfluenceKind::Gravity {
                density,
                acceleration,
            },
        })
    }

    fn a_spring(
        &self,
        field: &str,
        name: &str,
        nodes: &[u32],
        stiffness: f64,
        to: Option<[f64; 3]>,
        range: Option<[f64; 2]>,
    ) -> Result<Influence, SceneError> {
        let scale = self.body.place.scale;
        let to = to.map(|p| p.map(|c| c * scale));
        let finite = to.is_none_or(|p| p.iter().all(|c| c.is_finite()));
        if !(stiffness >= 0.0 && stiffness.is_finite() && finite) {
            return Err(self.body.place.field(field, InfluenceDefect::Springs));
        }
        if range.is_some_and(|[low, _]| low < 0.0) {
            let place = self.body.place;
            return Err(place.field(format!("{field}.range"), InfluenceDefect::Pushes));
        }
        let end = |&n: &u32| (n as usize, to.unwrap_or_else(|| self.ground.mesh.node(n)));
        Ok(Influence {
            name: name.into(),
            neutral: factor(range),
            range,
            kind: InfluenceKind::Springs {
                ends: nodes.iter().map(end).collect(),
                stiffness,
            },
        })
    }

    fn penalties(
        &self,
        field: &str,
        nodes: &[u32],
        stiffness: f64,
        shape: &ShapeSpec,
    ) -> Result<InfluenceKind, SceneError> {
        let place = self.body.place;
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            let defect = InfluenceDefect::Penalty { stiffness };
            return Err(place.field(format!("{field}.stiffness"), defect));
        }
        if matches!(shape, ShapeSpec::Triangles { .. }) {
            return Err(place.field(format!("{field}.shape"), InfluenceDefect::Triangles));
        }
        // Neither number has a part in a shape that is no surface of triangles.
        let shapes = shapes(place, field, shape, 1.0, 1.0)?;
        let implicit = |shape: Shape| match shape.surface {
            RigidSurface::Implicit(surface) => Some(surface),
            _ => None,
        };
        let obstacles: Vec<_> = shapes.into_iter().filter_map(implicit).collect();
        if obstacles.is_empty() {
            return Err(place.field(format!("{field}.shape"), InfluenceDefect::NoObstacle));
        }
        Ok(InfluenceKind::Penalties {
            nodes: nodes.iter().map(|&n| n as usize).collect(),
            stiffness,
            obstacles,
        })
    }

    fn a_cavity(&self, field: &str, spec: &CavitySpec) -> Result<Influence, SceneError> {
        let place = self.body.place;
        let unusable = |e: AssemblyError| place.field(format!("{field}.faces"), e);
        let faces = Cavity::turned(self.body.faces(&format!("{field}.faces"), &spec.faces)?);
        let on_bone = |n: u32| self.ground.bones.of_node()[n as usize] != Bone::Free;
        let (cavity, apex) = match spec.closed_by {
            ClosureSpec::Fan => (Cavity::capped(faces, 1.0, on_bone), None),
            ClosureSpec::Nothing => (Cavity::closed(faces, 1.0), None),
            ClosureSpec::Point(point) => {
                let apex = point.map(|c| c * place.scale);
                (Cavity::about(faces, apex, 1.0), Some(apex))
            }
        };
        let cavity = cavity.map_err(unusable)?;
        if spec.range.is_none() && spec.pascals == 0.0 {
            return Err(place.field(field, InfluenceDefect::NoPressure));
        }
        Ok(Influence {
            name: spec.name.clone(),
            neutral: spec.pascals,
            range: spec.range,
            kind: InfluenceKind::Cavity {
                faces: cavity.faces().to_vec(),
                apex,
            },
        })
    }

    fn a_motion(&self, field: &str, spec: &MotionSpec) -> Result<Influence, SceneError> {
        let place = self.body.place;
        let mut nodes = self.body.nodes(&format!("{field}.nodes"), &spec.nodes)?;
        nodes.retain(|&n| self.ground.bones.of_node()[n as usize] == Bone::Free);
        if nodes.is_empty() {
            return Err(place.field(format!("{field}.nodes"), InfluenceDefect::OnBone));
        }
        let axis = |letter: char| "xyz".find(letter);
        let axes: Option<Vec<usize>> = spec.axes.chars().map(axis).collect();
        let axes = axes.filter(|axes| !axes.is_empty() && axes.is_sorted_by(|a, b| a < b));
        let Some(axes) = axes else {
            let axes = spec.axes.clone();
            return Err(place.field(format!("{field}.axes"), InfluenceDefect::Axes { axes }));
        };
        let by = spec.by.map(|d| d * place.scale);
        if !by.iter().all(|d| d.is_finite()) {
            return Err(place.field(format!("{field}.by"), InfluenceDefect::Way));
        }
        if let Some(k) = (0..3).find(|k| by[*k] != 0.0 && !axes.contains(k)) {
            let axis = ['x', 'y', 'z'][k];
            return Err(place.field(format!("{field}.by"), InfluenceDefect::FreeAxis { axis }));
        }
        let moved = nodes
            .iter()
            .flat_map(|&n| axes.iter().map(move |&k| (n as usize, k, by[k])));
        Ok(Influence {
            name: spec.name.clone(),
            neutral: factor(spec.range),
            range: spec.range,
            kind: InfluenceKind::Motion(moved.collect()),
        })
    }

    fn a_strength(&self, field: &str, spec: &StrengthSpec) -> Result<Influence, SceneError> {
        let wanted = spec.muscle.as_str();
        let names = || self.ground.muscles.iter().map(|m| m.name.as_str());
        let found = meant(wanted, names());
        if found.is_empty() {
            let defect = InfluenceDefect::UnknownMuscle {
                name: wanted.to_owned(),
                similar: similar(wanted, names()),
            };
            return Err(self.body.place.field(format!("{field}.muscle"), defect));
        }
        self.at_least_nothing(field, spec.change, spec.range)?;
        Ok(Influence {
            name: spec.name.clone(),
            neutral: spec.change,
            range: spec.range,
            kind: InfluenceKind::Strength {
                muscles: found.into_iter().map(|m| m as u32).collect(),
            },
        })
    }

    fn a_stiffness(&self, field: &str, spec: &StiffnessSpec) -> Result<Influence, SceneError> {
        let region = self.body.region(&format!("{field}.region"), &spec.region)?;
        self.at_least_nothing(field, spec.change, spec.range)?;
        Ok(Influence {
            name: spec.name.clone(),
            neutral: spec.change,
            range: spec.range,
            kind: InfluenceKind::Stiffness { region },
        })
    }

    /// What is changed by less than −1 pushes the wrong way.
    fn at_least_nothing(
        &self,
        field: &str,
        change: f64,
        range: Option<[f64; 2]>,
    ) -> Result<(), SceneError> {
        let lowest = range.map_or(change, |[low, _]| low.min(change));
        if lowest >= -1.0 {
            return Ok(());
        }
        let defect = InfluenceDefect::BelowNothing { lowest };
        Err(self.body.place.field(field, defect))
    }
}
