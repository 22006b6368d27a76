//! `face-rig simulate`.

use super::args::{Format, Multigrid, OutputArgs, Pictures, SimulateArgs};
use super::clock::Clock;
use super::draw::{Shape, pose as draw_pose};
use super::error::{Failure, Squashed, Unsolved};
use super::output::{Output, say};
use super::progress::spinner;
use super::source::{named_controls, open, pose};
use face_rig::rig::{AffineMap, Parameters, Rig, RigError, RigParams};
use face_scenes::Scene;
use fem_solvers::Watch;
use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

pub fn run(args: &SimulateArgs, output: &OutputArgs, mut clock: Clock) -> Result<(), Failure> {
    clock.enter("scene");
    let source = open(&args.scene, false)?;
    let scene = &source.scene;
    let parameters = pose(scene, &args.pose)?;
    let params = RigParams {
        multigrid: args.multigrid.into(),
        ..RigParams::default()
    };
    let mut out = Output::prepare(output, clock)?;
    out.enter("assembly");
    let rig = scene.rig(params)?;
    let bar = spinner("looking for the equilibrium");
    let mut rig = rig.watched_by(told_by(&bar));
    out.enter("equilibrium");
    let solved = rig.solve(&parameters).cloned();
    bar.finish_and_clear();
    let positions = match solved {
        Ok(solved) => solved.positions(),
        Err(error) => return Err(unsolved(&mut out, scene, &rig, error)),
    };
    let bar = spinner("writing shapes and pictures");
    out.enter("files");
    out.write_shape("pose", scene, &rig, &parameters, &positions)?;
    if out.pictures != Pictures::None {
        out.enter("pictures");
        let picture = out.path("pose.png");
        let rest = Shape::new(&source, scene.mesh.nodes(), &AffineMap::IDENTITY);
        let posed = Shape::new(&source, &positions, &parameters.jaw);
        draw_pose(&picture, &scene.name, &rest, &posed)?;
    }
    bar.finish_and_clear();

    out.enter("report");
    let settings = json!({ "scene": args.scene, "set": args.pose.set, "jaw": args.pose.jaw,
        "jaw_shift_mm": args.pose.jaw_shift, "control": args.pose.control,
        "multigrid": Multigrid::told(rig.params().multigrid) });
    let found = Found::of(scene, &rig, &parameters, &positions)?;
    let report = out.report(
        "simulate",
        settings,
        found.results(scene, &rig, &parameters),
    )?;
    if output.json {
        return say(serde_json::to_string_pretty(&report)?);
    }
    say(found.summary(scene, &rig))?;
    for (name, torque) in &found.torques {
        say(format!(
            "{name}: {:.1} N mm on the jaw about its hinge ({})",
            1e3 * torque,
            if *torque > 0.0 { "opens" } else { "closes" },
        ))?;
    }
    say(format!("results in {}", out.folder().display()))
}

/// What a pose is like.
struct Found {
    /// The largest way of a node from rest, millimeters.
    largest_mm: f64,
    /// The smallest det F.
    smallest: f64,
    /// Elements turned inside out.
    inverted: usize,
    /// How deep flesh lies in what it touches, millimeters; none without contact.
    deepest_contact_mm: Option<f64>,
    /// Triangles of the skin that cross others; none without a skin.
    crossing: Option<usize>,
    /// Joules.
    energy: f64,
    /// On the jaw, newton meters.
    torques: Vec<(String, f64)>,
}

impl Found {
    fn of(
        scene: &Scene,
        rig: &Rig,
        parameters: &Parameters,
        positions: &[[f64; 3]],
    ) -> Result<Self, Failure> {
        let assembly = rig.assembly();
        let shape = assembly.positions(positions).map_err(RigError::from)?;
        let ratios = assembly.volume_ratios(shape).map_err(RigError::from)?;
        let moved = positions
            .iter()
            .zip(scene.mesh.nodes())
            .map(|(x, r)| (0..3).map(|i| (x[i] - r[i]).powi(2)).sum::<f64>().sqrt());
        let controls = rig.energy_controls(parameters);
        let equilibrium = rig.equilibrium();
        let at = assembly
            .configuration(&equilibrium.in_cranium_frame, &controls)
            .map_err(RigError::from)?;
        let deepest = assembly.deepest_contact(at).map_err(RigError::from)?;
        Ok(Self {
            largest_mm: 1e3 * moved.fold(0.0, f64::max),
            smallest: ratios.iter().copied().fold(f64::INFINITY, f64::min),
            inverted: ratios.iter().filter(|j| !(**j > 0.0)).count(),
            deepest_contact_mm: deepest.map(|depth| 1e3 * depth),
            crossing: scene.skin.as_ref().map(|skin| skin.crossings(positions)),
            energy: assembly.energy(at),
            torques: torques_by_name(scene, &scene.jaw_torques(equilibrium)?),
        })
    }

