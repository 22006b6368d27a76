//! Steps of MLS-MPM (quadratic, 3D, `f64`) and nothing else, to count their instructions and to time
//! two builds beside each other.
//!
//! `cargo run --release -p aniso-mpm --example steps [neo|qr] [sparse|dense] [particles] [steps] [threads]`
//!
//! Particles are at random places, one or eight to a cell; the time printed is that of a step, the
//! shortest of nine runs. For instructions, the difference of two runs with different `steps` under
//! `valgrind --tool=callgrind` over particles and steps (a run takes `3 + 9 steps` of them).
use aniso_mpm::{Body, MlsMpm, Particle, Particles, Quadratic, Settings, Simulation};
use fem_kinematics::Mat;
use fem_materials::{DamageField, NeoHookean, QrAnisotropic};
use std::time::Instant;

/// A small generator of uniform numbers (xorshift64*), the same on every machine.
struct Random(u64);
impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
}

struct Run {
    /// Particles to a cell.
    fill: f64,
    particles: usize,
    steps: usize,
}

fn run<M: DamageField<3>>(material: M, run: &Run) {
    let h = 1.0 / 64.0;
    let side = h * (run.particles as f64 / run.fill).cbrt();
    let mut random = Random(1);
    let mut particles = Particles::<f64, 3>::new();
    let volume = side.powi(3) / run.particles as f64;
    for _ in 0..run.particles {
        let particle = Particle {
            x: std::array::from_fn(|_| (1.0 - side) / 2.0 + side * random.uniform()),
            v: [0.1 * random.uniform(), 0.0, 0.0],
            F: Mat::identity(),
            mass: 1000.0 * volume,
            volume,
            damage: 0.0,
            body: 0,
        };
        particles.push(&particle).expect("a particle");
    }
    let settings = Settings::new(h);
    let bodies = vec![Body::elastic(material)];
    let simulation =
        Simulation::<f64, MlsMpm<Quadratic>, _, 3>::new(settings, bodies, vec![], particles);
    let mut simulation = simulation.expect("a simulation");
    let mut step = || simulation.step(1e-5).expect("a step");
    (0..3).for_each(|_| step());
    let mut best = f64::INFINITY;
    for _ in 0..9 {
        let start = Instant::now();
        (0..run.steps).for_each(|_| step());
        best = best.min(start.elapsed().as_secs_f64() / run.steps as f64);
    }
    let rate = run.particles as f64 / best;
    println!(
        "{:.3} ms a step, {:.2} M particle-steps/s",
        1e3 * best,
        rate / 1e6
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize, default: &str| arguments.get(k).map_or(default.into(), String::clone);
    let number = |k, default: &str| word(k, default).parse::<usize>().expect("a whole number");
    let what = Run {
        fill: if word(1, "dense") == "sparse" {
            1.0
        } else {
            8.0
        },
        particles: number(2, "200000"),
        steps: number(3, "5"),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(number(4, "1"));
    pool.build().expect("threads").install(|| {
        if word(0, "neo") == "qr" {
            let law = QrAnisotropic::from_young_poisson(1e5, 0.3, 2e5, 0.0).expect("a law");
            run(law.degradable(1e-3), &what);
        } else {
            let (mu, lambda) = (1e5, 1.5e5);
            run(NeoHookean { mu, lambda }, &what);
        }
    });
}
