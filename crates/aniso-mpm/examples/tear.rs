//! A notched plate with fibres is pulled apart; the crack follows the fibres.
//!
//! `cargo run --release -p aniso-mpm --example tear [fibre angle in degrees]`
#![allow(non_snake_case)]
mod show;

use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{
    Body, Contact, Fibre, FibreReinforced, MlsMpm, Obstacle, Particles, Quadratic, Settings, Shape,
    Simulation,
};
use fem_kinematics::Mat;

/// Everything that can be changed about the scene.
struct Scene {
    /// Angle between the fibres and the notch, degrees.
    fibre_angle: f64,
    /// Cells along a side of the 1 m plate; 2×2 particles per cell.
    cells: usize,
    /// Depth of the notch, m.
    notch: f64,
    /// Young's modulus (Pa) and Poisson's ratio of the matrix.
    young: f64,
    poisson: f64,
    /// Fibre stiffness, Pa.
    kx: f64,
    /// Density, kg/m³.
    density: f64,
    /// Weight α of the fibre in the structural tensor: −1 lets cracks run along it only.
    alpha: f64,
    /// Critical stress, Pa.
    sigma_crit: f64,
    /// Crack viscosity, s.
    eta: f64,
    /// Speed of each grip, m/s.
    pull: f64,
    /// Frames and their length, s.
    frames: usize,
    frame_time: f64,
}

const SCENE: Scene = Scene {
    fibre_angle: 45.0,
    cells: 60,
    notch: 0.25,
    young: 1e5,
    poisson: 0.3,
    kx: 2e5,
    density: 1000.0,
    alpha: -1.0,
    sigma_crit: 8e3,
    eta: 2e-3,
    pull: 0.15,
    frames: 40,
    frame_time: 0.015,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = SCENE;
    if let Some(angle) = std::env::args().nth(1) {
        scene.fibre_angle = angle.parse()?;
    }
    let h = 1.0 / scene.cells as f64;
    let (sin, cos) = scene.fibre_angle.to_radians().sin_cos();
    // The fibre frame: e₁ along the fibres.
    let frame = Mat([[cos, -sin], [sin, cos]]);
    let mut particles = Particles::<f64, 2>::new();
    let notch = scene.notch;
    show::fill_box(
        &mut particles,
        [0.0, 0.0],
        [1.0, 1.0],
        0.5 * h,
        scene.density,
        0,
        frame,
        |x| !(x[0] < notch && (x[1] - 0.5).abs() < h),
    )?;
    let rest = particles.x.clone();
    // The grips hold a rim that cannot tear.
    for (body, x) in particles.body.iter_mut().zip(&particles.x) {
        *body = u16::from((x[1] - 0.5).abs() > 0.42);
    }
    let law = FibreReinforced::from_young_poisson(scene.young, scene.poisson, scene.kx, 0.0);
    let body = Body {
        law,
        damage: Some(DamageModel {
            parameters: DamageParameters::new(h, scene.sigma_crit, scene.eta),
            directors: Directors::fibre(scene.alpha),
        }),
        fibre: Fibre::Extensible,
    };
    let grip = |low: f64, high: f64, speed: f64| Obstacle {
        shape: Shape::Box {
            min: [-1.0, low],
            max: [2.0, high],
        },
        contact: Contact::Sticky,
        velocity: [0.0, speed],
    };
    let grips = vec![grip(-0.5, 0.06, -scene.pull), grip(0.94, 1.5, scene.pull)];
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    let mut simulation = Simulation::<f64, MlsMpm<Quadratic>, _, 2>::new(
        settings,
        vec![body, Body::elastic(law)],
        grips,
        particles,
    )?;
    let view = show::View {
        min: [-0.3, -0.3],
        max: [1.3, 1.3],
        width: 640,
        radius: 0.3 * h,
    };
    let name = format!("tear_{}", scene.fibre_angle);
    show::run(
        &name,
        &mut simulation,
        scene.frames,
        scene.frame_time,
        &view,
    )?;
    println!(
        "fibres at {:.1} degrees, crack at {:.1} degrees",
        scene.fibre_angle,
        crack_angle(simulation.particles(), &rest, [notch, 0.5])
    );
    Ok(())
}

/// Principal direction of the broken particles around the tip of the notch, in the plate at rest.
fn crack_angle(particles: &Particles<f64, 2>, rest: &[[f64; 2]], tip: [f64; 2]) -> f64 {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (id, d) in particles.id.iter().zip(&particles.damage) {
        let x = rest[*id as usize];
        let r = [x[0] - tip[0], x[1] - tip[1]];
        if *d > 0.5 && r[0].hypot(r[1]) < 0.5 {
            xx += r[0] * r[0];
            xy += r[0] * r[1];
            yy += r[1] * r[1];
        }
    }
    (0.5 * (2.0 * xy).atan2(xx - yy)).to_degrees()
}
