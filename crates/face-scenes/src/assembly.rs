//! From a scene to forces: materials, fibers and prescribed nodes as one assembly.

use super::defect::{Defect, FibersDefect, FleshDefect, MaterialDefect};
use super::format::{Inversion, Volume};
use super::material::{FiberCurve, FiberStretch, NamedMaterial, Region};
use super::{Ligament, Scene, SceneError};
use face_rig::anatomy::{Bone, FiberEntry, Share};
use fem_assembly::{Assembly, AssemblyBuilder, AssemblyError, Dofs, Fiber, VolumePatches};
use fem_materials::curves::{Blemker, CurveError, Ends, PhysBam, Spline, SplineCurve, Tendon};
use fem_materials::inversion::{Threshold, VolumeBarrier};
use fem_materials::registry::ModelError;
use fem_materials::{FiberLaw, Lame, Stretch};
use std::collections::BTreeMap;

/// The share of its volume below which an element is kept from turning inside out.
const BARRED_BELOW: f64 = 0.2;

impl Scene {
    /// The flesh as an assembly: the nodes of cranium and jaw prescribed, one activation channel per
    /// muscle in the order of [`Scene::muscles`]. The jaw's nodes are in [`Scene::bones`].
    ///
    /// # Errors
    /// [`SceneError::Invalid`] where a tension table is no curve, or the mesh cannot be assembled.
    pub fn assembly(&self) -> Result<Assembly<3>, SceneError> {
        self.assemble()
            .map_err(|(field, defect)| SceneError::invalid(&self.path, field, *defect))
    }

    fn assemble(&self) -> Result<Assembly<3>, Refusal> {
        let bones = self.bones.cranium.iter().chain(&self.bones.jaw);
        let prescribed: Vec<usize> = bones.map(|&n| n as usize).collect();
        let dofs =
            Dofs::new(self.mesh.nodes(), &prescribed, &self.moved_axes()).map_err(in_mesh)?;
        let builder = AssemblyBuilder::new(&self.mesh, dofs).map_err(in_mesh)?;
        let builder = self.thresholded(builder, |builder| self.with_flesh(builder))?;
        let touching = self
            .contact
            .add_to(builder, &self.mesh, &self.bones, &self.embedding);
        let mut builder = touching.map_err(|e| refusal("contact", e))?;
        let mut by_control: BTreeMap<Option<usize>, Vec<Fiber>> = BTreeMap::new();
        by_control.insert(None, Vec::new());
        for entry in self.fiber_field.entries() {
            let control = self.strength_of(entry.muscle);
            let fiber = self.fiber(entry, entry.tet as usize);
            by_control.entry(control).or_default().push(fiber);
        }
        for (control, fibers) in by_control {
            builder = changed(builder, control, |b| self.with_fibers(b, &fibers))?;
        }
        for ligament in &self.ligaments {
            builder = self.with_ligament(builder, ligament)?;
        }
        let builder = self.with_loads(builder);
        builder.and_then(AssemblyBuilder::build).map_err(in_mesh)
    }

    /// The material of each region with its barrier, and the volumes of patches: of all regions that no
    /// control changes together, and of each that one does.
    fn with_flesh(&self, mut builder: AssemblyBuilder<3>) -> Result<AssemblyBuilder<3>, Refusal> {
        let mut bulks = vec![(None, vec![0.0; self.mesh.num_elements()])];
        for (r, region) in self.regions.iter().enumerate() {
            let of_tet = self.region_of_tet.iter().enumerate();
            let inside = of_tet.filter(|(_, region)| **region as usize == r);
            let tets: Vec<usize> = inside.map(|(tet, _)| tet).collect();
            if !tets.is_empty() {
                let in_region = |e| in_region(region, e);
                let (material, rest) = self.split(&region.material).map_err(in_region)?;
                let control = self.stiffness_of(r);
                if control.is_some() {
                    bulks.push((control, vec![0.0; self.mesh.num_elements()]));
                }
                let of_control = if control.is_some() {
                    bulks.len() - 1
                } else {
                    0
                };
                tets.iter().for_each(|&tet| bulks[of_control].1[tet] = rest);
                builder = changed(builder, control, |builder| {
                    let added = material.add_to(builder, &tets).map_err(in_region)?;
                    self.with_barrier(added.map_err(in_mesh)?, region, &tets)
                })?;
            }
        }
        bulks.retain(|(_, bulk)| bulk.iter().any(|&k| k > 0.0));
        if bulks.is_empty() {
            return Ok(builder);
        }
        let patches = VolumePatches::around_edges(&self.mesh);
        for (control, bulk) in bulks {
            builder = changed(builder, control, |builder| {
                builder.mean_volume(&patches, &bulk).map_err(in_mesh)
            })?;
        }
        Ok(builder)
    }

