//! From what is seen to θ: the fit of activations, jaw and head pose by Gauss-Newton.

mod goal;
mod parametrization;
mod problem;
mod rotation;
mod similarity;

pub use goal::{Goal, Goals};
pub use parametrization::{ControlModel, CraniumModel, JawModel, Parametrization};
pub use problem::{FitError, FitIteration, FitParams, FitReport, Fitter, Orthogonality};
pub use similarity::Similarity;
