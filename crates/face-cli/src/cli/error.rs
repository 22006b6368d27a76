//! Failures and their exit codes.

use face_pictures::PictureError;
use face_pictures::export::{ExportError, WriteError};
use face_rig::fit::FitError;
use face_rig::rig::RigError;
use face_scenes::builtin::BuiltinError;
use face_scenes::{RigSceneError, SceneError, SettingError};
use fem_assembly::mesh::MeshFileError;
use std::fmt;
use std::path::PathBuf;
use std::process::ExitCode;

/// Why the program stopped.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A pose without an equilibrium.
    #[error(transparent)]
    Pose(#[from] RigError),
    /// The same, with the last state that was solved.
    #[error(transparent)]
    Unsolved(Box<Unsolved>),
    /// A fit of input that cannot be fitted, or without a pose to start from.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Fits that ended without a possible pose.
    #[error("{} of {of} fits did not converge to a possible pose: {}", fits.len(), fits.join(", "))]
    Unfinished {
        /// Their names.
        fits: Vec<String>,
        /// How many fits there were.
        of: usize,
    },
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    RigScene(#[from] RigSceneError),
    #[error(transparent)]
    Setting(#[from] SettingError),
    #[error(transparent)]
    Builtin(#[from] BuiltinError),
    /// builtin:TETS without a number.
    #[error("\"{name}\": builtin:TETS wants a whole number of tetrahedra")]
    Tets { name: String },
    /// A shift that is none.
    #[error("--jaw-shift \"{text}\": three numbers in millimeters, like 0,0,5")]
    JawShift { text: String },
    #[error("{scene}: no landmarks to derive; add \"landmarks\" to the face")]
    NoLandmarks { scene: String },
    #[error("{scene}: no targets to fit; give the scene a \"targets\" entry or use --targets FILE")]
    NoTargets { scene: String },
    /// Fits that follow each other, side by side.
    #[error(
        "--at-once {asked}: with --warm-start each fit starts from the result of the one before, so they \
         run one at a time; leave one of the two out"
    )]
    AtOnce { asked: u16 },
    #[error("target {name}: {source}")]
    Target { name: String, source: FitError },
    #[error(
        "{} holds files already; name another folder with --out, or replace them with --force",
        .0.display()
    )]
    OutputExists(PathBuf),
    #[error(
        "{} is being written to by another run; wait for it, or name another folder with --out",
        .0.display()
    )]
    OutputBusy(PathBuf),
    /// A folder or its lock that cannot be made or read.
    #[error("{}: {source}", path.display())]
    Output {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("standard output: {0}")]
    StandardOutput(std::io::Error),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Export(#[from] ExportError),
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    #[error(transparent)]
    Report(#[from] serde_json::Error),
}

impl Failure {
    /// 1 for what did not converge, 2 for the command line, 3 for input, 4 for output.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Pose(_)
            | Self::Unsolved(_)
            | Self::Unfinished { .. }
            | Self::Fit(FitError::Start(_) | FitError::Pose(_) | FitError::NotConverged { .. }) => {
                1
            }
            Self::AtOnce { .. } => 2,
            Self::Fit(_)
            | Self::Scene(_)
            | Self::RigScene(_)
            | Self::Setting(_)
            | Self::Builtin(_)
            | Self::Tets { .. }
            | Self::JawShift { .. }
            | Self::NoLandmarks { .. }
            | Self::NoTargets { .. }
            | Self::Target { .. } => 3,
            Self::OutputExists(_)
            | Self::OutputBusy(_)
            | Self::Output { .. }
            | Self::StandardOutput(_)
            | Self::Write(_)
            | Self::Picture(_)
            | Self::Export(_)
            | Self::Mesh(_)
            | Self::Report(_) => 4,
        })
    }
}

/// A pose without an equilibrium, what the last state that was solved looks like, and where it is.
#[derive(Debug)]
pub struct Unsolved {
    pub error: RigError,
    /// The elements squashed most.
    pub worst: Vec<Squashed>,
    pub folder: PathBuf,
}

/// An element of the last state.
#[derive(Clone, Copy, Debug)]
pub struct Squashed {
    pub element: usize,
    /// det F.
    pub ratio: f64,
    /// Equivalent stress of von Mises in the passive flesh, pascals.
    pub stress: f64,
}

impl fmt::Display for Squashed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            element,
            ratio,
            stress,
        } = self;
        write!(
            f,
            "element {element} (det F {ratio:.3}, {:.3} kPa)",
            stress / 1e3
        )
    }
}

impl std::error::Error for Unsolved {}

impl fmt::Display for Unsolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named: Vec<String> = self.worst.iter().map(Squashed::to_string).collect();
        write!(
            f,
            "{}\n\
             squashed most in the last state that was solved: {}\n\
             that state is last_state.vtu in {}\n\
             to try: a smaller jaw angle, lower activations, \"inversion\": \"allowed\" in the scene with \
             a material that has no barrier of its own (stable_neo_hookean), or a mesh with fewer flat \
             tetrahedra near those named",
            self.error,
            named.join(", "),
            self.folder.display()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_state_is_named_with_its_worst_elements() {
        let error = RigError::NotFinite { index: 3 };
        let squashed = |element, ratio, stress| Squashed {
            element,
            ratio,
            stress,
        };
        let worst = vec![squashed(17, 0.0125, 81e3), squashed(4, 0.5, 20.0)];
        let folder = PathBuf::from("results");
        let failure = Failure::Unsolved(Box::new(Unsolved {
            error,
            worst,
            folder,
        }));
        let text = failure.to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "parameter 3 is not finite");
        assert!(
            lines[1].ends_with(
                ": element 17 (det F 0.013, 81.000 kPa), element 4 (det F 0.500, 0.020 kPa)"
            ),
            "{text}"
        );
        assert!(
            lines[2].ends_with("last_state.vtu in results") && lines.len() == 4,
            "{text}"
        );
        assert_eq!(failure.exit_code(), ExitCode::from(1));
    }

    #[test]
    fn a_fit_is_a_matter_of_input_unless_a_pose_failed() {
        let error = || Box::new(RigError::NotFinite { index: 0 });
        for (fit, code) in [
            (FitError::Start(error()), 1),
            (FitError::Pose(error()), 1),
            (FitError::EmptyTarget, 3),
        ] {
            assert_eq!(Failure::from(fit).exit_code(), ExitCode::from(code));
        }
    }
}
