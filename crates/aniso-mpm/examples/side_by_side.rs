//! The same notched plate twice, pulled by the same grips: isotropic on the left, fibers on the
//! right. One simulation, two bodies.
//!
//! `cargo run --release -p aniso-mpm --example side_by_side`
mod show;

use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{
    Body, Contact, Fiber, MlsMpm, Obstacle, Particles, Quadratic, Settings, Simulation,
};
use fem_kinematics::{ImplicitSurface, Mat};
use fem_materials::QrAnisotropic;

/// Everything that can be changed about the scene.
struct Scene {
    /// Cells along a side of each 1 m plate; 2×2 particles per cell.
    cells: usize,
    /// Angle between the fibers of the right plate and the notch, degrees.
    fiber_angle: f64,
    /// Young's modulus (Pa), Poisson's ratio, density (kg/m³) of both.
    young: f64,
    poisson: f64,
    density: f64,
    /// Fiber stiffness of the right plate, Pa.
    kx: f64,
    /// Critical stress (Pa) and crack viscosity (s) of both.
    sigma_crit: f64,
    eta: f64,
    /// Speed of each grip, m/s.
    pull: f64,
    /// Frames and their length, s.
    frames: usize,
    frame_time: f64,
}

const SCENE: Scene = Scene {
    cells: 44,
    fiber_angle: 60.0,
    young: 1e5,
    poisson: 0.3,
    density: 1000.0,
    kx: 5e5,
    sigma_crit: 6e3,
    eta: 5e-2,
    pull: 0.15,
    frames: 26,
    frame_time: 0.02,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = SCENE;
    let h = 1.0 / scene.cells as f64;
    let (sin, cos) = scene.fiber_angle.to_radians().sin_cos();
    let mut particles = Particles::<f64, 2>::new();
    for (body, left, frame) in [
        (0, 0.0, Mat::identity()),
        (1, 1.3, Mat([[cos, -sin], [sin, cos]])),
    ] {
        show::fill_box(
            &mut particles,
            [left, 0.0],
            [left + 1.0, 1.0],
            0.5 * h,
            scene.density,
            body,
            frame,
            |x| !(x[0] - left < 0.25 && (x[1] - 0.5).abs() < h),
        )?;
    }
    // The grips hold a rim that cannot tear.
    for (body, x) in particles.body.iter_mut().zip(&particles.x) {
        if (x[1] - 0.5).abs() > 0.4 {
            *body += 2;
        }
    }
    let parameters = DamageParameters::new(h, scene.sigma_crit, scene.eta);
    let isotropic = QrAnisotropic::from_young_poisson(scene.young, scene.poisson, 0.0, 0.0)?;
    let body = |kx: f64, directors: Directors<2>| Body {
        material: QrAnisotropic { kx, ..isotropic }.degradable(1e-3),
        damage: Some(DamageModel {
            parameters,
            directors,
        }),
        fiber: Fiber::Extensible,
    };
    let bodies = vec![
        body(0.0, Directors::Isotropic),
        body(scene.kx, Directors::fiber(-1.0)),
    ];
    let rims = bodies.clone().into_iter().map(|body| Body {
        damage: None,
        ..body
    });
    let bodies = bodies.into_iter().chain(rims).collect();
    let grip = |low: f64, high: f64, speed: f64| Obstacle {
        shape: ImplicitSurface::Box {
            min: [-1.0, low],
            max: [4.0, high],
        },
        contact: Contact::Sticky,
        velocity: [0.0, speed],
    };
    let grips = vec![grip(-0.5, 0.07, -scene.pull), grip(0.93, 1.5, scene.pull)];
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    let mut simulation =
        Simulation::<f64, MlsMpm<Quadratic>, _, 2>::new(settings, bodies, grips, particles)?;
    let view = show::View {
        min: [-0.3, -0.3],
        max: [2.6, 1.3],
        width: 1000,
        radius: 0.3 * h,
        tilt: 0.0,
    };
    show::run(
        "side_by_side",
        &mut simulation,
        scene.frames,
        scene.frame_time,
        &view,
        |_| {},
    )
}
