//! The law against exact derivatives, closed forms of a bar, energies, and the implicit step.
use crate::{Host, lattice};
use aniso_mpm::{Body, Contact, ImplicitStep, Integrator, Obstacle, Settings};
use fem_kinematics::{Dual, ImplicitSurface, Mat};
use fem_materials::field::{Local1, MaterialField};
use fem_materials::{DegradableQr, QrAnisotropic};

const LAW: DegradableQr = QrAnisotropic {
    mu: 3.0,
    lambda: 7.0,
    kx: 11.0,
    ky: 5.0,
}
.degradable(0.01);

/// A value and its derivative along `dF`.
fn dual<const D: usize>(F: &Mat<f64, D>, dF: &Mat<f64, D>) -> Mat<Dual<f64>, D> {
    Mat::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]))
}

fn derivatives_agree<const D: usize>(F: Mat<f64, D>, dF: Mat<f64, D>) {
    for d in [0.0, 0.3, 1.0] {
        let (P, dP) = (
            LAW.stress(&Local1(d), &F),
            LAW.stress_differential(&Local1(d), &F, &dF),
        );
        let with_derivative = dual(&F, &dF);
        let psi = LAW.energy(&Local1(Dual::new(d, 0.0)), &with_derivative);
        assert!((psi.derivative - P.dot(&dF)).abs() < 1e-12, "{d}");
        let stress = LAW.stress(&Local1(Dual::new(d, 0.0)), &with_derivative);
        for i in 0..D {
            for j in 0..D {
                assert!((stress.0[i][j].derivative - dP.0[i][j]).abs() < 1e-11);
            }
        }
    }
}

#[test]
fn stress_and_its_differential_are_derivatives_of_the_energy() {
    let dF = Mat([[0.3, -0.2, 0.5], [0.1, 0.7, -0.4], [-0.6, 0.2, 0.1]]);
    derivatives_agree(
        Mat([[1.2, 0.3, 0.1], [-0.2, 0.9, 0.4], [0.0, 0.1, 1.3]]),
        dF,
    );
    derivatives_agree(
        Mat([[0.6, 0.3, 0.1], [-0.2, -0.5, 0.4], [0.0, 0.1, 0.8]]),
        dF,
    );
    derivatives_agree(
        Mat([[1.1, 0.2], [-0.3, 0.7]]),
        Mat([[0.4, -0.1], [0.2, 0.3]]),
    );
}

/// Σ m v₁ of the particles right of `x` (m).
fn momentum_beyond(x: f64, s: &Host<2>) -> f64 {
    let p = s.particles();
    let right = (0..p.len()).filter(|&i| p.x[i][0] > x);
    right.map(|i| p.mass[i] * p.v[i][0]).sum()
}

/// A bar with fibers along its axis, pulled slowly: the force of a grip (what its half of the bar
/// gains over a step without grips) against uniaxial stress at the stretch of the middle.
#[test]
fn fiber_reinforced_bar_under_tension() {
    let h = 0.05;
    let law = QrAnisotropic::from_young_poisson(1e4, 0.3, 3e4, 0.0).unwrap();
    let length = 1.0;
    let mut particles = lattice::<f64, 2>([0.0; 2], [length, 0.2], 0.025, |_| true);
    let speed = 0.1;
    // As the pulled bar moves: no wave has to bring the grips' start to the middle.
    for p in 0..particles.len() {
        let from_middle = (particles.x[p][0] - 0.5) / 0.45;
        particles.v[p][0] = speed * from_middle.clamp(-1.0, 1.0);
        if from_middle.abs() < 1.0 {
            particles.C[p].0[0][0] = speed / 0.45;
        }
    }
    let grip = |min: f64, max: f64, velocity: f64| Obstacle {
        shape: ImplicitSurface::Box {
            min: [min, -1.0],
            max: [max, 1.0],
        },
        contact: Contact::Sticky,
        velocity: [velocity, 0.0],
    };
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    let mut s = Host::<2>::new(
        settings,
        vec![Body::elastic(law.degradable(1e-3))],
        // They hold the same rows of nodes all the time: a row let go would jolt the bar.
        vec![grip(-0.5, 0.095, -speed), grip(length - 0.095, 1.5, speed)],
        particles,
    )
    .unwrap();
    s.advance(0.3).unwrap();
    let dt = s.stable_step();
    let (mut stretch, mut tension, mut expected) = (0.0, 0.0, 0.0);
    let count = (0.1 / dt).round() as usize;
    for _ in 0..count {
        let (bodies, free) = (s.bodies().to_vec(), s.particles().clone());
        let mut free = Host::<2>::new(settings, bodies, vec![], free).unwrap();
        free.step(dt).unwrap();
        s.step(dt).unwrap();
        // Over the 0.2 m that the bar is wide at rest.
        tension += (momentum_beyond(0.5, &s) - momentum_beyond(0.5, &free)) / (dt * 0.2);
        let p = s.particles();
        let middle: Vec<usize> = (0..p.len())
            .filter(|&i| (p.x[i][0] - 0.5).abs() < 0.15)
            .collect();
        let a = middle.iter().map(|&i| p.F[i].0[0][0]).sum::<f64>() / middle.len() as f64;
        // Closed form: the lateral stretch b with P₂₂ = μ b − μ a + λ (a b − 1) a = 0.
        let b = (law.mu * a + law.lambda * a) / (law.mu + law.lambda * a * a);
        expected += law.mu * a + (law.lambda * (a * b - 1.0) - law.mu) * b + law.kx * (a - 1.0);
        stretch += a;
    }
    let [stretch, tension, expected] = [stretch, tension, expected].map(|v| v / count as f64);
    println!("stretch {stretch:.4}: grip {tension:.1} Pa, closed form {expected:.1} Pa");
    assert!(stretch > 1.05);
    assert!((tension / expected - 1.0).abs() < 0.015);
}

