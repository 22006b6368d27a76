//! From a scene to a rig that can be posed.

use super::material::{FibreCurve, FibreStretch, PassiveMaterial};
use super::Scene;
use crate::anatomy::{Bone, EmbeddedPoint};
use crate::fit::JawModel;
use crate::rig::{CarriedPoint, CarriedPoints, Rig, RigError, RigParams};
use fem_assembly::{AssemblyBuilder, AssemblyError, Dofs, Fiber};
use fem_materials::curves::{Blemker, Ends, PhysBam, Spline, SplineCurve};
use fem_materials::{
    FiberLaw, Flesh, Lame, NeoHookean, Space, StableNeoHookean, Stretch,
};

/// A scene that no rig can be made of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RigSceneError {
    /// The mesh side refused its input.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The rig refused its input.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// A material or curve with impossible numbers.
    #[error("region \"{region}\": {reason}")]
    Material {
        /// The region, or `fibres`.
        region: String,
        /// What is wrong.
        reason: String,
    },
    /// No node is held: the flesh would float away.
    #[error("no node is attached to cranium or jaw; without support there is no equilibrium")]
    NothingHeld,
}

impl Scene {
    /// The scene's flesh, muscles and bones as a [`Rig`], at rest.
    ///
    /// # Errors
    /// [`RigSceneError`] names the region, element or fibre that is unusable.
    pub fn rig(&self, params: RigParams) -> Result<Rig, RigSceneError> {
        let held = |bone: Bone| self.bones.of_node().iter().enumerate().filter(move |(_, b)| **b == bone);
        let jaw: Vec<usize> = held(Bone::Jaw).map(|(n, _)| n).collect();
        let mut fixed: Vec<usize> = held(Bone::Cranium).map(|(n, _)| n).collect();
        fixed.extend(&jaw);
        if fixed.is_empty() {
            return Err(RigSceneError::NothingHeld);
        }
        let dofs = Dofs::with_fixed_nodes(self.mesh.nodes(), &fixed)?;
        let mut builder = AssemblyBuilder::new(&self.mesh, dofs)?;
        for (label, region) in self.regions.iter().enumerate() {
            let elements: Vec<usize> = (0..self.region_of_tet.len())
                .filter(|&e| self.region_of_tet[e] as usize == label)
                .collect();
            let bad = |e: &dyn std::fmt::Display| RigSceneError::Material {
                region: region.name.clone(),
                reason: e.to_string(),
            };
            let lame = |young, poisson| Lame::from_young_poisson(young, poisson, Space::Solid).map_err(|e| bad(&e));
            builder = match region.material {
                PassiveMaterial::MooneyRivlin { a, b, bulk } => builder.region(
                    &elements,
                    Flesh::new(a, b, bulk),
                )?,
                PassiveMaterial::StableNeoHookean { young, poisson } => builder
                    .region(&elements, StableNeoHookean::from_lame(lame(young, poisson)?))?,
                PassiveMaterial::NeoHookean { young, poisson } => {
                    let lame = lame(young, poisson)?;
                    builder.region(&elements, NeoHookean { mu: lame.mu, lambda: lame.lambda })?
                }
            };
        }
        Ok(Rig::new(self.with_fibres(builder)?.build()?, &jaw, params)?)
    }

    fn with_fibres(
        &self,
        builder: AssemblyBuilder<3>,
    ) -> Result<AssemblyBuilder<3>, RigSceneError> {
        let settings = &self.fibres;
        let fibers: Vec<Fiber> = self
            .fibre_field
            .entries()
            .iter()
            .map(|entry| Fiber {
                element: entry.tet as usize,
                channel: entry.muscle as usize,
                direction: entry.direction,
                peak: entry.weight * settings.sigma_max,
                optimal_stretch: settings.lambda_ofl,
            })
            .collect();
        let stretch = match settings.stretch {
            FibreStretch::Plain => Stretch::Plain,
            FibreStretch::Deviatoric => Stretch::Deviatoric,
        };
        let channels = self.muscles.len();
        Ok(match &settings.curve {
            FibreCurve::Physbam => {
                let curve = PhysBam::default();
                builder.fibers(FiberLaw { curve, stretch }, channels, &fibers)?
            }
            FibreCurve::Blemker => {
                let curve = Blemker::default();
                builder.fibers(FiberLaw { curve, stretch }, channels, &fibers)?
            }
            FibreCurve::Table { active, passive } => {
                let spline = |rows: &[[f64; 2]], ends| {
                    let (l, f): (Vec<f64>, Vec<f64>) = rows.iter().map(|r| (r[0], r[1])).unzip();
                    Spline::new(&l, &f, ends).map_err(|e| RigSceneError::Material {
                        region: "fibres".into(),
                        reason: e.to_string(),
                    })
                };
                let curve = SplineCurve {
                    active: spline(active, Ends::Flat)?,
                    passive: spline(passive, Ends::Linear)?,
                };
                builder.fibers(FiberLaw { curve, stretch }, channels, &fibers)?
            }
        })
    }

    /// The jaw as an animator moves it: a turn about the scene's hinge and a shift.
    pub fn hinged_jaw(&self) -> JawModel {
        JawModel::Hinge { point: self.hinge.point(), axis: self.hinge.axis() }
    }

    /// The landmarks at these places of [`Scene::landmarks`] as points carried by the mesh; a place
    /// past the end is left out.
    pub fn carried_landmarks(&self, places: impl IntoIterator<Item = usize>) -> CarriedPoints {
        let carried = |place: usize| self.landmarks.get(place).map(|l| self.carried(&l.point));
        CarriedPoints(places.into_iter().filter_map(carried).collect())
    }

    /// A point inside a tet as one carried by the tet's nodes.
    pub fn carried(&self, point: &EmbeddedPoint) -> CarriedPoint {
        CarriedPoint { nodes: self.mesh.tet(point.tet as usize), weights: point.weights }
    }
}
