//! Two soft blocks hang from a clamp: the right one has vertical fibers that do not stretch.
//!
//! `cargo run --release -p aniso-mpm --example hanging_block`
mod show;

use aniso_mpm::{
    Body, Contact, Fiber, MlsMpm, Obstacle, Particles, Quadratic, Settings, Simulation,
};
use fem_kinematics::{ImplicitSurface, Mat};
use fem_materials::QrAnisotropic;

/// Everything that can be changed about the scene.
struct Scene {
    /// Cell size, m; 2×2×2 particles per cell.
    cell: f64,
    /// Width, depth and height of each block, m.
    size: [f64; 3],
    /// Young's modulus (Pa), Poisson's ratio, density (kg/m³).
    young: f64,
    poisson: f64,
    density: f64,
    /// Frames and their length, s.
    frames: usize,
    frame_time: f64,
}

const SCENE: Scene = Scene {
    cell: 0.05,
    size: [0.2, 0.1, 0.5],
    young: 2e4,
    poisson: 0.3,
    density: 1000.0,
    frames: 25,
    frame_time: 0.02,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = SCENE;
    let [w, depth, height] = scene.size;
    // e₁ of the fiber frame points down.
    let upright = Mat([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    let mut particles = Particles::<f64, 3>::new();
    for (body, left) in [(0, 0.0), (1, w + 0.25)] {
        show::fill_box(
            &mut particles,
            [left, 0.0, -height],
            [left + w, depth, 0.0],
            0.5 * scene.cell,
            scene.density,
            body,
            upright,
            |_| true,
        )?;
    }
    let material =
        QrAnisotropic::from_young_poisson(scene.young, scene.poisson, 0.0, 0.0)?.degradable(1e-3);
    let bodies = vec![
        Body::elastic(material),
        Body {
            fiber: Fiber::Inextensible,
            ..Body::elastic(material)
        },
    ];
    let clamp = Obstacle::fixed(
        ImplicitSurface::HalfSpace {
            point: [0.0, 0.0, -2.0 * scene.cell],
            normal: [0.0, 0.0, -1.0],
        },
        Contact::Sticky,
    );
    let settings = Settings::new(scene.cell);
    let mut simulation =
        Simulation::<f64, MlsMpm<Quadratic>, _, 3>::new(settings, bodies, vec![clamp], particles)?;
    let view = show::View {
        min: [-0.2, -0.9],
        max: [2.0 * w + 0.45, 0.1],
        width: 420,
        radius: 0.3 * scene.cell,
        tilt: 0.0,
    };
    show::run(
        "hanging_block",
        &mut simulation,
        scene.frames,
        scene.frame_time,
        &view,
        |_| {},
    )?;
    for body in [0, 1] {
        let p = simulation.particles();
        let stretch = (0..p.len())
            .filter(|&i| p.body[i] == body)
            .map(|i| p.F[i].column(0).iter().map(|c| c * c).sum::<f64>().sqrt())
            .fold((f64::MAX, f64::MIN), |(low, high), s| {
                (low.min(s), high.max(s))
            });
        println!(
            "body {body}: fiber stretch {:.4} to {:.4}",
            stretch.0, stretch.1
        );
    }
    Ok(())
}