    fn results(&self, scene: &Scene, rig: &Rig, parameters: &Parameters) -> Value {
        let work = rig.work();
        json!({
            "controls": named_controls(scene, parameters),
            "jaw_torques_newton_meters": self.torques.iter().cloned().collect::<BTreeMap<_, _>>(),
            "energy_joules": self.energy,
            "newton_steps": work.newton_steps, "equilibria": work.equilibria,
            "factorizations": work.factorizations, "linear_iterations": work.linear_iterations,
            "evaluations": work.evaluations,
            "smallest_det_F": self.smallest, "inverted_tets": self.inverted,
            "crossing_triangles": self.crossing, "deepest_contact_mm": self.deepest_contact_mm,
            "largest_displacement_mm": self.largest_mm,
        })
    }

    fn summary(&self, scene: &Scene, rig: &Rig) -> String {
        let work = rig.work();
        format!(
            "{}: moved by up to {:.2} mm in {} Newton steps, {:.2} s; smallest det F {:.3}{}",
            scene.name,
            self.largest_mm,
            work.newton_steps,
            work.equilibrium_time.as_secs_f64(),
            self.smallest,
            match self.inverted {
                0 => String::new(),
                n => format!(
                    "\nwarning: {n} tets are turned inside out; the pose is beyond what the mesh bears"
                ),
            },
        )
    }
}

/// Shows how far a solve is.
fn told_by(bar: &ProgressBar) -> Watch {
    let bar = bar.clone();
    Watch::new(move |step| {
        let (steps, force) = (step.iteration, step.gradient_norm);
        bar.set_message(format!(
            "looking for the equilibrium: Newton step {steps}, largest force left {force:.1e} N"
        ));
        ControlFlow::Continue(())
    })
}

/// The elements that are squashed most, and how many of them are named.
const WORST: usize = 3;

/// Writes the last state that was solved, and says what it looks like and what could help.
fn unsolved(out: &mut Output, scene: &Scene, rig: &Rig, error: RigError) -> Failure {
    let RigError::NoEquilibrium { last, .. } = &error else {
        return error.into();
    };
    let Ok(z) = rig.assembly().positions(&last.in_cranium_frame) else {
        return error.into();
    };
    let Ok(ratios) = rig.assembly().volume_ratios(z) else {
        return error.into();
    };
    let mut worst: Vec<usize> = (0..ratios.len()).collect();
    worst.sort_by(|&a, &b| ratios[a].total_cmp(&ratios[b]));
    worst.truncate(WORST);
    let stress = |element: usize| {
        let region = &scene.regions[scene.region_of_tet[element] as usize];
        let gradients = rig.assembly().deformation_gradients(element, z);
        let stresses = gradients
            .into_iter()
            .flatten()
            .map(|f| region.material.von_mises_stress(&f).unwrap_or(f64::NAN));
        stresses.fold(0.0, f64::max)
    };
    let (pose, positions) = (&last.parameters, last.positions());
    let worst = worst.into_iter().map(|element| Squashed {
        element,
        ratio: ratios[element],
        stress: stress(element),
    });
    let worst = worst.collect();
    // The flesh, whatever was asked for: what went wrong is inside it.
    out.formats = vec![Format::Vtu];
    if let Err(failure) = out.write_shape("last_state", scene, rig, pose, &positions) {
        return failure;
    }
    Failure::Unsolved(Box::new(Unsolved {
        error,
        worst,
        folder: out.folder().to_path_buf(),
    }))
}

/// The muscles whose torque is more than rounding, strongest first.
fn torques_by_name(scene: &Scene, torques: &[f64]) -> Vec<(String, f64)> {
    let largest = torques.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    let names = scene.muscles.iter().map(|m| m.name.clone());
    let all = names.zip(torques.iter().copied());
    let mut named: Vec<_> = all.filter(|(_, t)| t.abs() > 1e-9 * largest).collect();
    named.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    named
}
