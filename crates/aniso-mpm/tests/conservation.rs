//! Mass, momentum and angular momentum over many steps of a free, spinning, elastic body.
#![allow(non_snake_case)]
use aniso_mpm::{
    Apic, Body, Cubic, Elastic, Linear, MlsMpm, Particle, Particles, Quadratic, Scheme, Settings,
    Simulation, Spline,
};
use fem_kinematics::Mat;
use fem_materials::NeoHookean;

const H: f64 = 0.1;

fn spinning_body<const D: usize>() -> Particles<f64, D> {
    let mut particles = Particles::new();
    let n = 8usize;
    for i in 0..n.pow(D as u32) {
        let at: [usize; D] = std::array::from_fn(|a| (i / n.pow(a as u32)) % n);
        let x = at.map(|k| 0.05 * (k as f64 + 0.5) - 0.2);
        let mut v = [0.3; D];
        v[0] += -4.0 * x[1];
        v[1] += 4.0 * x[0];
        let mut F = Mat::identity();
        F.0[0][1] = 0.2;
        F.0[1][1] = 0.9;
        let jitter = 1.0 + 0.3 * ((i * 7919) % 101) as f64 / 101.0;
        particles
            .push(&Particle {
                x,
                v,
                F,
                mass: jitter,
                volume: 0.05f64.powi(D as i32),
                damage: 0.0,
                body: 0,
            })
            .unwrap();
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
    let law = Elastic(NeoHookean {
        mu: 2e3,
        lambda: 3e3,
    });
    let mut simulation = Simulation::<f64, S, _, D>::new(
        settings,
        vec![Body::elastic(law)],
        vec![],
        spinning_body(),
    )
    .unwrap();
    let inertia = S::Kernel::INERTIA.unwrap_or(0.0) * H * H;
    let before = momenta(simulation.particles(), inertia);
    for _ in 0..50 {
        simulation.step(2e-4).unwrap();
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
    conserves::<MlsMpm<Quadratic>, 2>();
    conserves::<MlsMpm<Quadratic>, 3>();
    conserves::<MlsMpm<Cubic>, 2>();
    conserves::<MlsMpm<Cubic>, 3>();
    conserves::<Apic<Quadratic>, 2>();
    conserves::<Apic<Quadratic>, 3>();
    conserves::<Apic<Cubic>, 2>();
    conserves::<Apic<Cubic>, 3>();
    conserves::<Apic<Linear>, 2>();
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
            let law = Elastic(NeoHookean {
                mu: 2e3,
                lambda: 3e3,
            });
            let mut simulation = Simulation::<f64, MlsMpm<Quadratic>, _, 3>::new(
                Settings::new(H),
                vec![Body::elastic(law)],
                vec![],
                spinning_body(),
            )
            .unwrap();
            for _ in 0..20 {
                simulation.step(2e-4).unwrap();
            }
            simulation.particles().clone()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}
