//! Faces that are posed, and their forces summed outside the rig.

use crate::Failure;
use crate::balance::{self, ElementForces};
use crate::named::{Named, StressFunction};
use crate::row::{Evidence, Settings};
use face_rig::anatomy::FiberEntry;
use face_rig::rig::{Parameters, Rig, RigParams};
use face_scenes::{FiberCurve, FiberStretch, Inversion, Scene};
use fem_assembly::{AssemblyBuilder, Dofs, Quasistatic};
use fem_kinematics::Mat;
use fem_materials::inversion::VolumeBarrier;
use fem_materials::{Material, Outlined};
use fem_solvers::StopReason;

/// Below this share of its volume an element of a scene is barred from turning inside out.
const BARRED_BELOW: f64 = 0.2;

/// A rig whose solves take at most so many steps.
pub fn rig(scene: &Scene, smallest_step: f64, settings: &Settings) -> Result<Rig, Failure> {
    let mut params = RigParams {
        smallest_step,
        ..RigParams::default()
    };
    let own = params.newton.max_iterations;
    params.newton.max_iterations = settings.newton(own).max_iterations;
    Ok(scene.rig(params)?)
}

/// A pose by activations and the opening of the jaw, degrees.
pub fn pose(scene: &Scene, activations: f64, degrees: f64) -> Parameters {
    let mut pose = scene.rest_pose();
    pose.activations.fill(activations);
    pose.jaw = scene.joint.motion([degrees.to_radians(), 0.0, 0.0, 0.0]).0;
    pose
}

/// Solves a pose, and trusts nothing.
pub fn solve(scene: &Scene, rig: &mut Rig, pose: &Parameters) -> Result<Evidence, Failure> {
    rig.solve(pose)?;
    let z = rig.equilibrium().in_cranium_frame.clone();
    if !z.as_flattened().iter().all(|c| c.is_finite()) {
        return Err(Failure::lie("a pose that is not finite"));
    }
    let controls = rig.energy_controls(pose);
    let at = rig.assembly().configuration(&z, &controls)?;
    if !rig.assembly().energy(at).is_finite() {
        return Err(Failure::lie("a pose whose energy is not finite"));
    }
    let ratios = rig.assembly().volume_ratios(at)?;
    let mut forces = forces(scene, &z, &pose.activations)?;
    for (sum, touch) in forces.iter_mut().zip(touches(scene, &z)?) {
        (0..3).for_each(|i| sum[i] -= touch[i]);
    }
    let problem = Quasistatic::new(rig.assembly(), z.clone(), controls)?;
    // A rig does not say which test its last solve met.
    let (x, params) = (problem.unknowns(), RigParams::default().newton);
    let left = balance::kept(&problem, &x, &forces, &params, StopReason::Rounding)?;
    let work = rig.work();
    let smallest = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    Ok(Evidence {
        steps: work.newton_steps,
        note: format!(
            "{} equilibria, {} factorizations, smallest det F {smallest:.3}",
            work.equilibria, work.factorizations
        ),
        ..left
    })
}

