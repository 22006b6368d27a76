//! The crate's tests, in one program: what they share is compiled once.
#![allow(non_snake_case)]
mod by_hand;
mod conservation;
mod damage;
mod elasticity;
mod fracture;
#[path = "../../../../tests/fuzz.rs"]
mod fuzz;
mod hostile;
mod inextensible;
mod kkt;
mod scenes;
mod sorting;
mod stability;
mod textbook;

use aniso_mpm::{Float, MlsMpm, Particle, Particles, Quadratic, Simulation};
use fem_kinematics::Mat;
use fem_materials::DegradableQr;

/// The host that most tests run, one per dimension.
type Host<const D: usize> = Simulation<f64, MlsMpm<Quadratic>, DegradableQr, D>;

/// Particles at rest in the middle of the cells of a lattice from `min` to `max`, where `inside`
/// says so: 1000 kg/m³, body 0, fibers along e₁.
fn lattice<T: Float, const D: usize>(
    min: [f64; D],
    max: [f64; D],
    spacing: f64,
    inside: impl Fn([f64; D]) -> bool,
) -> Particles<T, D> {
    let count: [usize; D] = std::array::from_fn(|a| ((max[a] - min[a]) / spacing).round() as usize);
    let volume = spacing.powi(D as i32);
    let mut particles = Particles::new();
    for i in 0..count.iter().product() {
        let mut left = i;
        let x = std::array::from_fn(|a| {
            let k = left % count[a];
            left /= count[a];
            min[a] + (k as f64 + 0.5) * spacing
        });
        if inside(x) {
            particles
                .push(&Particle {
                    x,
                    v: [0.0; D],
                    F: Mat::identity(),
                    mass: 1000.0 * volume,
                    volume,
                    damage: 0.0,
                    body: 0,
                })
                .unwrap();
        }
    }
    particles
}