    /// What keeps a region's elements with a free node from turning inside out, where the scene wants
    /// that.
    fn with_barrier(
        &self,
        builder: AssemblyBuilder<3>,
        region: &Region,
        tets: &[usize],
    ) -> Result<AssemblyBuilder<3>, Refusal> {
        let at_rest = region.material.at_rest();
        let Lame { mu, .. } = at_rest.map_err(|e| in_region(region, e))?;
        if !(self.inversion == Inversion::Barred && mu > 0.0) {
            return Ok(builder);
        }
        let barrier = VolumeBarrier::new(BARRED_BELOW, mu);
        let barrier = barrier.map_err(|e| refusal("material", MaterialDefect::from(e)))?;
        // What only bones move no force can hold; it is counted and named instead.
        let free = |&n: &u32| self.bones.of_node()[n as usize] == Bone::Free;
        let prescribed = |&tet: &usize| !self.mesh.tet(tet).iter().any(free);
        let tets: Vec<usize> = tets
            .iter()
            .copied()
            .filter(|tet| !prescribed(tet))
            .collect();
        match tets.is_empty() {
            true => Ok(builder),
            false => builder.region(&tets, barrier).map_err(in_mesh),
        }
    }

    /// An entry of the field as a fiber of this element.
    pub(crate) fn fiber(&self, entry: &FiberEntry, element: usize) -> Fiber {
        let own = self.own_fibers.get(&entry.muscle).copied();
        let own = own.unwrap_or_default();
        let stress = own.max_isometric_stress;
        let stress = stress.unwrap_or(self.fibers.max_isometric_stress);
        let optimal = own.optimal_stretch;
        Fiber {
            element,
            control: entry.muscle as usize,
            direction: entry.direction,
            max_isometric_stress: stress * entry.weight,
            optimal_stretch: optimal.unwrap_or(self.fibers.optimal_stretch),
        }
    }

    /// Fibers that no activation reaches.
    fn with_ligament(
        &self,
        builder: AssemblyBuilder<3>,
        ligament: &Ligament,
    ) -> Result<AssemblyBuilder<3>, Refusal> {
        let fiber = |share: &Share| Fiber {
            element: share.tet as usize,
            control: 0,
            direction: share.direction,
            max_isometric_stress: ligament.stiffness * share.weight,
            optimal_stretch: 1.0,
        };
        let fibers: Vec<Fiber> = ligament.shares.iter().map(fiber).collect();
        let law = FiberLaw {
            curve: Tendon { toe: ligament.toe },
            stretch: Stretch::Total,
        };
        let count = self.muscles.len();
        self.thresholded(builder, |builder| {
            builder.fibers(law, count, &fibers).map_err(in_mesh)
        })
    }

    /// Adds what `add` adds, its stretches held above the scene's threshold where there is one.
    fn thresholded(
        &self,
        builder: AssemblyBuilder<3>,
        add: impl FnOnce(AssemblyBuilder<3>) -> Result<AssemblyBuilder<3>, Refusal>,
    ) -> Result<AssemblyBuilder<3>, Refusal> {
        let Inversion::Thresholded(threshold) = self.inversion else {
            return add(builder);
        };
        if threshold >= 1.0 {
            return Err(refusal(
                "inversion.thresholded",
                FleshDefect::Threshold { threshold },
            ));
        }
        let threshold = Threshold::new(threshold);
        let threshold = threshold.map_err(|e| refusal("inversion", MaterialDefect::from(e)))?;
        builder.thresholded(threshold, add)
    }

