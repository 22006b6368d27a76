//! The crack of a notched plate runs along the fibers, tested at 20, 45 and 60 degrees to the notch
//! and the grid: within 4 degrees on 32 cells per meter, and at 45 within 5 on 24. No other oblique
//! angle is tested, and not all would pass: this plate tears 6 and 8 degrees off the fibers at 10 and
//! 70, and at 80 and 90 it turns back over the notch by 40 (`docs/bench/crack.csv`, `docs/bench.md`
//! says why). Nor does the crack converge to the angle of the fibers: at 45 degrees it runs at 43.0,
//! 46.9 and 50.2 on 24, 32 and 48 cells (with steps of the default length; `docs/aniso-mpm.md` has the
//! table, and `tear ANGLE CELLS` repeats a row of it).
//!
//! The plate is pulled equally on all sides: nothing but the fibers then prefers a direction. (In
//! a plate that is pulled across the notch only, the faces of an oblique crack also slide, and the
//! model's own crack turns towards the notch by ten degrees and more on every grid.)
use crate::{Host, lattice};
use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{Body, Contact, Fiber, Obstacle, Settings};
use fem_kinematics::{ImplicitSurface, Mat};
use fem_materials::QrAnisotropic;

const NOTCH: f64 = 0.3;

/// Direction (degrees) of what is broken ahead of the tip when the crack is 0.3 m long, in the
/// plate at rest, for fibers at `fiber` degrees on a grid of `cells` per meter.
fn crack_angle(fiber: f64, cells: f64) -> f64 {
    let h = 1.0 / cells;
    let (sin, cos) = fiber.to_radians().sin_cos();
    let mut particles = lattice([0.0; 2], [1.0; 2], 0.5 * h, |x| {
        x[0] > NOTCH || (x[1] - 0.5).abs() > h
    });
    let rest = particles.x.clone();
    for (p, x) in rest.iter().enumerate() {
        particles.F[p] = Mat([[cos, -sin], [sin, cos]]);
        // The walls hold a rim that cannot tear.
        particles.body[p] = u16::from(x.iter().any(|x| (x - 0.5).abs() > 0.4));
    }
    let material = QrAnisotropic::from_young_poisson(1e5, 0.3, 2e5, 0.0)
        .unwrap()
        .degradable(1e-3);
    let tearing = Body {
        material,
        damage: Some(DamageModel {
            // A crack slow enough for the grid: with η of some milliseconds it outruns the
            // stress of the turned direction and keeps to the rows of the grid.
            parameters: DamageParameters::new(h, 6e3, 0.2),
            directors: Directors::fiber(-1.0),
        }),
        fiber: Fiber::Extensible,
    };
    let mut walls = Vec::new();
    for axis in 0..2 {
        for sign in [-1.0, 1.0] {
            let mut wall = Obstacle::fixed(
                ImplicitSurface::HalfSpace {
                    point: [0.5; 2],
                    normal: [0.0; 2],
                },
                Contact::Slip,
            );
            if let ImplicitSurface::HalfSpace { point, normal } = &mut wall.shape {
                point[axis] += 0.4 * sign;
                normal[axis] = -sign;
            }
            wall.velocity[axis] = 0.1 * sign;
            walls.push(wall);
        }
    }
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    settings.stiffness = 0.7;
    let bodies = vec![tearing, Body::elastic(material)];
    let mut s = Host::<2>::new(settings, bodies, walls, particles).unwrap();
    while s.time() < 0.4 {
        s.advance(0.0025).unwrap();
        let p = s.particles();
        let ahead: Vec<[f64; 2]> = (0..p.len())
            .filter(|&i| p.damage[i] > 0.5)
            .map(|i| rest[p.id[i] as usize])
            .map(|x| [x[0] - NOTCH, x[1] - 0.5])
            // Not the blunt end of the notch itself, which breaks all around.
            .filter(|r| (0.08..0.3).contains(&r[0].hypot(r[1])))
            .collect();
        if ahead.iter().any(|r| r[0].hypot(r[1]) > 0.3 - h) {
            return principal_direction(&ahead);
        }
    }
    panic!("no crack with fibers at {fiber} degrees");
}

/// Direction (degrees) in which points are spread most widely about their center.
fn principal_direction(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|r| r[0]), mean(&|r| r[1]));
    let xx = mean(&|r| (r[0] - x).powi(2));
    let yy = mean(&|r| (r[1] - y).powi(2));
    let xy = mean(&|r| (r[0] - x) * (r[1] - y));
    (0.5 * f64::atan2(2.0 * xy, xx - yy)).to_degrees()
}

/// Angle between crack and fiber, printed; a direction has no sign.
fn deviation(fiber: f64, cells: f64) -> f64 {
    let crack = crack_angle(fiber, cells);
    println!("fibers at {fiber} degrees, {cells} cells per meter: crack at {crack:.1} degrees");
    ((crack - fiber + 90.0).rem_euclid(180.0) - 90.0).abs()
}

/// Plate, grid and fibers are symmetric about the notch, and so is what is measured: it can be 0 or 90
/// degrees and nothing between. The test tells these two apart; of the two branches of the crack
/// across the notch it says no more than that.
#[test]
fn crack_follows_the_fiber_along_and_across_the_notch() {
    assert!(deviation(0.0, 24.0) < 5.0);
    assert!(deviation(90.0, 24.0) < 5.0);
}

#[test]
fn crack_follows_the_oblique_fiber_on_24_cells_better_than_on_16() {
    let fine = deviation(45.0, 24.0);
    assert!(fine < 5.0);
    // On 16 cells the crack is not much longer than wide when it is measured.
    assert!(deviation(45.0, 16.0) > fine);
}

#[test]
fn crack_follows_oblique_fibers_on_32_cells() {
    for fiber in [20.0, 45.0, 60.0] {
        assert!(deviation(fiber, 32.0) < 4.0);
    }
}
