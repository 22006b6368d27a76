//! A ball presses into a woven sheet that is clamped along its border: two families of fibers, a
//! director along each. The matrix breaks under the ball and begins to along the clamps; the fibers
//! bear the ball alone for a while, a net with square meshes, until it punches out a square patch
//! whose edges lie along them. Damage moves implicitly.
//!
//! `cargo run --release -p aniso-mpm --example orthotropic_sheet`
mod show;

use aniso_mpm::damage::{
    DamageModel, DamageParameters, DamageUpdate, Director, Directors, ImplicitOptions,
};
use aniso_mpm::{
    Body, Contact, Fiber, MlsMpm, Obstacle, Particles, Quadratic, Settings, Simulation,
};
use fem_kinematics::{ImplicitSurface, Mat};
use fem_materials::QrAnisotropic;

/// Everything that can be changed about the scene.
struct Scene {
    /// Cells along a side of the 1 m sheet; 2×2×2 particles per cell.
    cells: usize,
    /// Thickness of the sheet in cells.
    thickness: f64,
    /// Young's modulus (Pa), Poisson's ratio, density (kg/m³).
    young: f64,
    poisson: f64,
    density: f64,
    /// Fiber stiffness in both directions, Pa.
    fiber: f64,
    /// Weight α of both directors.
    alpha: f64,
    /// Critical stress (Pa) and crack viscosity (s).
    sigma_crit: f64,
    eta: f64,
    /// Radius (m) and speed (m/s) of the ball.
    radius: f64,
    speed: f64,
    /// Frames and their length, s.
    frames: usize,
    frame_time: f64,
}

const SCENE: Scene = Scene {
    cells: 32,
    thickness: 1.5,
    young: 1e5,
    poisson: 0.3,
    density: 1000.0,
    fiber: 5e4,
    alpha: -0.8,
    sigma_crit: 8e3,
    eta: 2e-3,
    radius: 0.12,
    speed: 2.0,
    frames: 36,
    frame_time: 0.008,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = SCENE;
    let h = 1.0 / scene.cells as f64;
    let half = 0.5 * scene.thickness * h;
    let mut particles = Particles::<f32, 3>::new();
    show::fill_box(
        &mut particles,
        [0.0, 0.0, -half],
        [1.0, 1.0, half],
        0.5 * h,
        scene.density,
        0,
        Mat::identity(),
        |_| true,
    )?;
    let director = |direction| Director {
        direction,
        weight: scene.alpha,
    };
    let body = Body {
        material: QrAnisotropic::from_young_poisson(
            scene.young,
            scene.poisson,
            scene.fiber,
            scene.fiber,
        )?
        .degradable(1e-3),
        damage: Some(DamageModel {
            parameters: DamageParameters::new(h, scene.sigma_crit, scene.eta),
            directors: Directors::Orthotropic(director([1.0, 0.0, 0.0]), director([0.0, 1.0, 0.0])),
        }),
        fiber: Fiber::Extensible,
    };
    let border = 2.0 * h;
    let clamp = |min: [f64; 2], max: [f64; 2]| {
        Obstacle::fixed(
            ImplicitSurface::Box {
                min: [min[0], min[1], -0.3],
                max: [max[0], max[1], 0.3],
            },
            Contact::Sticky,
        )
    };
    let obstacles = vec![
        clamp([-1.0, -1.0], [border, 2.0]),
        clamp([1.0 - border, -1.0], [2.0, 2.0]),
        clamp([-1.0, -1.0], [2.0, border]),
        clamp([-1.0, 1.0 - border], [2.0, 2.0]),
        Obstacle {
            shape: ImplicitSurface::Sphere {
                center: [0.5, 0.5, scene.radius + 2.0 * half],
                radius: scene.radius,
            },
            contact: Contact::Separate { friction: 0.1 },
            velocity: [0.0, 0.0, -scene.speed],
        },
    ];
    let mut settings = Settings::new(h);
    settings.damage_update = DamageUpdate::Implicit(ImplicitOptions {
        tolerance: 1e-6,
        ..ImplicitOptions::default()
    });
    let mut simulation = Simulation::<f32, MlsMpm<Quadratic>, _, 3>::new(
        settings,
        vec![body],
        obstacles,
        particles,
    )?;
    let view = show::View {
        min: [-0.05, -0.4],
        max: [1.05, 0.85],
        width: 800,
        radius: 0.35 * h,
        tilt: 50.0,
    };
    show::run(
        "orthotropic_sheet",
        &mut simulation,
        scene.frames,
        scene.frame_time,
        &view,
        |_| {},
    )
}
