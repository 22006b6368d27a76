//! No NaN, no panic: a clear error or a right answer for states that break a careless program.
use crate::{Host, lattice};
use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{
    Apic, Body, Contact, Cubic, Fibre, FibreReinforced, MpmError, Obstacle, Particle, Particles,
    Settings, Simulation,
};
use fem_kinematics::Mat;

const H: f64 = 0.1;

fn tearing_body<const D: usize>(fibre: Fibre) -> Body<FibreReinforced, D> {
    Body {
        law: FibreReinforced::from_young_poisson(1e4, 0.3, 2e4, 1e4),
        damage: Some(DamageModel {
            parameters: DamageParameters::new(H, 500.0, 1e-2),
            directors: Directors::fibre(-1.0),
        }),
        fibre,
    }
}

fn block<const D: usize>(F: Mat<f64, D>) -> Particles<f64, D> {
    let mut particles = lattice([0.0; D], [0.3; D], 0.05, |_| true);
    particles.F.fill(F);
    particles
}

fn simulation<const D: usize>(particles: Particles<f64, D>, fibre: Fibre) -> Host<D> {
    Host::new(
        Settings::new(H),
        vec![tearing_body(fibre)],
        Obstacle::walls([-1.0; D], [2.0; D], Contact::Separate { friction: 0.3 }),
        particles,
    )
    .unwrap()
}

fn is_finite<const D: usize>(s: &Host<D>) -> bool {
    let p = s.particles();
    p.x.iter().flatten().all(|x| x.is_finite())
        && p.F
            .iter()
            .flat_map(|F| F.0.as_flattened())
            .all(|x| x.is_finite())
        && p.damage.iter().all(|d| (0.0..=1.0).contains(d))
}

/// Either the run succeeds with a finite state, or it says why and the state is still finite.
fn survives<const D: usize>(mut s: Host<D>) {
    let result = s.advance(0.02);
    assert!(is_finite(&s), "{result:?}");
}

#[test]
fn collapsed_fibres_and_inverted_particles() {
    let mut collapsed = Mat::<f64, 3>::identity();
    collapsed.0[0][0] = 0.0;
    survives(simulation(block(collapsed), Fibre::Extensible));
    survives(simulation(block(collapsed), Fibre::Inextensible));
    survives(simulation(block(Mat::<f64, 3>::zeros()), Fibre::Extensible));
    let mut inverted = Mat::<f64, 3>::identity();
    inverted.0[2][2] = -0.7;
    survives(simulation(block(inverted), Fibre::Extensible));
    survives(simulation(block(inverted), Fibre::Inextensible));
    let mut flat = Mat::<f64, 2>::identity();
    flat.0[1][1] = -1.0;
    survives(simulation(block(flat), Fibre::Inextensible));
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
    let mut s = simulation(one, Fibre::Inextensible);
    s.advance(0.1).unwrap();
    // Free fall by symplectic Euler in n equal steps: g t²/2 (1 + 1/n).
    let (fallen, exact) = (0.3 - s.particles().x[0][2], 0.5 * 9.81 * 0.01);
    let most = exact * (1.0 + 2.0 / s.steps() as f64);
    assert!(exact < fallen && fallen < most, "{fallen}");
    let mut empty = simulation(Particles::<f64, 2>::new(), Fibre::Extensible);
    empty.advance(0.1).unwrap();
    assert!((empty.time() - 0.1).abs() < 1e-12);
}

#[test]
fn particles_that_leave_the_grid_are_an_error_that_names_them() {
    let mut far = block(Mat::<f64, 2>::identity());
    far.x[7] = [1e9, 0.0];
    let mut s = simulation(far, Fibre::Extensible);
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
        vec![tearing_body(Fibre::Extensible)],
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
    let mut s = simulation(block(stretched), Fibre::Extensible);
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
    let mut body = tearing_body::<2>(Fibre::Extensible);
    if let Some(damage) = &mut body.damage {
        damage.directors = Directors::fibre(-2.0);
    }
    let made = Host::<2>::new(Settings::new(H), vec![body], vec![], Particles::new());
    assert!(made.is_err());
    assert!(Host::<2>::new(Settings::new(-1.0), vec![], vec![], Particles::new()).is_err());
}
