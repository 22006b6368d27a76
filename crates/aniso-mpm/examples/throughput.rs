//! Particle-steps per second: quadratic MLS-MPM in 3D, neo-Hookean, 200,000 particles in random
//! order in a cube of 64³ cells. One step is everything: sort, stress, both transfers, grid.
//!
//! `cargo run --release -p aniso-mpm --example throughput [particles] [steps]`
use aniso_mpm::{
    Body, Elastic, Float, MlsMpm, Particle, Particles, Quadratic, Settings, Simulation,
};
use fem_kinematics::Mat;
use fem_materials::NeoHookean;
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

/// Processor time of all threads so far, s: on a busy machine the clock on the wall also measures
/// the neighbours. `None` where there is no Linux.
fn processor_time() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit(')').next()?.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

/// Particle-steps per second on the wall (the best of three), and per second of processor time.
fn measure<T: Float>(count: usize, steps: usize, threads: usize, cells: f64) -> [f64; 2] {
    let h = 1.0 / 64.0;
    let side = cells * h;
    let mut random = Random(1);
    let mut particles = Particles::<T, 3>::new();
    let volume = side.powi(3) / count as f64;
    for _ in 0..count {
        let x = std::array::from_fn(|_| (1.0 - side) / 2.0 + side * random.uniform());
        particles
            .push(&Particle {
                x,
                v: [0.1 * random.uniform(), 0.0, 0.0],
                F: Mat::identity(),
                mass: 1000.0 * volume,
                volume,
                damage: 0.0,
                body: 0,
            })
            .unwrap();
    }
    let mut settings = Settings::new(h);
    settings.gravity = [0.0, -9.81, 0.0];
    let law = Elastic(NeoHookean {
        mu: 1e5,
        lambda: 1.5e5,
    });
    let mut simulation = Simulation::<T, MlsMpm<Quadratic>, _, 3>::new(
        settings,
        vec![Body::elastic(law)],
        vec![],
        particles,
    )
    .unwrap();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let dt = 1e-5;
        for _ in 0..3 {
            simulation.step(dt).unwrap();
        }
        let mut best = f64::INFINITY;
        let before = processor_time();
        for _ in 0..3 {
            let start = Instant::now();
            for _ in 0..steps {
                simulation.step(dt).unwrap();
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        let used = before.and_then(|before| Some(processor_time()? - before));
        let work = (count * steps) as f64;
        [work / best, used.map_or(f64::NAN, |used| 3.0 * work / used)]
    })
}

fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|a| a.parse::<usize>().unwrap());
    let count = arguments.next().unwrap_or(200_000);
    let steps = arguments.next().unwrap_or(10);
    for (name, cells) in [
        ("sparse: cube of 56^3 cells", 56.0),
        ("dense: cube of 29^3 cells, 8 per cell", 29.0),
    ] {
        println!("{name}, {count} particles");
        for threads in [1, 2] {
            for (scalar, [wall, processor]) in [
                ("f64", measure::<f64>(count, steps, threads, cells)),
                ("f32", measure::<f32>(count, steps, threads, cells)),
            ] {
                println!(
                    "  {threads} thread(s), {scalar}: {:6.2} M/s, {:6.2} M per second of processor",
                    wall / 1e6,
                    processor / 1e6
                );
            }
        }
    }
}
