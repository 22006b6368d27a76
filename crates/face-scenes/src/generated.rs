//! The face that the program makes, as a scene.

use super::contact::{Contact, Solid};
use super::defect::Defect;
use super::format::Strays;
use super::load::{Flesh, Place};
use super::outline::Outline;
use super::shape;
use super::touching::Touching;
use super::{Fibers, Landmark, NamedMaterial, Region, Scene, SceneError, Skin};
use crate::builtin::{BuiltinFace, Tissue};
use face_rig::anatomy::{Bone, Bones, CondylarPath, FiberField, JawJoint, JointLimits, Muscle};
use fem_assembly::mesh::{Repairs, SimplexMesh};
use fem_assembly::{
    AssemblyError, FleshContactParams, ImplicitSurface, RigidContactParams, RigidSurface,
    SampledDistance,
};
use fem_materials::presets::SOFT_TISSUE;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

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
    let lips = face.lips();
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
        regions: regions(material),
        region_of_tet: face.tissue.iter().map(|&t| t as u32).collect(),
        embedding: BTreeMap::new(),
        strays: Strays::Keep,
        landmarks: landmarks.collect(),
        skin: Some(Skin::of_nodes(&mesh, &skin_triangles)),
        contact: contact(lips).map_err(|e| refuse(e.into()))?,
        mesh,
    })
}

/// How much deeper than at rest flesh may be in eyeballs and teeth, meters: all of them are thicker than
/// twice that.
const DEPTH: f64 = 5e-3;
/// Distance of the samples of the teeth's surface, meters.
const SPACING: f64 = 2e-3;

/// How deep lips may lie in each other to be pushed apart, meters. On coarse meshes surfaces that lie
/// deeper behind each other come to face each other as they turn, and none of them has entered the
/// other.
const LIP_DEPTH: f64 = 1.5e-3;

/// Lids slide on eyeballs, lips and cheeks on teeth, and lips touch each other.
fn contact(lips: Vec<[u32; 3]>) -> Result<Contact, AssemblyError> {
    let params = RigidContactParams {
        depth: DEPTH,
        ..RigidContactParams::default()
    };
    let mut solids = [1.0, -1.0].map(|side| eyeball(side, params)).to_vec();
    for bone in [Bone::Cranium, Bone::Jaw] {
        solids.push(teeth(bone, params)?);
    }
    Ok(Contact {
        solids,
        flesh: Some(FleshContactParams {
            depth: LIP_DEPTH,
            ..FleshContactParams::default()
        }),
        touching: Touching::Faces(lips),
    })
}

fn eyeball(side: f64, params: RigidContactParams) -> Solid {
    let [x, y, z] = BuiltinFace::EYEBALL_CENTER;
    let (center, radius) = ([side * x, y, z], BuiltinFace::EYEBALL_RADIUS);
    let surface = ImplicitSurface::Sphere { center, radius };
    Solid {
        surface: RigidSurface::Implicit(surface),
        moves_with: Bone::Cranium,
        params,
        bounds: shape::bounds(&surface),
        outline: Some(Arc::new(Outline::eyeball(center, radius))),
    }
}

fn teeth(bone: Bone, params: RigidContactParams) -> Result<Solid, AssemblyError> {
    let (points, triangles) = BuiltinFace::teeth(bone);
    let sampled = SampledDistance::new(&points, &triangles, SPACING, params.activation)?;
    let end = |choose: fn(f64, f64) -> f64, start: f64| {
        let further = |a: [f64; 3], b: &[f64; 3]| [0, 1, 2].map(|k| choose(a[k], b[k]));
        points.iter().fold([start; 3], further)
    };
    Ok(Solid {
        surface: RigidSurface::Sampled(Arc::new(sampled)),
        moves_with: bone,
        params,
        bounds: [
            end(f64::min, f64::INFINITY),
            end(f64::max, f64::NEG_INFINITY),
        ],
        outline: Some(Arc::new(Outline::of(&points, &triangles))),
    })
}

/// Flesh is of the scene's material, all else of its own.
fn regions(flesh: NamedMaterial) -> Vec<Region> {
    let own = |young: f64| {
        NamedMaterial::new("stable_neo_hookean", [("young", young), ("poisson", 0.47)])
    };
    Tissue::ALL
        .iter()
        .map(|tissue| Region {
            name: tissue.name().into(),
            material: tissue.young().map_or_else(|| flesh.clone(), own),
        })
        .collect()
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
