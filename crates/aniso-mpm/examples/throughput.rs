//! Particle-steps per second: quadratic MLS-MPM in 3D, neo-Hookean, 200,000 particles in random
//! order in a cube of 64³ cells. One step is everything: sort, stress, both transfers, grid. Next
//! to it the bytes that a step moves at least, and what memory gives to a triad a = b + s c on
//! arrays of 64 MB.
//!
//! `cargo run --release -p aniso-mpm --example throughput [particles] [steps]`
use aniso_mpm::{Body, Float, MlsMpm, Particle, Particles, Quadratic, Settings, Simulation};
use fem_kinematics::Mat;
use fem_materials::NeoHookean;
use rayon::prelude::*;
use std::collections::HashSet;
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
/// the neighbors. `None` where there is no Linux.
fn processor_time() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit(')').next()?.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

/// Bytes that one step reads from and writes to memory per particle: each array once for every
/// pass over it, what is written also read first (the cache line is fetched).
fn bytes_per_particle<T>(count: usize, home_blocks: usize, node_blocks: usize) -> f64 {
    let number = size_of::<T>();
    let (vector, matrix) = (3 * number, 9 * number);
    // Positions, and the order that comes of them.
    let sort = vector + 2 * 4;
    let stress = (matrix + number) + 2 * matrix;
    let scatter = (2 * vector + 2 * matrix + 2 * number) + 4;
    let gather = (vector + matrix) + 4 + 2 * (2 * vector + 2 * matrix);
    let carried = 3 * (4 * number + 2 + 4) + 4;
    // A window has 6³ nodes of four numbers: written, summed; then gathered once per block.
    let node = 4 * number;
    let grid = home_blocks * 216 * node * (2 + 1 + 1) + node_blocks * 64 * node * (2 + 2);
    (sort + stress + scatter + gather + carried) as f64 + grid as f64 / count as f64
}

/// Bytes per second of a = b + s c with this many threads, the best of five.
fn triad(pool: &rayon::ThreadPool) -> f64 {
    const LENGTH: usize = 8 << 20;
    let (b, c) = (vec![1.0f64; LENGTH], vec![2.0f64; LENGTH]);
    let mut a = vec![0.0f64; LENGTH];
    let mut best = f64::INFINITY;
    pool.install(|| {
        for pass in 0..5 {
            let s = f64::from(pass);
            let start = Instant::now();
            a.par_chunks_mut(1 << 16)
                .zip(b.par_chunks(1 << 16).zip(c.par_chunks(1 << 16)))
                .for_each(|(a, (b, c))| {
                    for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                        *a = b + s * c;
                    }
                });
            best = best.min(start.elapsed().as_secs_f64());
        }
    });
    assert_eq!(a[LENGTH - 1], 9.0);
    // Two arrays read, one fetched and written.
    (4 * 8 * LENGTH) as f64 / best
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

/// What was measured.
struct Rate {
    /// Particle-steps per second on the wall, the best of three.
    wall: f64,
    /// The same per second of processor time.
    processor: f64,
    /// Bytes counted per second on the wall.
    bytes: f64,
}

fn measure<T: Float>(count: usize, steps: usize, threads: usize, cells: f64) -> Rate {
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
    let material = NeoHookean {
        mu: 1e5,
        lambda: 1.5e5,
    };
    let mut simulation = Simulation::<T, MlsMpm<Quadratic>, _, 3>::new(
        settings,
        vec![Body::elastic(material)],
        vec![],
        particles,
    )
    .unwrap();
    pool(threads).install(|| {
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
        let wall = work / best;
        // Blocks of 4³ nodes that hold the first node under some particle.
        let block = |x: &T| ((x.to_f64() / h - 0.5) / 4.0).floor() as i32;
        let x = simulation.particles().x.iter();
        let homes: HashSet<[i32; 3]> = x.map(|x| x.each_ref().map(block)).collect();
        let node_blocks = simulation.active_blocks();
        let bytes = bytes_per_particle::<T>(count, homes.len(), node_blocks);
        Rate {
            wall,
            processor: used.map_or(f64::NAN, |used| 3.0 * work / used),
            bytes: bytes * wall,
        }
    })
}

fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|a| a.parse::<usize>().unwrap());
    let count = arguments.next().unwrap_or(200_000);
    let steps = arguments.next().unwrap_or(10);
    for threads in [1, 2] {
        println!(
            "triad, {threads} thread(s): {:.1} GB/s",
            triad(&pool(threads)) / 1e9
        );
    }
    for (name, cells) in [
        ("sparse: cube of 56^3 cells", 56.0),
        ("dense: cube of 29^3 cells, 8 per cell", 29.0),
    ] {
        println!("{name}, {count} particles");
        for threads in [1, 2] {
            for (scalar, rate) in [
                ("f64", measure::<f64>(count, steps, threads, cells)),
                ("f32", measure::<f32>(count, steps, threads, cells)),
            ] {
                println!(
                    "  {threads} thread(s), {scalar}: {:5.2} M/s, {:5.2} M per second of processor, {:4.1} GB/s",
                    rate.wall / 1e6,
                    rate.processor / 1e6,
                    rate.bytes / 1e9
                );
            }
        }
    }
}
