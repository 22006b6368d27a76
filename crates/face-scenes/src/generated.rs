//! The face that the program makes, as a scene.

use super::defect::Defect;
use super::load::{Flesh, Place};
use super::{Fibers, Landmark, NamedMaterial, Region, Scene, SceneError, Skin};
use crate::builtin::BuiltinFace;
use face_rig::anatomy::{Bones, CondylarPath, FiberField, JawJoint, JointLimits, Muscle};
use fem_assembly::mesh::{Repairs, SimplexMesh};
use fem_materials::presets::SOFT_TISSUE;
use std::collections::BTreeMap;
use std::path::Path;

pub(super) fn scene(tets: usize) -> Result<Scene, SceneError> {
    let place = Place {
        path: Path::new("built-in face"),
        scale: 1.0,
    };
    let flesh = flesh(&place, tets, SOFT_TISSUE.into())?;
    let name = format!("built-in face, {} tets", flesh.mesh.num_elements());
    Ok(flesh.scene(name, Fibers::default()))
}

/// What the generator makes passes the same checks as files do. Its lengths are meters whatever
/// the scale.
pub(super) fn flesh(
    place: &Place,
    tets: usize,
    material: NamedMaterial,
) -> Result<Flesh, SceneError> {
    let refuse = |defect: Defect| place.field("face.builtin.tets", defect);
    let face = BuiltinFace::with_tets(tets).map_err(|e| refuse(e.into()))?;
    let skin_triangles = face.skin();
    let connectivity = face.tets.as_flattened().to_vec();
    let mesh = SimplexMesh::new(face.nodes, connectivity).map_err(|e| refuse(e.into()))?;
    let count = face.muscles.len();
    let field = FiberField::new(face.fibers, mesh.num_elements(), count);
    let landmarks = face.landmarks.iter().zip(0..).map(|(l, index)| Landmark {
        index,
        vertex: index,
        point: *l,
    });
    let joint = JawJoint::new(face.hinge, CondylarPath::ADULT, JointLimits::ADULT);
    let joint = joint.map_err(|e| refuse(e.into()))?;
    Ok(Flesh {
        repairs: Repairs::default(),
        bones: Bones::new(face.bone),
        joint,
        fiber_field: field.map_err(|e| refuse(e.into()))?,
        own_fibers: BTreeMap::new(),
        muscles: face
            .muscles
            .into_iter()
            .map(|name| Muscle { name })
            .collect(),
        regions: vec![Region::of_all(material)],
        region_of_tet: vec![0; mesh.num_elements()],
        embedding: BTreeMap::new(),
        landmarks: landmarks.collect(),
        skin: Some(Skin::of_nodes(&mesh, &skin_triangles)),
        mesh,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Warning, check};

    #[test]
    fn the_built_in_face_passes_its_own_check() {
        let scene = Scene::builtin(5_000).expect("a face");
        let report = check(&scene);
        assert_eq!(report.landmarks, 68);
        assert!(report.muscles.len() >= 20 && report.muscles.iter().all(|m| m.tets > 0));
        assert!(
            !(report.warnings.iter()).any(|w| matches!(w, Warning::Height { .. })),
            "{:?}",
            report.warnings
        );
        let surface = scene.surface();
        let last = surface.points.len() - 1;
        let embedded = surface.points[last].position(scene.mesh.nodes());
        assert_eq!(embedded, surface.rest[last]);
        let error = Scene::builtin(3).expect_err("too few");
        assert!(error.to_string().contains("4000 to 2000000"), "{error}");
    }
}
