//! No NaN, no panic: a clear error or a right answer for states that break a careless program.
use crate::{Host, lattice};
use aniso_mpm::damage::{
    DamageGrid, DamageModel, DamageParameters, Directors, ImplicitOptions, ImplicitSystem,
    driving_force, explicit_update, tensile_part,
};
use aniso_mpm::inextensibility::{FiberGrid, Projection};
use aniso_mpm::{
    Apic, Body, Contact, Cubic, Fiber, ImplicitStep, Integrator, MlsMpm, MpmError, NewtonEnd,
    Obstacle, Particle, Particles, Quadratic, Settings, Simulation, worse,
};
use fem_kinematics::{ImplicitSurface, Mat, Real};
use fem_materials::{DegradableQr, Material, QrAnisotropic};
use fem_solvers::PcgParams;

const H: f64 = 0.1;

fn tearing_body<const D: usize>(fiber: Fiber) -> Body<DegradableQr, D> {
    Body {
        material: QrAnisotropic::from_young_poisson(1e4, 0.3, 2e4, 1e4)
            .unwrap()
            .degradable(1e-3),
        damage: Some(DamageModel {
            parameters: DamageParameters::new(H, 500.0, 1e-2),
            directors: Directors::fiber(-1.0),
        }),
        fiber,
    }
}

fn block<const D: usize>(F: Mat<f64, D>) -> Particles<f64, D> {
    let mut particles = lattice([0.0; D], [0.3; D], 0.05, |_| true);
    particles.F.fill(F);
    particles
}

fn simulation<const D: usize>(particles: Particles<f64, D>, fiber: Fiber) -> Host<D> {
    Host::new(
        Settings::new(H),
        vec![tearing_body(fiber)],
        Obstacle::walls([-1.0; D], [2.0; D], Contact::Separate { friction: 0.3 }),
        particles,
    )
    .unwrap()
}

fn is_finite<const D: usize>(s: &Host<D>) -> bool {
    let p = s.particles();
    let matrices = p.F.iter().chain(&p.C).flat_map(|m| m.0.as_flattened());
    let vectors = p.x.iter().chain(&p.v).flatten();
    vectors.chain(matrices).all(|x| x.is_finite())
        && p.history.iter().all(|h| h.is_finite())
        && p.damage.iter().all(|d| (0.0..=1.0).contains(d))
}

/// Either the run succeeds with a finite state, or it says why and the state is still finite.
fn survives<const D: usize>(mut s: Host<D>) {
    let result = s.advance(0.02);
    assert!(is_finite(&s), "{result:?}");
}

#[test]
fn collapsed_fibers_and_inverted_particles() {
    let mut collapsed = Mat::<f64, 3>::identity();
    collapsed.0[0][0] = 0.0;
    survives(simulation(block(collapsed), Fiber::Extensible));
    survives(simulation(block(collapsed), Fiber::Inextensible));
    survives(simulation(block(Mat::<f64, 3>::zeros()), Fiber::Extensible));
    let mut inverted = Mat::<f64, 3>::identity();
    inverted.0[2][2] = -0.7;
    survives(simulation(block(inverted), Fiber::Extensible));
    survives(simulation(block(inverted), Fiber::Inextensible));
    let mut flat = Mat::<f64, 2>::identity();
    flat.0[1][1] = -1.0;
    survives(simulation(block(flat), Fiber::Inextensible));
}

#[test]
fn one_particle_and_none() {
    let mut one = Particles::new();
    one.push(&Particle {
        x: [0.3; 3],
        v: [0.0; 3],
        F: Mat::identity(),
        mass: 2.0,
        volume: 1e-3,
        damage: 1.0,
        body: 0,
    })
    .unwrap();
    let mut s = simulation(one, Fiber::Inextensible);
    s.advance(0.1).unwrap();
    // Free fall by symplectic Euler in n equal steps: g t²/2 (1 + 1/n).
    let (fallen, exact) = (0.3 - s.particles().x[0][2], 0.5 * 9.81 * 0.01);
    let most = exact * (1.0 + 2.0 / s.steps() as f64);
    assert!(exact < fallen && fallen < most, "{fallen}");
    let mut empty = simulation(Particles::<f64, 2>::new(), Fiber::Extensible);
    empty.advance(0.1).unwrap();
    assert!((empty.time() - 0.1).abs() < 1e-12);
}

