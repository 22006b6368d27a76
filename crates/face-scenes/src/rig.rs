//! From a scene to a rig that can be posed.

use super::defect::FleshDefect;
use super::format::{Inversion, LinearMethod};
use super::{Scene, SceneError};
use face_rig::fit::{JawModel, Orthogonality};
use face_rig::rig::{EmbeddedPoints, MultigridUse, Rig, RigError, RigParams};
use fem_solvers::{LinearSolver, NewtonParams};

/// A scene that no rig can be made of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigSceneError {
    /// The scene does not describe flesh that holds together.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The rig refused its input.
    #[error(transparent)]
    Rig(#[from] RigError),
}

impl Scene {
    /// The scene's flesh, muscles and bones as a [`Rig`], at rest; [`Rig::params`] has what the scene
    /// changed of `params`.
    ///
    /// # Errors
    /// [`RigSceneError`] names the region, element or fiber that is unusable, and what of `params`
    /// contradicts the scene: [`MultigridUse::Always`] a scene that is solved by QR.
    pub fn rig(&self, params: RigParams) -> Result<Rig, RigSceneError> {
        if self.bones.cranium.is_empty() && self.bones.jaw.is_empty() {
            let defect = FleshDefect::NoBone;
            return Err(SceneError::invalid(&self.path, "face.files.bones", defect).into());
        }
        let jaw: Vec<usize> = self.bones.jaw.iter().map(|&n| n as usize).collect();
        let params = RigParams {
            refuses_inverted: params.refuses_inverted || self.inversion == Inversion::Barred,
            ..params
        };
        let assembly = self.assembly()?;
        let params = self.solved_by(params, assembly.dofs().vector_len())?;
        let rig = Rig::new(assembly, &jaw, params)?;
        Ok(rig.with_controls(self.controls())?)
    }

    /// The linear solver that the scene names, if it names one; where multigrid is used by counts, it
    /// then is never.
    fn solved_by(&self, params: RigParams, unknowns: usize) -> Result<RigParams, SceneError> {
        if self.linear_solver == LinearMethod::Rig {
            return Ok(params);
        }
        if params.multigrid == MultigridUse::Always {
            let defect = FleshDefect::QrOrMultigrid;
            return Err(SceneError::invalid(&self.path, "linear_solver", defect));
        }
        let limit = LinearSolver::LARGEST_QR;
        if unknowns > limit {
            let defect = FleshDefect::TooLargeForQr { unknowns, limit };
            return Err(SceneError::invalid(&self.path, "linear_solver", defect));
        }
        let newton = NewtonParams {
            linear_solver: LinearSolver::QrLeastSquares,
            ..params.newton
        };
        Ok(RigParams {
            newton,
            multigrid: MultigridUse::Never,
            ..params
        })
    }

    /// The orthogonality weights of the scene as a fit takes them, meters².
    pub fn orthogonality(&self) -> Orthogonality {
        let weights = self.fit.orthogonality;
        Orthogonality {
            cranium: 1e-6 * weights.cranium_mm2,
            jaw: 1e-6 * weights.jaw_mm2,
        }
    }

    /// The jaw in its joint: opening, protrusion, lateral shift and yaw.
    pub fn jointed_jaw(&self) -> JawModel {
        JawModel::Joint(self.joint)
    }

    /// The landmarks at these places of [`Scene::landmarks`], to be observed; a place past the end is
    /// left out.
    pub fn landmark_points(&self, places: impl IntoIterator<Item = usize>) -> EmbeddedPoints {
        let point = |place: usize| self.landmarks.get(place).map(|l| l.point);
        EmbeddedPoints(places.into_iter().filter_map(point).collect())
    }
}
