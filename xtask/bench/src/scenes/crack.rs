//! The crack of a notched plate of fibers, pulled on all sides, on grids that lie at several angles
//! to the plate: `docs/aniso-mpm.md`.

use super::Scene;
use super::mpm::lattice;
use crate::curve::{Axis, Claim, Curve, Point};
use crate::failure::Failure;
use crate::settings::Settings;
use crate::timing::fastest_with;
use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{
    Body, Contact, Fiber, MlsMpm, Obstacle, Particles, Quadratic, Settings as Host, Simulation,
};
use fem_kinematics::{ImplicitSurface, Mat};
use fem_materials::{DegradableQr, QrAnisotropic};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "crack",
    about: "the angle between crack and fibers in a notched plate",
    measure: "degrees",
    truth: "a crack between fibers runs along them",
    run: curves,
    counted: Some(|| {
        let (mut plate, rest) = plate(SHORT, 30.0, 16, 0.0)?;
        crack(SHORT, &mut plate, &rest, 16).map(|_| ())
    }),
};

/// A plate: how long its notch is, m, and the resistance η of its damage, s.
#[derive(Clone, Copy)]
struct Plan {
    notch: f64,
    eta: f64,
}

/// As in the tests of `aniso-mpm`: a slow crack from a short notch.
const SHORT: Plan = Plan {
    notch: 0.3,
    eta: 0.2,
};
/// A notch that ends in the middle, so that both sides of a crack across it are alike, and a crack that
/// is faster than the flesh beside it turns away.
const HALF: Plan = Plan {
    notch: 0.5,
    eta: 0.06,
};
const CENTER: f64 = 0.5;
/// Where the crack is measured: beyond the blunt end of the notch, m from its tip.
const NEAR: f64 = 0.08;
const FAR: f64 = 0.3;

type Plate = Simulation<f64, MlsMpm<Quadratic>, DegradableQr, 2>;

/// Turned about the middle of the plate.
fn turned(x: [f64; 2], angle: f64) -> [f64; 2] {
    let [x, y] = along([x[0] - CENTER, x[1] - CENTER], angle);
    [CENTER + x, CENTER + y]
}

fn along([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// The plate, and its particles' places before the grid was turned against it.
fn plate(
    plan: Plan,
    fiber: f64,
    cells: usize,
    turn: f64,
) -> Result<(Plate, Vec<[f64; 2]>), Failure> {
    let h = 1.0 / cells as f64;
    let mut particles: Particles<f64, 2> = lattice(1.0, 0.5 * h, |x| {
        x[0] > plan.notch || (x[1] - CENTER).abs() > h
    })?;
    let rest = particles.x.clone();
    let (sin, cos) = (fiber + turn).to_radians().sin_cos();
    for (p, &x) in rest.iter().enumerate() {
        particles.x[p] = turned(x, turn.to_radians());
        particles.F[p] = Mat([[cos, -sin], [sin, cos]]);
        // The walls hold a rim that cannot tear.
        particles.body[p] = u16::from(x.iter().any(|x| (x - CENTER).abs() > 0.4));
    }
    let material = QrAnisotropic::from_young_poisson(1e5, 0.3, 2e5, 0.0)?.degradable(1e-3);
    let tearing = Body {
        material,
        damage: Some(DamageModel {
            parameters: DamageParameters::new(h, 6e3, plan.eta),
            directors: Directors::fiber(-1.0),
        }),
        fiber: Fiber::Extensible,
    };
    let wall = |outward: [f64; 2]| {
        let outward = along(outward, turn.to_radians());
        let shape = ImplicitSurface::HalfSpace {
            point: outward.map(|c| CENTER + 0.4 * c),
            normal: outward.map(|c| -c),
        };
        let mut wall = Obstacle::fixed(shape, Contact::Slip);
        wall.velocity = outward.map(|c| 0.1 * c);
        wall
    };
    let walls = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]].map(wall);
    let mut settings = Host::new(h);
    settings.gravity = [0.0; 2];
    settings.stiffness = 0.4;
    let bodies = vec![tearing, Body::elastic(material)];
    let plate = Simulation::new(settings, bodies, walls.to_vec(), particles)?;
    Ok((plate, rest))
}