#[test]
fn particles_that_leave_the_grid_are_an_error_that_names_them() {
    let mut far = block(Mat::<f64, 2>::identity());
    far.x[7] = [1e9, 0.0];
    let mut s = simulation(far, Fiber::Extensible);
    let before = s.particles().clone();
    match s.advance(0.01) {
        Err(MpmError::ParticleOffGrid { particle: 7, .. }) => {}
        other => panic!("{other:?}"),
    }
    assert_eq!(&before, s.particles());
    // Far but not too far: the grid follows the material.
    let mut away = block(Mat::<f64, 2>::identity());
    for x in &mut away.x {
        x[0] += 1e4;
    }
    let mut s = Simulation::<f64, Apic<Cubic>, _, 2>::new(
        Settings::new(H),
        vec![tearing_body(Fiber::Extensible)],
        vec![],
        away,
    )
    .unwrap();
    s.advance(0.01).unwrap();
    assert!(s.active_blocks() < 20);
}

#[test]
fn a_step_far_too_large_is_rejected_and_the_state_kept() {
    let mut stretched = Mat::<f64, 3>::identity();
    stretched.0[0][0] = 1.5;
    let mut s = simulation(block(stretched), Fiber::Extensible);
    let before = s.particles().clone();
    assert!(matches!(s.step(0.5), Err(MpmError::StepRejected { .. })));
    assert_eq!(&before, s.particles());
    assert_eq!(s.time(), 0.0);
    // The automatic step finds its way.
    s.advance(0.02).unwrap();
    assert!(is_finite(&s));
}

#[test]
fn nonsense_in_the_input_is_an_error() {
    let mut particles = Particles::<f64, 2>::new();
    let good = Particle {
        x: [0.0; 2],
        v: [0.0; 2],
        F: Mat::identity(),
        mass: 1.0,
        volume: 1.0,
        damage: 0.0,
        body: 0,
    };
    assert!(
        particles
            .push(&Particle {
                mass: f64::NAN,
                ..good
            })
            .is_err()
    );
    assert!(
        particles
            .push(&Particle {
                volume: -1.0,
                ..good
            })
            .is_err()
    );
    assert!(
        particles
            .push(&Particle {
                damage: 1.1,
                ..good
            })
            .is_err()
    );
    assert!(
        particles
            .push(&Particle {
                x: [f64::INFINITY, 0.0],
                ..good
            })
            .is_err()
    );
    assert!(particles.is_empty());
    let mut body = tearing_body::<2>(Fiber::Extensible);
    if let Some(damage) = &mut body.damage {
        damage.directors = Directors::fiber(-2.0);
    }
    let made = Host::<2>::new(Settings::new(H), vec![body], vec![], Particles::new());
    assert!(made.is_err());
    assert!(Host::<2>::new(Settings::new(-1.0), vec![], vec![], Particles::new()).is_err());
}

