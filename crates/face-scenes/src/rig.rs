//! From a scene to a rig that can be posed.

use super::{Scene, SceneError};
use face_rig::anatomy::EmbeddedPoint;
use face_rig::fit::JawModel;
use face_rig::rig::{CarriedPoint, CarriedPoints, Rig, RigError, RigParams};

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
            let reason = "no node is attached to cranium or jaw; flesh without support floats away";
            return Err(SceneError::invalid(&self.path, "face.files.bones", reason).into());
        }
        let jaw: Vec<usize> = self.bones.jaw.iter().map(|&n| n as usize).collect();
        let rig = Rig::new(self.assembly()?, &jaw, params)?;
        Ok(rig.with_controls(self.controls())?)
    }

    /// The jaw as an animator moves it: a turn about the scene's hinge and a shift.
    pub fn hinged_jaw(&self) -> JawModel {
        JawModel::Hinge(self.hinge)
    }

    /// The landmarks at these places of [`Scene::landmarks`] as points carried by the mesh; a place
    /// past the end is left out.
    pub fn carried_landmarks(&self, places: impl IntoIterator<Item = usize>) -> CarriedPoints {
        let carried = |place: usize| self.landmarks.get(place).map(|l| self.carried(&l.point));
        CarriedPoints(places.into_iter().filter_map(carried).collect())
    }

    /// A point inside a tet as one carried by the tet's nodes.
    pub fn carried(&self, point: &EmbeddedPoint) -> CarriedPoint {
        CarriedPoint {
            nodes: self.mesh.tet(point.tet as usize),
            weights: point.weights,
        }
    }
}
