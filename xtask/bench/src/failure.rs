//! Why a scene gave no curves.

use std::error::Error;

/// Why a scene gave no curves.
#[derive(Debug)]
pub enum Failure {
    /// Something it needs is not here: what.
    Skipped(String),
    /// It could not be carried through.
    Failed(Box<dyn Error + Send + Sync>),
}

impl<E: Error + Send + Sync + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Failed(Box::new(error))
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Skipped(what) => write!(f, "skipped: {what}"),
            Self::Failed(error) => error.fmt(f),
        }
    }
}