    /// Adds fibers with the scene's curve.
    pub(crate) fn with_fibers(
        &self,
        builder: AssemblyBuilder<3>,
        fibers: &[Fiber],
    ) -> Result<AssemblyBuilder<3>, Refusal> {
        self.thresholded(builder, |builder| self.with_plain_fibers(builder, fibers))
    }

    fn with_plain_fibers(
        &self,
        builder: AssemblyBuilder<3>,
        fibers: &[Fiber],
    ) -> Result<AssemblyBuilder<3>, Refusal> {
        let stretch = match self.fibers.stretch {
            FiberStretch::Total => Stretch::Total,
            FiberStretch::Isochoric => Stretch::Isochoric,
        };
        let count = self.muscles.len();
        let builder = match &self.fibers.curve {
            FiberCurve::Physbam => {
                let curve = PhysBam::default();
                builder.fibers(FiberLaw { curve, stretch }, count, fibers)
            }
            FiberCurve::Blemker => {
                let curve = Blemker::default();
                builder.fibers(FiberLaw { curve, stretch }, count, fibers)
            }
            FiberCurve::Table { active, passive } => {
                let curve = table(active, passive);
                let refused = |e| refusal("fibers.curve.table", FibersDefect::Curve(e));
                let curve = curve.map_err(refused)?;
                builder.fibers(FiberLaw { curve, stretch }, count, fibers)
            }
        };
        builder.map_err(in_mesh)
    }

    /// What the elements are made of, and the bulk modulus (Pa) that is left for the patches.
    fn split(&self, material: &NamedMaterial) -> Result<(NamedMaterial, f64), ModelError> {
        let Lame { mu, lambda } = material.at_rest()?;
        let softer = match self.volume {
            Volume::Patches if lambda > mu => material.with_lambda(mu),
            _ => None,
        };
        Ok(softer.map_or((material.clone(), 0.0), |softer| (softer, lambda - mu)))
    }
}

