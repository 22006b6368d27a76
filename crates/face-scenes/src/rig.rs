//! From a scene to a rig that can be posed.

use super::defect::FleshDefect;
use super::format::Inversion;
use super::{Scene, SceneError};
use face_rig::fit::JawModel;
use face_rig::rig::{EmbeddedPoints, Rig, RigError, RigParams};

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
    /// The scene's flesh, muscles and bones as a [`Rig`], at rest.
    ///
    /// # Errors
    /// [`RigSceneError`] names the region, element or fiber that is unusable.
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
        let rig = Rig::new(self.assembly()?, &jaw, params)?;
        Ok(rig.with_controls(self.controls())?)
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
