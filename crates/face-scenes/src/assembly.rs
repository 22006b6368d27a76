//! From a scene to forces: materials, fibers and fixed nodes as one assembly.

use super::material::{FiberCurve, FiberStretch, PassiveMaterial};
use super::{Scene, SceneError};
use fem_assembly::{Assembly, AssemblyBuilder, AssemblyError, Dofs, Fiber};
use fem_materials::curves::{
    Blemker, CurveError, Ends, PhysBam, Spline, SplineCurve, TensionCurve,
};
use fem_materials::{FiberLaw, Flesh, Lame, NeoHookean, StableNeoHookean, Stretch};

impl Scene {
    /// The flesh as an assembly: the nodes of cranium and jaw prescribed, one activation channel per
    /// muscle in the order of [`Scene::muscles`]. The jaw's nodes are in [`Scene::bones`].
    ///
    /// # Errors
    /// [`SceneError::Invalid`] where a tension table is no curve, or the mesh cannot be assembled.
    pub fn assembly(&self) -> Result<Assembly<3>, SceneError> {
        self.assemble()
            .map_err(|(place, reason)| SceneError::invalid(&self.path, place, reason))
    }

    fn assemble(&self) -> Result<Assembly<3>, (&'static str, String)> {
        let in_mesh = |e: AssemblyError| ("face", e.to_string());
        let held = self.bones.cranium.iter().chain(&self.bones.jaw);
        let held: Vec<usize> = held.map(|&n| n as usize).collect();
        let dofs = Dofs::with_prescribed_nodes(self.mesh.nodes(), &held).map_err(in_mesh)?;
        let mut builder = AssemblyBuilder::new(&self.mesh, dofs).map_err(in_mesh)?;
        for (r, region) in self.regions.iter().enumerate() {
            let of_tet = self.region_of_tet.iter().enumerate();
            let inside = of_tet.filter(|(_, region)| **region as usize == r);
            let tets: Vec<usize> = inside.map(|(tet, _)| tet).collect();
            if !tets.is_empty() {
                builder = with_material(builder, &tets, region.material).map_err(in_mesh)?;
            }
        }
        let stretch = match self.fibers.stretch {
            FiberStretch::Total => Stretch::Total,
            FiberStretch::Isochoric => Stretch::Isochoric,
        };
        let builder = match &self.fibers.curve {
            FiberCurve::Physbam => self.with_fibers(builder, stretch, PhysBam::default()),
            FiberCurve::Blemker => self.with_fibers(builder, stretch, Blemker::default()),
            FiberCurve::Table { active, passive } => {
                let curve = table(active, passive);
                let curve = curve.map_err(|e| ("fibers.curve.table", e.to_string()))?;
                self.with_fibers(builder, stretch, curve)
            }
        };
        builder.and_then(AssemblyBuilder::build).map_err(in_mesh)
    }

    fn with_fibers<C: TensionCurve + Clone + 'static>(
        &self,
        builder: AssemblyBuilder<3>,
        stretch: Stretch,
        curve: C,
    ) -> Result<AssemblyBuilder<3>, AssemblyError> {
        let fibers: Vec<Fiber> = self
            .fiber_field
            .entries()
            .iter()
            .map(|entry| Fiber {
                element: entry.tet as usize,
                control: entry.muscle as usize,
                direction: entry.direction,
                max_isometric_stress: self.fibers.sigma_max * entry.weight,
                optimal_stretch: self.fibers.lambda_ofl,
            })
            .collect();
        builder.fibers(FiberLaw { curve, stretch }, self.muscles.len(), &fibers)
    }
}

fn with_material(
    builder: AssemblyBuilder<3>,
    tets: &[usize],
    material: PassiveMaterial,
) -> Result<AssemblyBuilder<3>, AssemblyError> {
    let (mu, lambda) = material.lame();
    match material {
        PassiveMaterial::MooneyRivlin { a, b, bulk } => {
            builder.region(tets, Flesh::new(a, b, bulk))
        }
        PassiveMaterial::StableNeoHookean { .. } => {
            builder.region(tets, StableNeoHookean::from_lame(Lame { mu, lambda }))
        }
        PassiveMaterial::NeoHookean { .. } => builder.region(tets, NeoHookean { mu, lambda }),
    }
}

fn table(active: &[[f64; 2]], passive: &[[f64; 2]]) -> Result<SplineCurve, CurveError> {
    let spline = |rows: &[[f64; 2]], ends| {
        let (stretches, values): (Vec<f64>, Vec<f64>) = rows.iter().map(|r| (r[0], r[1])).unzip();
        Spline::new(&stretches, &values, ends)
    };
    Ok(SplineCurve {
        active: spline(active, Ends::Flat)?,
        passive: spline(passive, Ends::Linear)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fibers, Region};

    fn with(material: PassiveMaterial, fibers: Fibers) -> Assembly<3> {
        let mut scene = Scene::builtin(5_000).expect("a face");
        scene.regions = vec![Region {
            name: "flesh".into(),
            material,
        }];
        scene.fibers = fibers;
        scene.assembly().expect("an assembly")
    }

    #[test]
    fn every_material_and_curve_rests_at_rest_and_pulls_when_activated() {
        let table = FiberCurve::Table {
            active: vec![[0.4, 0.0], [1.0, 1.0], [1.6, 0.0]],
            passive: vec![[1.0, 0.0], [1.5, 1.0]],
        };
        let cases = [
            (
                PassiveMaterial::SOFT_TISSUE,
                FiberCurve::Physbam,
                FiberStretch::Total,
            ),
            (
                PassiveMaterial::PHYSBAM_FACE,
                FiberCurve::Blemker,
                FiberStretch::Isochoric,
            ),
            (
                PassiveMaterial::NeoHookean {
                    young: 3e4,
                    poisson: 0.45,
                },
                table,
                FiberStretch::Total,
            ),
        ];
        for (material, curve, stretch) in cases {
            let fibers = Fibers {
                curve,
                stretch,
                ..Fibers::default()
            };
            let assembly = with(material, fibers);
            let largest = |activation: f64| {
                let activations = vec![activation; assembly.controls()];
                let forces = assembly.forces_everywhere(
                    assembly
                        .configuration(assembly.rest(), &activations)
                        .unwrap(),
                );
                forces.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()))
            };
            assert!(largest(0.0) < 1e-9, "{material:?}");
            assert!(largest(0.5) > 1e-2, "{material:?}");
        }
    }

    #[test]
    fn a_table_that_is_no_curve_is_an_error() {
        let mut scene = Scene::builtin(5_000).expect("a face");
        scene.fibers.curve = FiberCurve::Table {
            active: vec![[0.4, 0.0], [0.9, 1.0]],
            passive: vec![[1.0, 0.0], [1.5, 1.0]],
        };
        let error = scene.assembly().expect_err("l = 1 is not within");
        assert!(error.to_string().contains("fibers.curve.table"), "{error}");
    }
}
