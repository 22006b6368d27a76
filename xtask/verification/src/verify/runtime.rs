//! Materials chosen by name while the program runs, for files that name them.

use crate::numbers::{by_rows, entries};
use fem_kinematics::Mat;
use fem_materials::registry::{Entry, ModelVisitor, ParameterError, Parameters, for_each_model};
use fem_materials::{HessianProjection, Material, Outlined};
use std::collections::BTreeMap;

/// A material behind a pointer; matrices are slices by rows.
pub trait RuntimeMaterial {
    /// ψ.
    fn energy(&self, F: &[f64]) -> f64;
    /// P.
    fn stress(&self, F: &[f64]) -> Vec<f64>;
    /// ∂P/∂F, D² × D².
    fn derivative_rows(&self, F: &[f64]) -> Vec<f64>;
    /// ∂P/∂F with its negative eigenvalues clamped.
    fn clamped_rows(&self, F: &[f64]) -> Vec<f64>;
}

struct Bound<M, const D: usize>(M);

impl<M: Material<D>, const D: usize> Bound<M, D> {
    fn matrix(F: &[f64]) -> Mat<f64, D> {
        Mat::from_fn(|i, j| F[D * i + j])
    }
}

impl<M: Material<D>, const D: usize> RuntimeMaterial for Bound<M, D> {
    fn energy(&self, F: &[f64]) -> f64 {
        self.0.energy(&Self::matrix(F))
    }
    fn stress(&self, F: &[f64]) -> Vec<f64> {
        entries(&self.0.stress(&Self::matrix(F)))
    }
    fn derivative_rows(&self, F: &[f64]) -> Vec<f64> {
        by_rows(&self.0.stress_derivative(&Self::matrix(F)))
    }
    fn clamped_rows(&self, F: &[f64]) -> Vec<f64> {
        let projection = HessianProjection::Clamp;
        by_rows(&self.0.projected_derivative(&Self::matrix(F), projection))
    }
}

/// Why no material was made.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// Nothing has this name in this dimension.
    #[error("no registered model is called `{name}` in {dimension}D")]
    Unknown {
        /// The name.
        name: String,
        /// 2 or 3.
        dimension: usize,
    },
    /// The parameters don't fit.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
}

/// Builds a registered model and hands it to `use_it`.
///
/// # Errors
/// If there is no such model, or its parameters don't fit.
pub fn with_material(
    name: &str,
    dimension: usize,
    parameters: &BTreeMap<String, String>,
    use_it: impl FnOnce(&dyn RuntimeMaterial),
) -> Result<(), BuildError> {
    let mut finder = Finder {
        name,
        dimension,
        parameters: parameters
            .iter()
            .map(|(k, v)| (k.clone(), v.clone()))
            .collect(),
        use_it: Some(use_it),
        result: Err(BuildError::Unknown {
            name: name.to_owned(),
            dimension,
        }),
    };
    for_each_model(&mut finder);
    finder.result
}

struct Finder<'a, U> {
    name: &'a str,
    dimension: usize,
    parameters: Parameters,
    use_it: Option<U>,
    result: Result<(), BuildError>,
}

impl<U: FnOnce(&dyn RuntimeMaterial)> ModelVisitor for Finder<'_, U> {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        if !entry.is(self.name) || D != self.dimension {
            return;
        }
        self.result = match entry.build(&self.parameters) {
            Ok(material) => {
                if let Some(use_it) = self.use_it.take() {
                    use_it(&Bound::<Outlined<M>, D>(Outlined(material)));
                }
                Ok(())
            }
            Err(error) => Err(error.into()),
        };
    }
}
