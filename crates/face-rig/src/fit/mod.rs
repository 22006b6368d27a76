//! From what is seen to θ: the fit of activations, jaw and head pose by Gauss-Newton.

mod expression;
mod parametrization;
mod problem;
mod rotation;

pub use expression::{ExpressionFit, Observed, Outcome, fit_expression};
pub use parametrization::{CraniumModel, JawModel, Parametrization};
pub use problem::{FitError, FitIteration, FitParams, FitReport, Fitter, Orthogonality};
