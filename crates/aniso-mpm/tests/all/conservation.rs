//! Mass, momentum and angular momentum over many steps of a free, spinning, elastic body.
use crate::{Host, lattice};
use aniso_mpm::{
    Apic, Body, Cubic, Linear, MlsMpm, Particles, Quadratic, Scheme, Settings, Simulation, Spline,
};

use fem_materials::{DegradableQr, QrAnisotropic};
const H: f64 = 0.1;

const LAW: DegradableQr = QrAnisotropic {
    mu: 2e3,
    lambda: 5e3,
    kx: 3e3,
    ky: 1e3,
}
.degradable(0.0);

/// A stretched and sheared block of uneven density that spins and flies.
fn spinning_body<const D: usize>() -> Particles<f64, D> {
    let mut particles = lattice([-0.15; D], [0.15; D], 0.05, |_| true);
    for p in 0..particles.len() {
        let x: [f64; D] = particles.x[p];
        particles.v[p] = [0.3; D];
        particles.v[p][0] += -4.0 * x[1];
        particles.v[p][1] += 4.0 * x[0];
        particles.F[p].0[0][1] = 0.2;
        particles.F[p].0[1][1] = 0.9;
        particles.mass[p] *= 1.0 + 0.3 * ((p * 7919) % 101) as f64 / 101.0;
    }
    particles
}

/// Σ m, Σ m v, and the plane components of Σ x ∧ m v + the angular momentum of the affine part.
fn momenta<const D: usize>(p: &Particles<f64, D>, inertia: f64) -> (f64, [f64; D], Vec<f64>) {
    let mut linear = [0.0; D];
    let mut angular = vec![0.0; 3];
    for i in 0..p.len() {
        for a in 0..D {
            linear[a] += p.mass[i] * p.v[i][a];
        }
        let mut plane = 0;
        for a in 0..D {
            for b in 0..a {
                let orbit = p.x[i][b] * p.v[i][a] - p.x[i][a] * p.v[i][b];
                let spin = inertia * (p.C[i].0[a][b] - p.C[i].0[b][a]);
                angular[plane] += p.mass[i] * (orbit + spin);
                plane += 1;
            }
        }
    }
    (p.mass.iter().sum(), linear, angular)
}

fn conserves<S: Scheme, const D: usize>() {
    let mut settings = Settings::new(H);
    settings.gravity = [0.0; D];
    let bodies = vec![Body::elastic(LAW)];
    let mut simulation =
        Simulation::<f64, S, _, D>::new(settings, bodies, vec![], spinning_body()).unwrap();
    let inertia = S::Kernel::INERTIA.unwrap_or(0.0) * H * H;
    let before = momenta(simulation.particles(), inertia);
    for _ in 0..25 {
        simulation.step(4e-4).unwrap();
    }
    let after = momenta(simulation.particles(), inertia);
    let scale: f64 = before.1.iter().map(|p| p.abs()).fold(0.0, f64::max);
    assert!((before.0 - after.0).abs() <= 1e-12 * before.0);
    for a in 0..D {
        assert!((before.1[a] - after.1[a]).abs() < 1e-12 * scale);
    }
    // The linear kernel has no affine inertia to keep the spin in.
    if S::Kernel::INERTIA.is_some() {
        for (b, a) in before.2.iter().zip(&after.2) {
            assert!(
                (b - a).abs() < 1e-11 * scale,
                "{:?} {:?}",
                before.2,
                after.2
            );
        }
    }
}

#[test]
fn mass_momentum_and_angular_momentum_stay() {
    // One dimension for each transfer, both for the default; `textbook.rs` has the others.
    conserves::<MlsMpm<Quadratic>, 2>();
    conserves::<MlsMpm<Quadratic>, 3>();
    conserves::<MlsMpm<Cubic>, 3>();
    conserves::<Apic<Quadratic>, 2>();
    conserves::<Apic<Cubic>, 2>();
    conserves::<Apic<Linear>, 3>();
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let bodies = vec![Body::elastic(LAW)];
            let mut simulation =
                Host::<3>::new(Settings::new(H), bodies, vec![], spinning_body()).unwrap();
            for _ in 0..10 {
                simulation.step(2e-4).unwrap();
            }
            simulation.particles().clone()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}
