//! Muscles of which parts contract by themselves.

use super::points::Paper;
use super::spec::BundlesSpec;
use super::{Anatomy, OwnFibers};
use crate::SceneError;
use crate::defect::CourseDefect;
use crate::names::bundle;
use face_rig::anatomy::{FiberEntry, Muscle, Piece, bundles};
use std::collections::{BTreeMap, BTreeSet};

/// Of a muscle for each of its bundles: with fewer they are parts of the mesh rather than of the muscle.
const FEWEST_ELEMENTS: usize = 8;

impl Paper<'_> {
    /// Puts bundles in the place of muscles that have some, each with what its muscle has for itself.
    pub fn divide(&self, anatomy: &mut Anatomy, specs: &[BundlesSpec]) -> Result<(), SceneError> {
        if specs.is_empty() {
            return Ok(());
        }
        let counts = self.counts(anatomy, specs)?;
        let whole = std::mem::take(anatomy);
        let mut entries_of = vec![Vec::new(); whole.muscles.len()];
        for entry in whole.entries {
            entries_of[entry.muscle as usize].push(entry);
        }
        for ((index, muscle), entries) in (0..).zip(whole.muscles).zip(entries_of) {
            let own = whole.own.get(&index);
            let most = counts.get(&index).copied().unwrap_or(1);
            match most.min(entries.len() / FEWEST_ELEMENTS) {
                0 | 1 => anatomy.append(muscle.name, own, entries),
                count => {
                    let pieces: Vec<Piece> = entries.iter().map(|e| self.piece(e)).collect();
                    let of_bundle = bundles(&pieces, count);
                    let last = of_bundle.iter().max().copied().unwrap_or(0);
                    for b in 0..=last {
                        let parts = entries.iter().zip(&of_bundle).filter(|(_, own)| **own == b);
                        let parts = parts.map(|(entry, _)| *entry).collect();
                        anatomy.append(bundle(&muscle.name, b + 1), own, parts);
                    }
                }
            }
        }
        self.check_names(&anatomy.muscles)
    }

    /// Into how many bundles each muscle is divided.
    fn counts(
        &self,
        anatomy: &Anatomy,
        specs: &[BundlesSpec],
    ) -> Result<BTreeMap<u32, usize>, SceneError> {
        let mut counts = BTreeMap::new();
        for (k, spec) in specs.iter().enumerate() {
            let field = &format!("face.files.muscles.bundles[{k}]");
            for name in &spec.muscles {
                let refuse = |defect| Err(self.refuse(field, defect));
                let name = || name.clone();
                if spec.count == 0 {
                    return refuse(CourseDefect::NoBundle { name: name() });
                }
                for index in self.muscles_named(field, &name(), &anatomy.muscles)? {
                    if counts.insert(index, spec.count).is_some() {
                        return refuse(CourseDefect::DividedTwice { name: name() });
                    }
                }
            }
        }
        Ok(counts)
    }

    fn piece(&self, entry: &FiberEntry) -> Piece {
        let corners = self.mesh.tet(entry.tet as usize);
        let corners = corners.map(|n| self.mesh.nodes()[n as usize]);
        Piece {
            center: std::array::from_fn(|i| corners.iter().map(|x| x[i]).sum::<f64>() / 4.0),
            direction: entry.direction,
        }
    }

    /// A bundle may have got the name of another muscle.
    fn check_names(&self, muscles: &[Muscle]) -> Result<(), SceneError> {
        let mut seen = BTreeSet::new();
        match muscles.iter().find(|m| !seen.insert(&m.name)) {
            None => Ok(()),
            Some(muscle) => {
                let name = muscle.name.clone();
                let field = "face.files.muscles.bundles";
                Err(self.refuse(field, CourseDefect::NameOfBundle { name }))
            }
        }
    }
}

impl Anatomy {
    fn append(&mut self, name: String, own: Option<&OwnFibers>, entries: Vec<FiberEntry>) {
        let muscle = self.muscles.len() as u32;
        self.muscles.push(Muscle { name });
        self.own.extend(own.map(|own| (muscle, *own)));
        let entries = entries.into_iter();
        self.entries
            .extend(entries.map(|entry| FiberEntry { muscle, ..entry }));
    }
}