fn oscillating(integrator: Integrator, cells: f64, obstacles: Vec<Obstacle<2>>) -> Host<2> {
    let h = 1.0 / cells;
    let mut particles = lattice([0.0; 2], [0.5; 2], 0.5 * h, |_| true);
    for (v, x) in particles.v.iter_mut().zip(&particles.x) {
        *v = [0.4 * (x[0] - 0.25), -0.3 * (x[1] - 0.25)];
    }
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    settings.integrator = integrator;
    let body = Body::elastic(
        QrAnisotropic::from_young_poisson(2e3, 0.3, 2e3, 0.0)
            .unwrap()
            .degradable(1e-3),
    );
    Host::new(settings, vec![body], obstacles, particles).unwrap()
}

#[test]
fn energy_falls_and_falls_less_on_a_finer_grid() {
    let mut kept = Vec::new();
    for cells in [8.0, 16.0, 32.0] {
        let mut s = oscillating(Integrator::Symplectic, cells, vec![]);
        let total = |s: &Host<2>| {
            let e = s.energies();
            e.kinetic + e.elastic
        };
        let before = total(&s);
        s.advance(0.3).unwrap();
        kept.push(total(&s) / before);
    }
    println!("energy kept after 0.3 s on 8, 16, 32 cells per meter: {kept:?}");
    assert!(kept.iter().all(|k| *k < 1.0), "{kept:?}");
    for (kept, floor) in kept.iter().zip([0.78, 0.93, 0.98]) {
        assert!(*kept > floor, "{kept} {floor}");
    }
}

const ACCURATE: ImplicitStep = ImplicitStep {
    tolerance: 1e-12,
    max_iterations: 30,
};

/// With short steps the implicit step is the explicit one to first order in the step.
fn steps_agree_to_first_order(obstacles: &[Obstacle<2>]) {
    let difference = |dt: f64| {
        let mut a = oscillating(Integrator::Symplectic, 8.0, obstacles.to_vec());
        let mut b = oscillating(Integrator::Implicit(ACCURATE), 8.0, obstacles.to_vec());
        for _ in 0..(0.008 / dt).round() as usize {
            a.step(dt).unwrap();
            b.step(dt).unwrap();
        }
        let (p, q) = (a.particles(), b.particles());
        p.v.iter()
            .zip(&q.v)
            .map(|(p, q)| (p[0] - q[0]).abs().max((p[1] - q[1]).abs()))
            .fold(0.0, f64::max)
    };
    let (long, short) = (difference(4e-3), difference(1e-3));
    println!("difference {long:.2e} with 4 ms, {short:.2e} with 1 ms");
    assert!(long / short > 2.5 && long / short < 6.5);
}

#[test]
fn implicit_and_symplectic_steps_agree_to_first_order() {
    steps_agree_to_first_order(&[]);
}

/// A clamp on the left and a piston from above, which slides on the block.
fn clamp_and_piston() -> [Obstacle<2>; 2] {
    let clamp = Obstacle::fixed(
        ImplicitSurface::Box {
            min: [-1.0, -1.0],
            max: [0.2, 1.5],
        },
        Contact::Sticky,
    );
    let piston = Obstacle {
        shape: ImplicitSurface::HalfSpace {
            point: [0.0, 0.45],
            normal: [0.0, -1.0],
        },
        contact: Contact::Slip,
        velocity: [0.0, -0.2],
    };
    [piston, clamp]
}

#[test]
fn implicit_step_meets_obstacles() {
    steps_agree_to_first_order(&clamp_and_piston());
    let obstacles = clamp_and_piston().to_vec();
    let mut s = oscillating(Integrator::Implicit(ACCURATE), 8.0, obstacles);
    s.step(4e-3).unwrap();
    let p = s.particles();
    for (x, v) in p.x.iter().zip(&p.v) {
        // All nodes under these particles are held.
        if x[0] < 0.05 {
            assert_eq!(*v, [0.0; 2], "{x:?}");
        }
    }
    // The block gives way below the piston, and beside the clamp it does so to the right.
    let right: Vec<_> = (0..p.len()).filter(|&i| p.x[i][0] > 0.4).collect();
    assert!(right.iter().all(|&i| p.v[i][0] > 0.0));
    let top = right.iter().filter(|&&i| p.x[i][1] > 0.4);
    assert!(top.clone().count() > 0 && top.clone().all(|&i| p.v[i][1] < -0.05));
}

#[test]
fn a_long_implicit_step_is_stable() {
    let mut s = oscillating(Integrator::Implicit(ImplicitStep::default()), 8.0, vec![]);
    let before = s.energies();
    // Ten times what the fastest wave allows.
    for _ in 0..10 {
        s.step(0.05).unwrap();
    }
    let after = s.energies();
    assert!(after.kinetic + after.elastic <= before.kinetic + before.elastic);
}