/// The field and what is wrong with it.
pub(super) type Refusal = (&'static str, Box<Defect>);

fn refusal(field: &'static str, defect: impl Into<Defect>) -> Refusal {
    (field, Box::new(defect.into()))
}

pub(super) fn in_mesh(error: AssemblyError) -> Refusal {
    refusal("face", error)
}

fn in_region(region: &Region, error: ModelError) -> Refusal {
    let (region, defect) = (region.name.clone(), Box::new(error));
    refusal("material", MaterialDefect::InRegion { region, defect })
}

/// Adds what `add` adds, changed by a control where there is one.
fn changed<E>(
    builder: AssemblyBuilder<3>,
    control: Option<usize>,
    add: impl FnOnce(AssemblyBuilder<3>) -> Result<AssemblyBuilder<3>, E>,
) -> Result<AssemblyBuilder<3>, E> {
    match control {
        Some(control) => builder.changed_by(control, add),
        None => add(builder),
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
    use crate::{Contact, Fibers, Region};
    use fem_kinematics::Mat;
    use fem_materials::Material;
    use fem_materials::presets::{PHYSBAM_FACE, SOFT_TISSUE};
    use fem_materials::registry::{Entry, Parameter, SolidVisitor, for_each_solid};

    /// The built-in face of one material that touches nothing.
    fn of_one(material: NamedMaterial) -> Scene {
        let mut scene = Scene::builtin(5_000).expect("a face");
        scene.regions = vec![Region {
            name: "flesh".into(),
            material,
        }];
        scene.region_of_tet.fill(0);
        scene.contact = Contact::default();
        scene
    }

    fn with(material: NamedMaterial, fibers: Fibers) -> Assembly<3> {
        let mut scene = of_one(material);
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
            (SOFT_TISSUE.into(), FiberCurve::Physbam, FiberStretch::Total),
            (
                PHYSBAM_FACE.into(),
                FiberCurve::Blemker,
                FiberStretch::Isochoric,
            ),
            (
                NamedMaterial::new("neo_hookean", [("young", 3e4), ("poisson", 0.45)]),
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
            let name = material.to_string();
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
            assert!(largest(0.0) < 1e-9, "{name}");
            assert!(largest(0.5) > 1e-2, "{name}");
        }
    }

    /// Swollen by a hundredth, elements and patches together resist as the model does; sheared, the
    /// elements alone.
    #[test]
    fn patches_take_over_what_lambda_exceeds_mu_by() {
        let stiff = NamedMaterial::new("neo_hookean", [("young", 3e4), ("poisson", 0.49)]);
        let mut scene = of_one(stiff);
        let energies = |scene: &Scene, gradient: Mat<f64, 3>| {
            let assembly = scene.assembly().expect("an assembly");
            let moved: Vec<_> = (assembly.rest().iter())
                .map(|&x| gradient.mul_vec(x))
                .collect();
            let quiet = vec![0.0; assembly.controls()];
            assembly.energy(assembly.configuration(&moved, &quiet).expect("finite"))
        };
        let swollen = Mat::from_diagonal([1.0001; 3]);
        let sheared = Mat([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let whole = [swollen, sheared].map(|gradient| energies(&scene, gradient));
        scene.volume = Volume::Patches;
        let split = [swollen, sheared].map(|gradient| energies(&scene, gradient));
        for (whole, split) in whole.iter().zip(split) {
            assert!((whole - split).abs() < 1e-3 * whole, "{whole} and {split}");
        }
        // A patch may keep its volume where its elements do not.
        let (softer, rest) = scene.split(&scene.regions[0].material).expect("a model");
        let lame = softer.at_rest().expect("a model");
        assert!((lame.lambda - lame.mu).abs() < 1e-9 * lame.mu && rest > 10.0 * lame.mu);
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

    /// Compares a scene of one material, turned and stretched as a whole, with the model itself.
    struct Compared {
        scene: Scene,
        seen: usize,
    }

    const TURNED: Mat<f64, 3> = Mat([[1.05, 0.1, 0.0], [-0.05, 0.96, 0.02], [0.0, 0.04, 1.02]]);

    impl Compared {
        /// Not generic: it is compiled once and not for each model.
        fn holds(&mut self, name: &str, parameters: &[Parameter], density: f64) {
            let mesh = &self.scene.mesh;
            let volume: f64 = (0..mesh.num_elements()).map(|t| mesh.volume(t)).sum();
            let expected = density * volume;
            let values: serde_json::Map<_, _> = parameters
                .iter()
                .map(|p| (p.name.to_owned(), p.default.into()))
                .collect();
            let text = serde_json::json!({ name: values }).to_string();
            let spec: crate::SceneMaterial = serde_json::from_str(&text).expect(name);
            self.scene.regions[0].material = spec.resolve().expect(name);
            let assembly = self.scene.assembly().expect(name);
            let turned: Vec<_> = assembly.rest().iter().map(|&x| TURNED.mul_vec(x)).collect();
            let quiet = vec![0.0; assembly.controls()];
            let energy = assembly.energy(assembly.configuration(&turned, &quiet).expect(name));
            let error = (energy - expected).abs();
            assert!(
                error <= 1e-10 * expected.abs(),
                "{name}: {energy} for {expected}"
            );
        }
    }

    impl SolidVisitor for Compared {
        fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
            let model = entry.build(&entry.defaults()).expect(entry.name);
            let density = model.energy(&TURNED);
            for name in entry.aliases.iter().chain([&entry.name]) {
                self.holds(name, entry.parameters, density);
            }
            self.seen += 1;
        }
    }

    #[test]
    fn every_model_of_the_registry_is_reached_by_its_name_and_has_its_own_energy() {
        let mut scene = of_one(SOFT_TISSUE.into());
        scene.fiber_field =
            face_rig::anatomy::FiberField::new(Vec::new(), scene.mesh.num_elements(), 0)
                .expect("no fibers");
        scene.muscles.clear();
        let mut compared = Compared { scene, seen: 0 };
        for_each_solid(&mut compared);
        let files = concat!(env!("CARGO_MANIFEST_DIR"), "/../fem-materials/src/models");
        let files = std::fs::read_dir(files).expect("the models").count();
        assert!(compared.seen >= files - 1, "{} of {files}", compared.seen);
    }
}
