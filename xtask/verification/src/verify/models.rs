//! Every registered model: its table, and the conformance suite with fresh random numbers.

use super::VerifyError;
use super::materials;
use super::table::Table;
use crate::numbers::entries;
use crate::report::Report;
use crate::shared::read_json;
use fem_kinematics::Mat;
use fem_materials::conformance::{Claim, Suite};
use fem_materials::field::MaterialField;
use fem_materials::registry::{Entry, ModelVisitor, Parameters, for_each_model};
use fem_materials::{Fiber, Material, Muscle, Outlined};
use std::any::Any;
use std::path::Path;

/// Models that are no hyperelastic law, or promise less than the rest, and why.
pub fn claims(name: &str) -> Vec<Claim> {
    let mut claims = Vec::new();
    // The infinitesimal strain sees rotations; that is what makes it linear.
    if name != "linear" {
        claims.push(Claim::Objective);
    }
    // Ground substance in closed blocks plus fibers in closed form, each projected on its own.
    if name.starts_with("muscle") || ["hgo", "qr_aniso", "qr_damage"].contains(&name) {
        claims.push(Claim::ProjectedByTerms);
    }
    claims
}

/// Compares every registered model that has a table in `folder` with it; says which have none.
///
/// # Errors
/// If a table can't be read.
pub fn check_tables(folder: &Path, report: &mut Report) -> Result<Vec<String>, VerifyError> {
    let mut visitor = Tables {
        folder,
        report,
        without: Vec::new(),
        seen: Vec::new(),
        error: None,
    };
    for_each_model(&mut visitor);
    if let Some(error) = visitor.error {
        return Err(error);
    }
    let (without, seen) = (visitor.without, visitor.seen);
    for file in constitutive_tables(folder)? {
        if !seen.contains(&file) {
            report.broken(format!("{file}.json: no registered model has this name"));
        }
    }
    Ok(without)
}

/// The names of all files that are tables of a model.
fn constitutive_tables(folder: &Path) -> Result<Vec<String>, VerifyError> {
    const OTHERS: [&str; 4] = ["kinematics", "elements", "lame", "muscle_curves"];
    let listing = std::fs::read_dir(folder).map_err(|source| VerifyError::Folder {
        path: folder.to_path_buf(),
        source,
    })?;
    let mut names: Vec<String> = listing
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(".json").map(str::to_owned))
        .filter(|name| !OTHERS.iter().any(|other| name.starts_with(other)))
        .collect();
    names.sort();
    Ok(names)
}

/// ∂P/∂α of the models with fibers, `None` for the others.
fn stress_by_activation<const D: usize>(material: &dyn Any, F: &Mat<f64, D>) -> Option<Vec<f64>> {
    let fiber = match material.downcast_ref::<Muscle>() {
        Some(muscle) => &muscle.1,
        None => material.downcast_ref::<Fiber>()?,
    };
    let F: Mat<f64, 3> = (D == 3).then(|| Mat::from_fn(|i, j| F[(i, j)]))?;
    Some(entries(&fiber.field.stress_by_control(&fiber.local, &F)))
}

struct Tables<'a> {
    folder: &'a Path,
    report: &'a mut Report,
    without: Vec<String>,
    seen: Vec<String>,
    error: Option<VerifyError>,
}

impl ModelVisitor for Tables<'_> {
    fn visit<M: Material<D> + 'static, const D: usize>(&mut self, entry: &Entry<M>) {
        let name = format!("{}_{D}d", entry.name);
        // Some tables bear another name of the model.
        let names = [entry.name]
            .into_iter()
            .chain(entry.aliases.iter().copied());
        let mut files = names.map(|name| format!("{name}_{D}d"));
        let is_there = |file: &String| self.folder.join(format!("{file}.json")).is_file();
        let Some(file) = files.find(is_there) else {
            self.without.push(name);
            return;
        };
        let path = self.folder.join(format!("{file}.json"));
        let table: Table = match read_json(&path) {
            Ok(table) => table,
            Err(error) => {
                self.error.get_or_insert(error.into());
                return;
            }
        };
        let mut materials = Vec::new();
        for set in &table.params {
            let parameters: Parameters = set.iter().map(|(k, v)| (k.clone(), v.clone())).collect();
            match entry.build(&parameters) {
                Ok(material) => materials.push(Some(material)),
                Err(error) => {
                    self.report.broken(format!("{name}: {error}"));
                    materials.push(None);
                }
            }
        }
        materials::check::<D, _>(
            &table,
            |p| materials.get(p).copied().flatten().map(Outlined),
            |p, F| stress_by_activation(materials.get(p)?.as_ref()?, F),
            self.report,
        );
        self.seen.push(file);
    }
}

/// Runs the conformance suite on every registered model with its default parameters.
pub fn check_conformance(seed: u64, rounds: usize, report: &mut Report) {
    for_each_model(&mut Conformance {
        seed,
        rounds,
        report,
    });
}

struct Conformance<'a> {
    seed: u64,
    rounds: usize,
    report: &'a mut Report,
}

impl ModelVisitor for Conformance<'_> {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        let name = format!("{} {D}D", entry.name);
        let material = match entry.build(&entry.defaults()) {
            Ok(material) => material,
            Err(error) => {
                self.report.broken(format!(
                    "{name}: its own default parameters are refused: {error}"
                ));
                return;
            }
        };
        let suite = Suite {
            seed: self.seed,
            rounds: self.rounds,
            claims: &claims(entry.name),
        };
        for finding in suite.check::<D, M>(&material).findings {
            let id = format!("{:?}", finding.deformation_gradient);
            self.report.record(
                &format!("conformance {D}D"),
                finding.property.short(),
                entry.name,
                &id,
                finding.reached,
                finding.bound,
            );
        }
    }
}