#[test]
fn every_field_of_the_particles_is_checked() {
    let made = |spoil: &dyn Fn(&mut Particles<f64, 2>)| {
        let mut particles = block(Mat::identity());
        spoil(&mut particles);
        let body = tearing_body(Fiber::Extensible);
        Host::<2>::new(Settings::new(H), vec![body], vec![], particles).map(|_| ())
    };
    assert_eq!(made(&|_| {}), Ok(()));
    type Spoil = fn(&mut Particles<f64, 2>);
    let spoils: [(&str, Spoil); 14] = [
        ("x", |p| p.x[3][1] = f64::NAN),
        ("v", |p| p.v[3][0] = f64::INFINITY),
        ("C", |p| p.C[3].0[1][0] = f64::NAN),
        ("F", |p| p.F[3].0[0][1] = f64::NAN),
        ("mass", |p| p.mass[3] = 0.0),
        ("mass", |p| p.mass[3] = f64::NAN),
        ("mass", |p| p.mass[3] = f64::INFINITY),
        ("volume", |p| p.volume[3] = -1.0),
        ("damage", |p| p.damage[3] = 1.1),
        ("damage", |p| p.damage[3] = -0.1),
        ("damage", |p| p.damage[3] = f64::NAN),
        ("history", |p| p.history[3] = f64::NAN),
        ("history", |p| p.history[3] = -1.0),
        ("body", |p| p.body[3] = 1),
    ];
    for (name, spoil) in spoils {
        match made(&spoil) {
            Err(MpmError::Particle {
                particle: 3, field, ..
            }) => assert_eq!(field, name),
            other => panic!("{name}: {other:?}"),
        }
    }
    let cuts: [(&str, Spoil); 9] = [
        ("v", |p| p.v.truncate(2)),
        ("C", |p| p.C.truncate(2)),
        ("F", |p| p.F.truncate(2)),
        ("mass", |p| p.mass.truncate(2)),
        ("volume", |p| p.volume.truncate(2)),
        ("damage", |p| p.damage.truncate(2)),
        ("history", |p| p.history.truncate(2)),
        ("body", |p| p.body.truncate(2)),
        ("id", |p| p.id.truncate(2)),
    ];
    for (name, cut) in cuts {
        match made(&cut) {
            Err(MpmError::Length { what, found: 2, .. }) => assert_eq!(what, name),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn obstacles_that_are_nowhere_are_an_error() {
    let made = |shape: ImplicitSurface<2>, velocity: [f64; 2]| {
        let obstacle = Obstacle {
            shape,
            contact: Contact::Sticky,
            velocity,
        };
        Host::<2>::new(Settings::new(H), vec![], vec![obstacle], Particles::new()).is_ok()
    };
    let sphere = |center| ImplicitSurface::Sphere {
        center,
        radius: 1.0,
    };
    let half_space = |point| ImplicitSurface::HalfSpace {
        point,
        normal: [0.0, 1.0],
    };
    let cuboid = |min, max| ImplicitSurface::Box { min, max };
    assert!(made(sphere([0.0; 2]), [0.0; 2]));
    assert!(made(half_space([0.0; 2]), [0.0; 2]));
    assert!(made(cuboid([0.0; 2], [1.0; 2]), [0.0; 2]));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!made(sphere([0.0; 2]), [0.0, bad]));
        assert!(!made(sphere([bad, 0.0]), [0.0; 2]));
        assert!(!made(half_space([bad, 0.0]), [0.0; 2]));
        assert!(!made(cuboid([bad, 0.0], [1.0; 2]), [0.0; 2]));
        assert!(!made(cuboid([0.0; 2], [1.0, bad]), [0.0; 2]));
    }
}

#[test]
fn elastic_constants_of_no_stable_material_are_an_error() {
    for (young, poisson) in [
        (1e4, 0.5),
        (1e4, 0.7),
        (1e4, -1.0),
        (-1.0, 0.3),
        (f64::NAN, 0.3),
    ] {
        let made = QrAnisotropic::from_young_poisson(young, poisson, 0.0, 0.0);
        assert!(made.is_err(), "{young} {poisson}: {made:?}");
    }
}

/// A driving force that overflows: the step is refused and the last good state stays.
#[test]
fn damage_that_is_not_finite_is_rejected_and_the_state_kept() {
    let mut stretched = Mat::<f64, 2>::identity();
    stretched.0[0][0] = 1.2;
    stretched.0[1][1] = 1.2;
    let mut body = tearing_body(Fiber::Extensible);
    if let Some(damage) = &mut body.damage {
        damage.parameters.sigma_crit = 1e-200;
    }
    let mut s = Host::<2>::new(Settings::new(H), vec![body], vec![], block(stretched)).unwrap();
    let before = s.particles().clone();
    for _ in 0..2 {
        match s.advance(1e-3) {
            Err(MpmError::StepRejected { particle: 0, .. }) => {}
            other => panic!("{other:?}"),
        }
        assert_eq!(&before, s.particles());
        assert_eq!(s.time(), 0.0);
    }
}

#[test]
fn nan_stays_where_the_worst_is_looked_for() {
    let worst = |values: &[f64]| -> f64 { values.iter().copied().fold(0.0, worse) };
    assert!(worst(&[f64::NAN, 1.0, 2.0]).is_nan());
    assert!(worst(&[1.0, f64::NAN, 2.0]).is_nan());
    assert!(worst(&[1.0, 2.0, f64::NAN]).is_nan());
    assert_eq!(worst(&[1.0, 3.0, 2.0]), 3.0);
    assert_eq!(worst(&[1.0, f64::INFINITY, 2.0]), f64::INFINITY);

    // A stress that is NaN drives a crack by NaN, not by nothing.
    let parameters = DamageParameters::new(H, 1.0, 0.05);
    let sigma = Mat::<f64, 2>::identity().scale(f64::NAN);
    assert!(tensile_part(&sigma).trace().is_nan());
    let directors = Directors::fiber(-1.0);
    assert!(driving_force(&parameters, &directors, &Mat::identity(), &sigma, 0.0).is_nan());
    assert!(explicit_update(&parameters, 0.3, f64::NAN, 0.0, 1e-3).is_nan());
    assert!(explicit_update(&parameters, 0.3, 1.0, f64::NAN, 1e-3).is_nan());

    // The first particle alone is NaN, and all other rows are solved from the start.
    let x: Vec<[f64; 2]> = (0..100)
        .map(|i| [0.1 * f64::from(i % 10), 0.1 * f64::from(i / 10)])
        .collect();
    let mut d = vec![0.0; 100];
    d[0] = f64::NAN;
    let (volume, force) = (vec![0.01; 100], vec![0.0; 100]);
    let mut grid = DamageGrid::<2>::new(H);
    grid.particles_to_grid(&x, &d).unwrap();
    let constants = |_| parameters;
    let options = ImplicitOptions::default();
    let system = ImplicitSystem::new(&grid, &volume, &force, &d, 1e-3, &constants, &options);
    assert!(system.unwrap().solve(1e-10).is_err());

    // A velocity that is NaN at the first node of the fibers.
    let fibers = FiberGrid::new(H, &x, &volume, &vec![[1.0, 0.0]; 100]).unwrap();
    let inverse_mass = vec![1.0; fibers.len()];
    let projection = Projection::new(&fibers, &inverse_mass, &[]).unwrap();
    let mut v = vec![[0.0; 2]; fibers.len()];
    assert!(projection.project(v.clone(), &PcgParams::default()).is_ok());
    v[projection.matrix().nodes()[0] as usize] = [f64::NAN; 2];
    assert!(projection.project(v, &PcgParams::default()).is_err());
}

/// A material whose stress points uphill: no step along Newton's direction lowers the energy.
#[derive(Clone, Copy)]
struct Uphill;
impl Material<2> for Uphill {
    fn energy<T: Real>(&self, F: &Mat<T, 2>) -> T {
        F.norm_squared() * T::from_f64(1e4)
    }
    fn stress<T: Real>(&self, F: &Mat<T, 2>) -> Mat<T, 2> {
        F.scale(T::from_f64(-2e4))
    }
    fn stress_differential<T: Real>(&self, _: &Mat<T, 2>, _: &Mat<T, 2>) -> Mat<T, 2> {
        Mat::zeros()
    }
}

/// Every Newton failure says what it measured: the change of the last step and how many were taken.
#[test]
fn newton_names_what_it_ended_with() {
    let mut settings = Settings::new(H);
    settings.integrator = Integrator::Implicit(ImplicitStep {
        tolerance: 0.0,
        max_iterations: 2,
    });
    let mut stretched = Mat::<f64, 2>::identity();
    stretched.0[0][0] = 1.2;
    let body = tearing_body(Fiber::Extensible);
    let mut s = Host::<2>::new(settings, vec![body], vec![], block(stretched)).unwrap();
    match s.step(1e-3) {
        Err(MpmError::Newton {
            iterations: 2,
            change,
            tolerance: 0.0,
            ..
        }) => assert!(change > 0.0 && change < 1.0, "{change}"),
        other => panic!("{other:?}"),
    }

    let bodies = vec![Body::elastic(Uphill)];
    let particles = block(Mat::identity());
    let mut s =
        Simulation::<f64, MlsMpm<Quadratic>, _, 2>::new(settings, bodies, vec![], particles)
            .unwrap();
    match s.step(1e-2) {
        Err(MpmError::Newton {
            iterations: 0,
            change: f64::INFINITY,
            reason,
            ..
        }) => assert_eq!(reason, NewtonEnd::NoDecrease),
        other => panic!("{other:?}"),
    }
}

/// A material that has lost its numbers.
#[derive(Clone, Copy)]
struct NotANumber;
impl Material<2> for NotANumber {
    fn energy<T: Real>(&self, _: &Mat<T, 2>) -> T {
        T::from_f64(f64::NAN)
    }
    fn stress<T: Real>(&self, F: &Mat<T, 2>) -> Mat<T, 2> {
        F.scale(T::from_f64(f64::NAN))
    }
    fn stress_differential<T: Real>(&self, _: &Mat<T, 2>, dF: &Mat<T, 2>) -> Mat<T, 2> {
        *dF
    }
}

#[test]
fn a_stress_that_is_not_a_number_is_an_error_and_the_state_kept() {
    for integrator in [
        Integrator::Symplectic,
        Integrator::Implicit(ImplicitStep::default()),
    ] {
        let mut settings = Settings::new(H);
        settings.integrator = integrator;
        let bodies = vec![Body::elastic(NotANumber)];
        let particles = block(Mat::identity());
        let mut s =
            Simulation::<f64, MlsMpm<Quadratic>, _, 2>::new(settings, bodies, vec![], particles)
                .unwrap();
        let before = s.particles().clone();
        assert!(s.step(1e-3).is_err(), "{integrator:?}");
        assert!(s.advance(1e-3).is_err(), "{integrator:?}");
        assert_eq!(*s.particles(), before, "{integrator:?}");
        assert_eq!(s.time(), 0.0);
    }
}
