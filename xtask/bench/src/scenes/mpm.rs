//! A block of material points that swings: it should keep its energy and its momentum.

use super::Scene;
use crate::curve::{Axis, Claim, Curve, Point};
use crate::failure::Failure;
use crate::settings::Settings;
use crate::timing::fastest_with;
use aniso_mpm::{
    Body, Float, ImplicitStep, Integrator, MlsMpm, Particle, Particles, Quadratic,
    Settings as Host, Simulation,
};
use fem_kinematics::Mat;
use fem_materials::{DegradableQr, QrAnisotropic};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "mpm",
    about: "a square of material points that swings freely for 0.3 s",
    measure: "share lost",
    truth: "a free body keeps its energy and its momentum",
    run: curves,
    counted: Some(|| {
        Ok(swing::<f64>(16, Integrator::Symplectic)?
            .advance(0.3)
            .map(|_| ())?)
    }),
};

/// Particles at rest in the middle of the cells of a lattice of the plane where `inside` says so:
/// 1000 kg/m³, body 0, fibers along e₁.
pub fn lattice<T: Float>(
    size: f64,
    spacing: f64,
    inside: impl Fn([f64; 2]) -> bool,
) -> Result<Particles<T, 2>, Failure> {
    let count = (size / spacing).round() as usize;
    let volume = spacing * spacing;
    let mut particles = Particles::new();
    for i in 0..count * count {
        let x = [i % count, i / count].map(|k| (k as f64 + 0.5) * spacing);
        if inside(x) {
            particles.push(&Particle {
                x,
                v: [0.0; 2],
                F: Mat::identity(),
                mass: 1000.0 * volume,
                volume,
                damage: 0.0,
                body: 0,
            })?;
        }
    }
    Ok(particles)
}

type Swing<T> = Simulation<T, MlsMpm<Quadratic>, DegradableQr, 2>;

fn swing<T: Float>(cells: usize, integrator: Integrator) -> Result<Swing<T>, Failure> {
    let h = 1.0 / cells as f64;
    let mut particles = lattice::<T>(0.5, 0.5 * h, |_| true)?;
    for (v, x) in particles.v.iter_mut().zip(&particles.x) {
        let [x, y] = [x[0].to_f64(), x[1].to_f64()];
        // It stretches along one axis and shrinks along the other, and drifts.
        *v = [0.4 * (x - 0.25) + 0.1, -0.3 * (y - 0.25)].map(T::from_f64);
    }
    let mut settings = Host::new(h);
    settings.gravity = [0.0; 2];
    settings.integrator = integrator;
    if integrator != Integrator::Symplectic {
        settings.max_step = 0.1 * h;
    }
    let law = QrAnisotropic::from_young_poisson(2e3, 0.3, 2e3, 0.0)?;
    let body = Body::elastic(law.degradable(1e-3));
    Ok(Simulation::new(settings, vec![body], vec![], particles)?)
}

fn energy<T: Float>(s: &Swing<T>) -> f64 {
    let energies = s.energies();
    energies.kinetic + energies.elastic
}

fn momentum<T: Float>(s: &Swing<T>) -> [f64; 2] {
    let p = s.particles();
    let mut sum = [0.0; 2];
    for i in 0..p.len() {
        (0..2).for_each(|k| sum[k] += p.mass[i].to_f64() * p.v[i][k].to_f64());
    }
    sum
}

/// A point for the energy, and one for the momentum.
fn points<T: Float>(
    cells: usize,
    integrator: Integrator,
    settings: &Settings,
) -> Result<[Point; 2], Failure> {
    let before = swing::<T>(cells, integrator)?;
    let timed = fastest_with(
        settings.repetitions,
        || swing::<T>(cells, integrator),
        |s| {
            s.advance(0.3)?;
            Ok((energy(s), momentum(s), s.steps(), s.particles().len()))
        },
    )?;
    let (energy_after, momentum_after, steps, count) = timed.value;
    let p = momentum(&before);
    let lost = workbench::numbers::distance(&momentum_after, &p) / workbench::numbers::norm(&p);
    let point = |error| Point {
        setting: format!("{cells} cells/m"),
        error,
        seconds: timed.seconds,
        unknowns: 2 * count,
        steps,
        memory: timed.memory,
        ..Point::default()
    };
    Ok([
        point((energy_after / energy(&before) - 1.0).abs()),
        point(lost),
    ])
}

type Measure = fn(usize, Integrator, &Settings) -> Result<[Point; 2], Failure>;

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let implicit = Integrator::Implicit(ImplicitStep {
        tolerance: 1e-10,
        max_iterations: 60,
    });
    let ways: [(&str, Measure, Integrator, f64); 3] = [
        ("f64", points::<f64>, Integrator::Symplectic, 1e-11),
        ("f32", points::<f32>, Integrator::Symplectic, 1e-3),
        ("f64, implicit", points::<f64>, implicit, 1e-6),
    ];
    let mut curves = Vec::new();
    for (name, measure, integrator, momentum) in ways {
        let claims = [Claim::FallsTo(0.0), Claim::AtMost(momentum)];
        let [mut energies, mut momenta] = [("energy", claims[0]), ("momentum", claims[1])]
            .map(|(what, claim)| Curve::new(format!("{what}, {name}"), Axis::Mesh, claim));
        momenta = momenta.undrawn();
        let longest = if integrator == implicit { 32 } else { 64 };
        for cells in settings.sizes(&[8, 16, 32], &[8, 16, 32, 64]) {
            if cells <= longest {
                let [e, p] = measure(cells, integrator, settings)?;
                energies.points.push(e);
                momenta.points.push(p);
            }
        }
        curves.extend([energies, momenta]);
    }
    Ok(curves)
}
