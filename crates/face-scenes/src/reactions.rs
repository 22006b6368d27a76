//! What each muscle does to the jaw: its torque about the hinge at a pose.

use super::assembly::{Refusal, in_mesh};
use super::{Scene, SceneError};
use face_rig::anatomy::{Bone, FiberEntry};
use face_rig::rig::Equilibrium;
use fem_assembly::mesh::SimplexMesh;
use fem_assembly::{AssemblyBuilder, Dofs};

/// The tetrahedra that touch the jaw, numbered anew.
struct Attached {
    mesh: SimplexMesh<3>,
    /// The node of the face behind each node.
    nodes: Vec<u32>,
    /// The new number of each tetrahedron of the face, if it is among them.
    number: Vec<Option<usize>>,
}

impl Scene {
    /// The torque of every muscle on the jaw about the hinge as the pose carries it, newton meters;
    /// positive opens.
    ///
    /// τ_m = a · Σ (x − p) × f_m over the nodes of the jaw, with the forces f_m of the fibers of
    /// muscle m alone, active and passive, on the nodes that they hang on: −∂E_m/∂φ for a further
    /// turn φ of the jaw. What reaches the jaw through flesh that the muscle pulls is not in it.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] as for [`Scene::assembly`].
    pub fn jaw_torques(&self, pose: &Equilibrium) -> Result<Vec<f64>, SceneError> {
        let torques = self.torques(pose);
        torques.map_err(|(field, defect)| SceneError::invalid(&self.path, field, *defect))
    }

    fn torques(&self, pose: &Equilibrium) -> Result<Vec<f64>, Refusal> {
        let mut torques = vec![0.0; self.muscles.len()];
        let Some(attached) = self.attached() else {
            return Ok(torques);
        };
        let entries = self.fiber_field.entries();
        for (muscle, torque) in torques.iter_mut().enumerate() {
            let own = entries.iter().filter(|e| e.muscle as usize == muscle);
            let own = own.filter(|e| attached.number[e.tet as usize].is_some());
            let strength = self.strength(muscle as u32, &pose.parameters);
            *torque = strength * self.torque(&attached, &own.collect::<Vec<_>>(), pose)?;
        }
        Ok(torques)
    }

    fn torque(
        &self,
        attached: &Attached,
        entries: &[&FiberEntry],
        pose: &Equilibrium,
    ) -> Result<f64, Refusal> {
        if entries.is_empty() {
            return Ok(0.0);
        }
        let number = |e: &&FiberEntry| attached.number[e.tet as usize].map(|n| self.fiber(e, n));
        let fibers: Vec<_> = entries.iter().filter_map(number).collect();
        let dofs = Dofs::all_free(attached.mesh.nodes()).map_err(in_mesh)?;
        let builder = AssemblyBuilder::new(&attached.mesh, dofs).map_err(in_mesh)?;
        let assembly = self.with_fibers(builder, &fibers)?;
        let assembly = assembly.build().map_err(in_mesh)?;
        let all = &pose.in_cranium_frame;
        let x: Vec<_> = attached.nodes.iter().map(|&n| all[n as usize]).collect();
        let at = assembly.configuration(&x, &pose.parameters.activations);
        let forces = assembly.forces_everywhere(at.map_err(in_mesh)?);
        let line = self.joint.hinge_at(&pose.parameters.jaw);
        let (p, a) = (line.point(), line.axis());
        let of_node = self.bones.of_node();
        let on_jaw = |n: &u32| of_node[*n as usize] == Bone::Jaw;
        let nodes = attached.nodes.iter().zip(x.iter().zip(&forces));
        let nodes = nodes.filter(|(n, _)| on_jaw(n));
        Ok(nodes.map(|(_, (x, f))| moment(p, a, *x, *f)).sum())
    }

    /// None where nothing hangs on the jaw.
    fn attached(&self) -> Option<Attached> {
        let of_node = self.bones.of_node();
        let touches = |tet: &[u32; 4]| tet.iter().any(|&n| of_node[n as usize] == Bone::Jaw);
        let (mut count, mut corners) = (0, Vec::new());
        let number = self.mesh.tets().map(|tet| {
            touches(&tet).then(|| {
                corners.extend(tet);
                count += 1;
                count - 1
            })
        });
        let number = number.collect();
        let mut nodes = corners.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |n: &u32| nodes.partition_point(|m| m < n) as u32;
        let rest = nodes.iter().map(|&n| self.mesh.node(n)).collect();
        let corners = corners.iter().map(place).collect();
        let mesh = SimplexMesh::new(rest, corners).ok()?;
        Some(Attached {
            mesh,
            nodes,
            number,
        })
    }
}

/// a · (x − p) × f.
fn moment(p: [f64; 3], a: [f64; 3], x: [f64; 3], f: [f64; 3]) -> f64 {
    let r: [f64; 3] = std::array::from_fn(|i| x[i] - p[i]);
    (0..3)
        .map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[i] * (r[j] * f[k] - r[k] * f[j])
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Contact;
    use face_rig::anatomy::FiberField;
    use face_rig::rig::Parameters;

    /// −ΔE_m/Δφ, with E_m the energy of all muscles less that of the others.
    #[test]
    fn a_torque_is_the_energy_that_a_turn_of_the_jaw_costs_the_muscle() {
        let mut scene = Scene::builtin(5_000).expect("a face");
        // Its muscles alone: a state of the flesh that is no equilibrium serves as well.
        scene.regions.clear();
        scene.contact = Contact::default();
        let all = scene.fiber_field.clone();
        let mut parameters = Parameters::rest(scene.muscles.len());
        let of = |name: &str| {
            scene
                .muscles
                .iter()
                .position(|m| m.name == name)
                .expect(name)
        };
        let (muscle, brow) = (of("masseter_L"), of("frontalis_medial_L"));
        parameters.activations[muscle] = 0.4;
        let numbers = [0.12, 0.002, 0.001, 0.03];
        parameters.jaw = scene.joint.motion(numbers).0;
        let line = scene.joint.hinge_at(&parameters.jaw);
        let mut z = scene.mesh.nodes().to_vec();
        for &n in &scene.bones.jaw {
            z[n as usize] = parameters.jaw.apply(z[n as usize]);
        }
        let pose = Equilibrium {
            parameters: parameters.clone(),
            in_cranium_frame: z.clone(),
        };
        let torques = scene.jaw_torques(&pose).expect("torques");
        let energy = |scene: &Scene, angle: f64| {
            let turn = line.motion(angle, [0.0; 3]);
            let mut z = z.clone();
            for &n in &scene.bones.jaw {
                z[n as usize] = turn.apply(z[n as usize]);
            }
            let assembly = scene.assembly().expect("an assembly");
            assembly.energy(
                assembly
                    .configuration(&z, &parameters.activations)
                    .expect("finite"),
            )
        };
        let h = 1e-4;
        let whole = energy(&scene, h) - energy(&scene, -h);
        let others = all.entries().iter().filter(|e| e.muscle as usize != muscle);
        let (tets, count) = (scene.mesh.num_elements(), scene.muscles.len());
        scene.fiber_field =
            FiberField::new(others.copied().collect(), tets, count).expect("fibers");
        let without = energy(&scene, h) - energy(&scene, -h);
        let expected = -(whole - without) / (2.0 * h);
        let found = torques[muscle];
        // A masseter closes.
        assert!(found < -1e-3, "{found} N m");
        assert!(
            (found - expected).abs() < 1e-6 * found.abs(),
            "{found} for {expected}"
        );
        assert_eq!(torques[brow], 0.0);
    }
}