/// The direction of the crack that leaves the notch when it is 0.3 m long, degrees, in the plate at
/// rest. Across the notch two leave it, up and down: the longer one counts. What breaks elsewhere, at
/// the rim, does not.
fn crack(plan: Plan, plate: &mut Plate, rest: &[[f64; 2]], cells: usize) -> Result<f64, Failure> {
    let h = 1.0 / cells as f64;
    while plate.time() < 0.8 {
        plate.advance(0.0025)?;
        let p = plate.particles();
        let broken = (0..p.len()).filter(|&i| p.damage[i] > 0.5);
        let from_tip = broken.map(|i| rest[p.id[i] as usize]);
        let from_tip = from_tip.map(|x| [x[0] - plan.notch, x[1] - CENTER]);
        let crack = joined(from_tip.collect(), h);
        if let Some(&end) = crack.iter().find(|r| r[0].hypot(r[1]) > FAR - h) {
            let ahead = |r: &&[f64; 2]| {
                let distance = r[0].hypot(r[1]);
                (NEAR..FAR).contains(&distance) && r[0] * end[0] + r[1] * end[1] > 0.0
            };
            let ahead: Vec<[f64; 2]> = crack.iter().filter(ahead).copied().collect();

            return Ok(principal_direction(&ahead));
        }
    }
    Ok(f64::INFINITY)
}

/// The points that hang together with those around the tip, the origin, by steps of at most a cell.
fn joined(mut left: Vec<[f64; 2]>, cell: f64) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut edge = vec![[0.0; 2]];
    let mut reach = NEAR;
    while let Some(from) = edge.pop() {
        let near = |r: &[f64; 2]| (r[0] - from[0]).hypot(r[1] - from[1]) <= reach;
        let (next, rest): (Vec<[f64; 2]>, Vec<[f64; 2]>) = left.into_iter().partition(near);
        edge.extend(&next);
        found.extend(next);
        left = rest;
        reach = 1.01 * cell;
    }
    found
}

/// Direction in which points are spread most widely about their center, degrees.
fn principal_direction(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|r| r[0]), mean(&|r| r[1]));
    let xx = mean(&|r| (r[0] - x).powi(2));
    let yy = mean(&|r| (r[1] - y).powi(2));
    let xy = mean(&|r| (r[0] - x) * (r[1] - y));
    (0.5 * f64::atan2(2.0 * xy, xx - yy)).to_degrees()
}

fn curves(settings: &Settings) -> Result<Vec<Curve>, Failure> {
    let angles: &[f64] = match settings.quick {
        true => &[0.0, 30.0, 60.0, 90.0],
        false => &[0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0],
    };
    let turns: &[f64] = settings.pick(&[0.0, 30.0], &[0.0, 15.0, 30.0]);
    let mut curves = Vec::new();
    for (plan, which) in [(SHORT, "short notch"), (HALF, "half notch, fast")] {
        for &cells in settings.pick(&[24][..], &[32, 48]) {
            for &turn in turns {
                let name = format!("{which}, {cells} cells/m, grid at {turn}");
                let mut curve = Curve::new(name, Axis::Angle, Claim::Nothing);
                for &fiber in angles {
                    curve.points.push(torn(plan, fiber, cells, turn)?);
                }
                curves.push(curve);
            }
        }
    }
    Ok(curves)
}

/// Crack minus fiber, degrees, both from the notch.
fn torn(plan: Plan, fiber: f64, cells: usize, turn: f64) -> Result<Point, Failure> {
    let timed = fastest_with(
        1,
        || plate(plan, fiber, cells, turn),
        |(plate, rest)| {
            let found = crack(plan, plate, rest, cells)?;
            Ok((found, plate.steps(), plate.particles().len()))
        },
    )?;
    let (found, steps, count) = timed.value;
    Ok(Point {
        setting: format!("{fiber}"),
        error: (found - fiber + 90.0).rem_euclid(180.0) - 90.0,
        seconds: timed.seconds,
        unknowns: 2 * count,
        steps,
        memory: timed.memory,
        ..Point::default()
    })
}