/// The forces of what a face touches at every node, N: of the pairs and points of a fresh look, stencil by
/// stencil.
fn touches(scene: &Scene, z: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Failure> {
    let bones = scene.bones.cranium.iter().chain(&scene.bones.jaw);
    let prescribed: Vec<usize> = bones.map(|&n| n as usize).collect();
    let dofs = Dofs::with_prescribed_nodes(scene.mesh.nodes(), &prescribed)?;
    let builder = AssemblyBuilder::new(&scene.mesh, dofs)?;
    let touching = scene
        .contact
        .add_to(builder, &scene.mesh, &scene.bones, &scene.embedding);
    let mut alone = touching?.build()?;
    alone.renew(alone.configuration(z, &[])?)?;
    Ok(alone.forces_everywhere(alone.configuration(z, &[])?))
}

/// ∂E/∂x of flesh, barrier and fibers at every node, N; loads and patches are not in it.
fn forces(scene: &Scene, x: &[[f64; 3]], activations: &[f64]) -> Result<Vec<[f64; 3]>, Failure> {
    let mut elements = ElementForces::new(&scene.mesh, x);
    let of_node = scene.bones.of_node();
    let is_free = |n: u32| of_node[n as usize] == face_rig::anatomy::Bone::Free;
    for (r, region) in scene.regions.iter().enumerate().rev() {
        let material = Named {
            model: region.material.model.clone(),
            parameters: region.material.parameters.clone(),
        };
        let stress = material.stress()?;
        let mu = region.material.at_rest()?.mu;
        let barred = scene.inversion == Inversion::Barred && mu > 0.0;
        let barrier = VolumeBarrier::new(BARRED_BELOW, mu.max(1.0));
        let barrier = Outlined(barrier.map_err(|e| Failure::trial(&e))?);
        for e in (0..scene.mesh.num_elements()).rev() {
            if scene.region_of_tet[e] as usize != r {
                continue;
            }
            let held_back = barred && scene.mesh.tet(e).into_iter().any(is_free);
            elements.add(e, |F: &Mat<f64, 3>| {
                let P = stress(F);
                if held_back { P + barrier.stress(F) } else { P }
            });
        }
    }
    for fiber in scene.fiber_field.entries().iter().rev() {
        let alpha = activations[fiber.muscle as usize];
        let tension = |alpha: f64| stress_of(scene, fiber, alpha);
        let tet = fiber.tet as usize;
        if alpha >= 0.0 {
            let stress = tension(alpha)?;
            elements.add(tet, |F| stress(F));
        } else {
            // No model takes it, but the stress is affine in it.
            let (none, all) = (tension(0.0)?, tension(1.0)?);
            elements.add(tet, |F| none(F) + (all(F) - none(F)).scale(alpha));
        }
    }
    for ligament in scene.ligaments.iter().rev() {
        for share in ligament.shares.iter().rev() {
            let stiffness = ligament.stiffness * share.weight;
            elements.add(share.tet as usize, |F: &Mat<f64, 3>| {
                tendon(F, share.direction, stiffness, ligament.toe)
            });
        }
    }
    Ok(elements.sums())
}

/// P of a tendon along `a`: none when slack, from there E e²/(2 toe) up to a strain e = toe, then
/// E (e − toe/2).
fn tendon(F: &Mat<f64, 3>, a: [f64; 3], stiffness: f64, toe: f64) -> Mat<f64, 3> {
    let along = F.mul_vec(a);
    let stretch = along.iter().map(|v| v * v).sum::<f64>().sqrt();
    let strain = stretch - 1.0;
    let tension = match strain {
        e if e <= 0.0 => 0.0,
        e if e < toe => stiffness * e * e / (2.0 * toe),
        e => stiffness * (e - 0.5 * toe),
    };
    Mat::from_fn(|i, j| tension / stretch * along[i] * a[j])
}

/// A fiber of this activation as a model of its own.
fn stress_of(scene: &Scene, fiber: &FiberEntry, alpha: f64) -> Result<StressFunction, Failure> {
    let fibers = &scene.fibers;
    let curve = match fibers.curve {
        FiberCurve::Physbam => "physbam",
        FiberCurve::Blemker => "blemker",
        _ => return Err(Failure::trial(&"a curve that has no name")),
    };
    let model = match fibers.stretch {
        FiberStretch::Total => "fiber_total",
        FiberStretch::Isochoric => "fiber_isochoric",
        _ => return Err(Failure::trial(&"a stretch that no model has")),
    };
    let [a, b, c] = fiber.direction;
    let of_muscle = scene.own_fibers.get(&fiber.muscle);
    let of_muscle = of_muscle.copied().unwrap_or_default();
    let most = of_muscle.max_isometric_stress;
    let most = most.unwrap_or(fibers.max_isometric_stress);
    let optimal = of_muscle.optimal_stretch;
    let optimal = optimal.unwrap_or(fibers.optimal_stretch);
    let own = [
        ("curve", curve.to_owned()),
        ("max_isometric_stress", (most * fiber.weight).to_string()),
        ("optimal_stretch", optimal.to_string()),
        ("alpha", alpha.to_string()),
        ("a0", format!("{a} {b} {c}")),
    ];
    let named = Named::of_defaults(model).map(|m| m.parameters);
    let defaults = named.unwrap_or_default();
    let kept = defaults
        .iter()
        .map(|(name, text)| (name.to_owned(), text.to_owned()));
    let own = own.into_iter().map(|(name, text)| (name.to_owned(), text));
    let named = Named {
        model: model.to_owned(),
        // The last of one name counts.
        parameters: kept.chain(own).collect(),
    };
    Ok(named.stress()?)
}
