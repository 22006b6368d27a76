//! Muscles, ligaments and regions that a scene draws as lines.

mod bundles;
mod file;
mod points;
mod spec;

pub(crate) use points::Paper;
pub use spec::{
    BundlesSpec, CourseSpec, DrawnMuscle, DrawnRegion, LigamentSpec, OverSpec, OwnFibersSpec,
    PlaceOnFace, PointSpec,
};

use crate::SceneError;
use crate::defect::CourseDefect;
use crate::names::{meant, similar};
use face_rig::anatomy::{Course, FiberEntry, Filling, Muscle, Share};
use points::Drawing;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What a muscle has for itself; what is left out all fibers share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnFibers {
    /// σ_max, Pa.
    pub max_isometric_stress: Option<f64>,
    /// λ_ofl.
    pub optimal_stretch: Option<f64>,
}

/// Passive fibers.
#[derive(Clone, Debug, PartialEq)]
pub struct Ligament {
    /// Its name.
    pub name: String,
    /// The elements that it fills.
    pub shares: Vec<Share>,
    /// E, Pa.
    pub stiffness: f64,
    /// The strain that straightens its fibers.
    pub toe: f64,
}

/// The muscles of a scene, and which elements they fill.
#[derive(Clone, Debug, Default)]
pub(crate) struct Anatomy {
    pub muscles: Vec<Muscle>,
    pub entries: Vec<FiberEntry>,
    pub own: BTreeMap<u32, OwnFibers>,
}

