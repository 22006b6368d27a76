//! A notched plate with fibers is pulled equally on all sides; the crack follows the fibers.
//!
//! `cargo run --release -p aniso-mpm --example tear [fiber angle in degrees] [cells per meter]`
#![allow(non_snake_case)]
mod show;

use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{
    Body, Contact, Fiber, MlsMpm, Obstacle, Particles, Quadratic, Settings, Simulation,
};
use fem_kinematics::{ImplicitSurface, Mat};
use fem_materials::QrAnisotropic;

/// Everything that can be changed about the scene.
struct Scene {
    /// Angle between the fibers and the notch, degrees.
    fiber_angle: f64,
    /// Cells along a side of the 1 m plate; 2×2 particles per cell.
    cells: usize,
    /// Depth of the notch, m.
    notch: f64,
    /// Young's modulus (Pa) and Poisson's ratio of the matrix.
    young: f64,
    poisson: f64,
    /// Fiber stiffness, Pa.
    kx: f64,
    /// Density, kg/m³.
    density: f64,
    /// Weight α of the fiber in the structural tensor: −1 lets cracks run along it only.
    alpha: f64,
    /// Critical stress, Pa.
    sigma_crit: f64,
    /// Crack viscosity, s: a crack much faster than this one keeps to the rows of the grid.
    eta: f64,
    /// Speed of each wall, m/s.
    pull: f64,
    /// Frames and their length, s.
    frames: usize,
    frame_time: f64,
}

const SCENE: Scene = Scene {
    fiber_angle: 45.0,
    cells: 60,
    notch: 0.3,
    young: 1e5,
    poisson: 0.3,
    kx: 2e5,
    density: 1000.0,
    alpha: -1.0,
    sigma_crit: 6e3,
    eta: 0.2,
    pull: 0.1,
    frames: 32,
    frame_time: 0.008,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = SCENE;
    if let Some(angle) = std::env::args().nth(1) {
        scene.fiber_angle = angle.parse()?;
    }
    if let Some(cells) = std::env::args().nth(2) {
        scene.cells = cells.parse()?;
    }
    let h = 1.0 / scene.cells as f64;
    let (sin, cos) = scene.fiber_angle.to_radians().sin_cos();
    // The fiber frame: e₁ along the fibers.
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
    // The walls hold a rim that cannot tear.
    for (body, x) in particles.body.iter_mut().zip(&particles.x) {
        *body = u16::from(x.iter().any(|x| (x - 0.5).abs() > 0.4));
    }
    let material = QrAnisotropic::from_young_poisson(scene.young, scene.poisson, scene.kx, 0.0)?
        .degradable(1e-3);
    let body = Body {
        material,
        damage: Some(DamageModel {
            parameters: DamageParameters::new(h, scene.sigma_crit, scene.eta),
            directors: Directors::fiber(scene.alpha),
        }),
        fiber: Fiber::Extensible,
    };
    let mut walls = Vec::new();
    for axis in 0..2 {
        for sign in [-1.0, 1.0] {
            let (mut point, mut normal, mut velocity) = ([0.5; 2], [0.0; 2], [0.0; 2]);
            point[axis] += 0.4 * sign;
            normal[axis] = -sign;
            velocity[axis] = sign * scene.pull;
            walls.push(Obstacle {
                shape: ImplicitSurface::HalfSpace { point, normal },
                contact: Contact::Slip,
                velocity,
            });
        }
    }
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    let mut simulation = Simulation::<f64, MlsMpm<Quadratic>, _, 2>::new(
        settings,
        vec![body, Body::elastic(material)],
        walls,
        particles,
    )?;
    let view = show::View {
        min: [-0.3, -0.3],
        max: [1.3, 1.3],
        width: 640,
        radius: 0.3 * h,
        tilt: 0.0,
    };
    let mut crack = None;
    let name = format!("tear_{}", scene.fiber_angle);
    show::run(
        &name,
        &mut simulation,
        scene.frames,
        scene.frame_time,
        &view,
        |simulation| {
            let angle = crack_angle(simulation.particles(), &rest, [notch, 0.5], h);
            crack = crack.or(angle);
        },
    )?;
    match crack {
        Some(angle) => println!(
            "fibers at {:.1} degrees, crack at {angle:.1} degrees",
            scene.fiber_angle
        ),
        None => println!("the crack is shorter than 0.3 m"),
    }
    Ok(())
}

/// Principal direction of the broken particles ahead of the tip in the plate at rest, once the
/// crack is 0.3 m long.
fn crack_angle(
    particles: &Particles<f64, 2>,
    rest: &[[f64; 2]],
    tip: [f64; 2],
    h: f64,
) -> Option<f64> {
    let ahead: Vec<[f64; 2]> = (0..particles.len())
        .filter(|&p| particles.damage[p] > 0.5)
        .map(|p| rest[particles.id[p] as usize])
        .map(|x| [x[0] - tip[0], x[1] - tip[1]])
        .filter(|r| (0.08..0.3).contains(&r[0].hypot(r[1])))
        .collect();
    if !ahead.iter().any(|r| r[0].hypot(r[1]) > 0.3 - h) {
        return None;
    }
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| ahead.iter().map(f).sum::<f64>() / ahead.len() as f64;
    let (x, y) = (mean(&|r| r[0]), mean(&|r| r[1]));
    let xx = mean(&|r| (r[0] - x).powi(2));
    let yy = mean(&|r| (r[1] - y).powi(2));
    let xy = mean(&|r| (r[0] - x) * (r[1] - y));
    Some((0.5 * (2.0 * xy).atan2(xx - yy)).to_degrees())
}
