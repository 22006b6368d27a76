//! Failures and their exit codes.

use face_pictures::PictureError;
use face_pictures::export::WriteError;
use face_rig::fit::FitError;
use face_rig::rig::RigError;
use face_scenes::{RigSceneError, SceneError, SettingError};
use fem_assembly::mesh::MeshFileError;
use std::path::PathBuf;
use std::process::ExitCode;

/// Why the program stopped.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Exit code 1.
    #[error("{0}")]
    NotConverged(String),
    /// Exit code 3.
    #[error("{0}")]
    Input(String),
    /// Exit code 4.
    #[error(
        "{} holds files already; name another folder with --out, or replace them with --force",
        .0.display()
    )]
    OutputExists(PathBuf),
    /// Exit code 4.
    #[error(
        "{} is being written to by another run; wait for it, or name another folder with --out",
        .0.display()
    )]
    OutputBusy(PathBuf),
    /// Exit code 4.
    #[error("{0}")]
    Output(String),
}

impl Failure {
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::NotConverged(_) => 1,
            Self::Input(_) => 3,
            Self::OutputExists(_) | Self::OutputBusy(_) | Self::Output(_) => 4,
        })
    }
}

macro_rules! failures {
    ($($error:ty => $kind:ident),+ $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::$kind(error.to_string())
            }
        })+
    };
}
failures! {
    SceneError => Input,
    RigSceneError => Input,
    SettingError => Input,
    RigError => NotConverged,
    WriteError => Output,
    PictureError => Output,
    face_pictures::export::ExportError => Output,
    MeshFileError => Output,
    serde_json::Error => Output,
}

impl From<FitError> for Failure {
    fn from(error: FitError) -> Self {
        match error {
            FitError::Start(_) | FitError::Pose { .. } | FitError::NotConverged { .. } => {
                Self::NotConverged(error.to_string())
            }
            _ => Self::Input(error.to_string()),
        }
    }
}