impl Paper<'_> {
    fn fill(&self, field: &str, name: &str, course: &Course) -> Result<Filling, SceneError> {
        course.fill(self.mesh, &self.locator).map_err(|error| {
            let name = name.to_owned();
            self.refuse(field, CourseDefect::Course { name, error })
        })
    }

    fn drawn(&self, drawing: Drawing) -> Result<Filling, SceneError> {
        let course = self.course(drawing)?;
        self.fill(drawing.field, drawing.name, &course)
    }

    /// The names of a drawing and whether each is its mirror image.
    fn names(
        &self,
        field: &str,
        name: &str,
        mirrored: bool,
    ) -> Result<Vec<(String, bool)>, SceneError> {
        if !mirrored {
            return Ok(vec![(name.to_owned(), false)]);
        }
        let stem = name.strip_suffix("_L").ok_or_else(|| {
            let name = name.to_owned();
            self.refuse(field, CourseDefect::NoSide { name })
        })?;
        Ok(vec![(name.to_owned(), false), (format!("{stem}_R"), true)])
    }

    fn positive(
        &self,
        field: &str,
        name: &str,
        what: &'static str,
        value: Option<f64>,
    ) -> Result<(), SceneError> {
        match value {
            Some(value) if !(value > 0.0 && value.is_finite()) => {
                let name = name.to_owned();
                let defect = CourseDefect::NotPositive { name, what, value };
                Err(self.refuse(field, defect))
            }
            _ => Ok(()),
        }
    }

    /// Muscles of a file of curves in place of a table.
    pub fn of_file(&self, path: &Path, muscles: &[Muscle]) -> Result<Vec<FiberEntry>, SceneError> {
        let courses = file::read(path)?;
        let mut entries = Vec::new();
        for (k, (name, course)) in courses.iter().enumerate() {
            let Some(muscle) = muscles.iter().position(|m| m.name == *name) else {
                continue;
            };
            let filling = course.fill(self.mesh, &self.locator).map_err(|error| {
                let name = name.clone();
                let field = format!("[{k}]");
                SceneError::invalid(path, field, CourseDefect::Course { name, error })
            })?;
            let shares = filling.shares.iter();
            entries.extend(shares.map(|share| entry(muscle as u32, share)));
        }
        Ok(entries)
    }

    /// Adds what the scene draws, or puts it in the place of what is known by that name.
    pub fn add(&self, anatomy: &mut Anatomy, drawn: &[DrawnMuscle]) -> Result<(), SceneError> {
        let mut seen = BTreeSet::new();
        for (k, muscle) in drawn.iter().enumerate() {
            let field = &format!("face.files.muscles.drawn[{k}]");
            let own = self.own(
                field,
                &muscle.name,
                [muscle.max_isometric_stress, muscle.optimal_stretch],
            )?;
            for (name, mirrored) in self.names(field, &muscle.name, muscle.mirrored)? {
                if !seen.insert(name.clone()) {
                    return Err(self.refuse(field, CourseDefect::Twice { name }));
                }
                let filling = self.drawn(Drawing {
                    field,
                    name: &name,
                    spec: &muscle.along,
                    mirrored,
                })?;
                let index = anatomy.place(name);
                anatomy.entries.retain(|entry| entry.muscle != index);
                let shares = filling.shares.iter();
                anatomy
                    .entries
                    .extend(shares.map(|share| entry(index, share)));
                anatomy.own.insert(index, own);
            }
        }
        Ok(())
    }

    /// Notes what some muscles have for themselves.
    pub fn set_own(&self, anatomy: &mut Anatomy, each: &[OwnFibersSpec]) -> Result<(), SceneError> {
        for (k, spec) in each.iter().enumerate() {
            let field = &format!("face.files.muscles.own[{k}]");
            for name in &spec.muscles {
                let own = [spec.max_isometric_stress, spec.optimal_stretch];
                let own = self.own(field, name, own)?;
                for index in self.muscles_named(field, name, &anatomy.muscles)? {
                    let known = anatomy.own.entry(index).or_default();
                    known.max_isometric_stress =
                        own.max_isometric_stress.or(known.max_isometric_stress);
                    known.optimal_stretch = own.optimal_stretch.or(known.optimal_stretch);
                }
            }
        }
        Ok(())
    }

    fn own(&self, field: &str, name: &str, own: [Option<f64>; 2]) -> Result<OwnFibers, SceneError> {
        let [max_isometric_stress, optimal_stretch] = own;
        self.positive(field, name, "max_isometric_stress", max_isometric_stress)?;
        self.positive(field, name, "optimal_stretch", optimal_stretch)?;
        Ok(OwnFibers {
            max_isometric_stress,
            optimal_stretch,
        })
    }

    /// Takes muscles out.
    pub fn leave_out(&self, anatomy: &mut Anatomy, without: &[String]) -> Result<(), SceneError> {
        let mut gone = BTreeSet::new();
        for (k, name) in without.iter().enumerate() {
            let field = &format!("face.files.muscles.without[{k}]");
            gone.extend(self.muscles_named(field, name, &anatomy.muscles)?);
        }
        let kept = (0..anatomy.muscles.len() as u32).filter(|m| !gone.contains(m));
        let number: BTreeMap<u32, u32> = kept.zip(0..).collect();
        let mut index = 0..;
        anatomy
            .muscles
            .retain(|_| index.next().is_some_and(|k| !gone.contains(&k)));
        anatomy
            .entries
            .retain_mut(|entry| match number.get(&entry.muscle) {
                Some(&new) => {
                    entry.muscle = new;
                    true
                }
                None => false,
            });
        Ok(())
    }

    /// The muscle of that name, or those of both sides.
    fn muscles_named(
        &self,
        field: &str,
        name: &str,
        muscles: &[Muscle],
    ) -> Result<Vec<u32>, SceneError> {
        let found = meant(name, muscles.iter().map(|m| m.name.as_str()));
        if found.is_empty() {
            let defect = CourseDefect::UnknownMuscle {
                name: name.to_owned(),
                similar: similar(name, muscles.iter().map(|m| m.name.as_str())),
            };
            return Err(self.refuse(field, defect));
        }
        Ok(found.into_iter().map(|m| m as u32).collect())
    }

    /// The scene's ligaments.
    pub fn ligaments(
        &self,
        specs: &[LigamentSpec],
        muscles: usize,
    ) -> Result<Vec<Ligament>, SceneError> {
        let mut ligaments = Vec::new();
        if let (Some(first), 0) = (specs.first(), muscles) {
            let name = first.name.clone();
            return Err(self.refuse("ligaments", CourseDefect::NoMuscle { name }));
        }
        for (k, spec) in specs.iter().enumerate() {
            let field = &format!("ligaments[{k}]");
            self.positive(field, &spec.name, "stiffness", Some(spec.stiffness))?;
            self.positive(field, &spec.name, "toe", Some(spec.toe))?;
            for (name, mirrored) in self.names(field, &spec.name, spec.mirrored)? {
                let filling = self.drawn(Drawing {
                    field,
                    name: &name,
                    spec: &spec.along,
                    mirrored,
                })?;
                ligaments.push(Ligament {
                    name,
                    shares: filling.shares,
                    stiffness: spec.stiffness,
                    toe: spec.toe,
                });
            }
        }
        Ok(ligaments)
    }

    /// The elements of a region, ascending.
    pub fn region(&self, field: &str, region: &DrawnRegion) -> Result<Vec<u32>, SceneError> {
        let (name, share) = (&region.name, region.share);
        self.positive(field, name, "share", Some(share))?;
        let mut tets = BTreeSet::new();
        for mirrored in [false, true] {
            if mirrored && !region.mirrored {
                continue;
            }
            let filling = self.drawn(Drawing {
                field,
                name,
                spec: &region.along,
                mirrored,
            })?;
            let full = filling.shares.iter().filter(|s| s.weight >= share);
            tets.extend(full.map(|s| s.tet));
        }
        if tets.is_empty() {
            let name = name.clone();
            return Err(self.refuse(field, CourseDefect::EmptyRegion { name, share }));
        }
        Ok(tets.into_iter().collect())
    }
}

impl Anatomy {
    /// The index of a muscle, which is added where there is none of that name.
    fn place(&mut self, name: String) -> u32 {
        let known = self.muscles.iter().position(|m| m.name == name);
        known.unwrap_or_else(|| {
            self.muscles.push(Muscle { name });
            self.muscles.len() - 1
        }) as u32
    }

    /// An element holds no more muscle than itself: where muscles interlace, each gives way by the
    /// same share.
    pub fn make_room(&mut self) {
        let mut sums = BTreeMap::<u32, f64>::new();
        for entry in &self.entries {
            *sums.entry(entry.tet).or_default() += entry.weight;
        }
        for entry in &mut self.entries {
            entry.weight /= sums[&entry.tet].max(1.0);
        }
    }
}

fn entry(muscle: u32, share: &Share) -> FiberEntry {
    FiberEntry {
        tet: share.tet,
        muscle,
        weight: share.weight,
        direction: share.direction,
    }
}
