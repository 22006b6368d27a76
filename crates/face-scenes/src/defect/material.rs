//! Materials and the fibers' curves.

use crate::names::DidYouMean;
use fem_materials::curves::CurveError;
use fem_materials::registry::{ModelError, ParameterError};

/// What is wrong with a material.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialDefect {
    /// No preset of that name.
    #[error(
        "there is no preset \"{name}\"; there are {}{}",
        known.join(", "),
        DidYouMean(similar)
    )]
    UnknownPreset {
        /// The name.
        name: String,
        /// Those that exist.
        known: Vec<&'static str>,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// No model of that name.
    #[error(
        "there is no model \"{name}\"; there are {}{}",
        known.join(", "),
        DidYouMean(similar)
    )]
    UnknownModel {
        /// The name.
        name: String,
        /// Those that exist.
        known: Vec<&'static str>,
        /// A name that is almost the same.
        similar: Option<String>,
    },
    /// Parameters that do not fit.
    #[error(transparent)]
    Model(Box<ModelError>),
    /// The material of a region.
    #[error("{region}: {defect}")]
    InRegion {
        /// The region.
        region: String,
        /// What is wrong with it.
        defect: Box<ModelError>,
    },
    /// The barrier that keeps elements from turning inside out.
    #[error(transparent)]
    Barrier(#[from] ParameterError),
}

impl From<ModelError> for MaterialDefect {
    fn from(error: ModelError) -> Self {
        Self::Model(Box::new(error))
    }
}

/// What is wrong with what all fibers share.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FibersDefect {
    /// A largest isometric stress that is none.
    #[error("max_isometric_stress = {max_isometric_stress} must be pascals above 0")]
    MaxIsometricStress {
        /// What was given.
        max_isometric_stress: f64,
    },
    /// A stretch that is none.
    #[error("optimal_stretch = {optimal_stretch} must be above 0")]
    OptimalStretch {
        /// What was given.
        optimal_stretch: f64,
    },
    /// A table of tensions that is no curve.
    #[error(
        "curve.table.{table} needs two or more rows [stretch, tension], stretches ascending and around 1"
    )]
    Table {
        /// Active or passive.
        table: &'static str,
    },
    /// No spline runs through the table.
    #[error(transparent)]
    Curve(#[from] CurveError),
}
