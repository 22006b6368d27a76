//! An error of any crate with the name of its variant.

use face_rig::rig::{PartError, RigError};
use face_scenes::{RigSceneError, SceneError};
use fem_assembly::mesh::{MeshError, MeshFileError};
use fem_assembly::{AssemblyError, RenewingError, WalkError};
use fem_materials::registry::ModelError;
use fem_solvers::NewtonError;
use std::fmt::{Debug, Display};

/// Why a row gave no answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Type and variant, `MeshError::Empty`.
    pub kind: String,
    /// What it says.
    pub message: String,
    /// Steps of the solve that failed; 0 where nothing was solved.
    pub steps: usize,
}

impl Failure {
    /// Of a row that needs what is not here.
    pub const SKIPPED: &'static str = "skipped";

    /// Of what was not a solve.
    pub fn new(kind: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            kind: kind.into(),
            message: message.into(),
            steps: 0,
        }
    }

    /// What is not here.
    pub fn skipped(message: impl Into<String>) -> Self {
        Self::new(Self::SKIPPED, message)
    }

    /// An error of an enumeration: its variant is what `Debug` begins with.
    pub fn of(kind: &str, error: &(impl Debug + Display)) -> Self {
        Self::new(format!("{kind}::{}", variant(error)), error.to_string())
    }

    /// What no row may give: a wrong answer that passes for one.
    pub fn lie(message: impl Into<String>) -> Self {
        Self::new("Lie", message)
    }

    /// What the trial itself could not do, such as make a folder.
    pub fn trial(error: &impl Display) -> Self {
        Self::new("Trial", error.to_string())
    }
}

fn variant(error: &impl Debug) -> String {
    let text = format!("{error:?}");
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    text[..end.unwrap_or(text.len())].to_owned()
}

macro_rules! failures {
    ($($error:ident),+) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::of(stringify!($error), &error)
            }
        })+
    };
}
failures!(
    MeshError,
    MeshFileError,
    AssemblyError,
    ModelError,
    SceneError
);

impl From<NewtonError> for Failure {
    fn from(error: NewtonError) -> Self {
        Self {
            kind: format!("NewtonFailure::{}", variant(&error.reason)),
            message: error.to_string(),
            steps: error.iteration,
        }
    }
}

impl From<RenewingError<3>> for Failure {
    fn from(error: RenewingError<3>) -> Self {
        match error {
            RenewingError::Assembly(error) => error.into(),
            RenewingError::Newton { source, .. } => (*source).into(),
            error => Self::of("RenewingError", &error),
        }
    }
}

impl From<WalkError<3>> for Failure {
    fn from(error: WalkError<3>) -> Self {
        match error {
            WalkError::Assembly(error) => error.into(),
            error => Self::of("WalkError", &error),
        }
    }
}

impl From<PartError> for Failure {
    fn from(error: PartError) -> Self {
        match error {
            PartError::Newton(error) => error.into(),
            PartError::Guess(error) => error.into(),
            error => Self::of("PartError", &error),
        }
    }
}

impl From<RigError> for Failure {
    fn from(error: RigError) -> Self {
        match error {
            RigError::Assembly(error) => error.into(),
            error => Self::of("RigError", &error),
        }
    }
}

impl From<RigSceneError> for Failure {
    fn from(error: RigSceneError) -> Self {
        match error {
            RigSceneError::Scene(error) => error.into(),
            RigSceneError::Rig(error) => error.into(),
            error => Self::of("RigSceneError", &error),
        }
    }
}
