//! A step of 20,000 neo-Hookean particles: `cargo bench -p aniso-mpm`. Rates by threads and precision:
//! `examples/throughput.rs`.

use aniso_mpm::{Body, MlsMpm, Particle, Particles, Quadratic, Settings, Simulation};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fem_kinematics::Mat;
use fem_materials::NeoHookean;

/// 27 particles to a cell of a cube of 9³ cells.
fn block(h: f64) -> Particles<f64, 3> {
    const SIDE: usize = 27;
    let spacing = h / 3.0;
    let volume = spacing.powi(3);
    let mut particles = Particles::new();
    for i in 0..SIDE * SIDE * SIDE {
        let place = [i / (SIDE * SIDE), i / SIDE % SIDE, i % SIDE];
        let particle = Particle {
            x: place.map(|k| 0.3 + (k as f64 + 0.5) * spacing),
            v: [0.1, 0.0, 0.0],
            F: Mat::identity(),
            mass: 1000.0 * volume,
            volume,
            damage: 0.0,
            body: 0,
        };
        particles.push(&particle).expect("a particle");
    }
    particles
}

fn steps(criterion: &mut Criterion) {
    let h = 1.0 / 64.0;
    let particles = block(h);
    let count = particles.len() as u64;
    let (mu, lambda) = (1e5, 1.5e5);
    let bodies = vec![Body::elastic(NeoHookean { mu, lambda })];
    let settings = Settings::new(h);
    let simulation =
        Simulation::<f64, MlsMpm<Quadratic>, _, 3>::new(settings, bodies, vec![], particles);
    let mut simulation = simulation.expect("a simulation");
    let mut group = criterion.benchmark_group("MLS-MPM");
    group.throughput(Throughput::Elements(count));
    group.bench_function("step", |b| b.iter(|| simulation.step(1e-6)));
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
