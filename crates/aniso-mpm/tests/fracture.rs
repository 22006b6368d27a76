//! A notched plate pulled apart: the crack follows the fibres along and across the notch, and turns
//! towards them when they are oblique.
#![allow(non_snake_case)]
use aniso_mpm::damage::{DamageModel, DamageParameters, Directors};
use aniso_mpm::{
    Body, Contact, Fibre, FibreReinforced, MlsMpm, Obstacle, Particle, Particles, Quadratic,
    Settings, Shape, Simulation,
};
use fem_kinematics::Mat;

/// Direction (degrees) of what is broken around the tip, seen in the plate at rest.
fn crack_angle(fibre_angle: f64) -> f64 {
    let cells = 24.0;
    let h = 1.0 / cells;
    let (sin, cos) = f64::to_radians(fibre_angle).sin_cos();
    let notch = 0.3;
    let mut particles = Particles::<f64, 2>::new();
    let mut rest = Vec::new();
    for i in 0..48 * 48 {
        let x = [
            0.5 * h * ((i % 48) as f64 + 0.5),
            0.5 * h * ((i / 48) as f64 + 0.5),
        ];
        if x[0] < notch && (x[1] - 0.5).abs() < h {
            continue;
        }
        rest.push(x);
        // The grips hold a rim that cannot tear.
        let rim = (x[1] - 0.5).abs() > 0.36;
        particles
            .push(&Particle {
                x,
                v: [0.0; 2],
                F: Mat([[cos, -sin], [sin, cos]]),
                mass: 1000.0 * 0.25 * h * h,
                volume: 0.25 * h * h,
                damage: 0.0,
                body: u16::from(rim),
            })
            .unwrap();
    }
    let law = FibreReinforced::from_young_poisson(1e5, 0.3, 2e5, 0.0);
    let tearing = Body {
        law,
        damage: Some(DamageModel {
            parameters: DamageParameters::new(h, 6e3, 2e-3),
            directors: Directors::fibre(-1.0),
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
    let mut settings = Settings::new(h);
    settings.gravity = [0.0; 2];
    let mut s = Simulation::<f64, MlsMpm<Quadratic>, _, 2>::new(
        settings,
        vec![tearing, Body::elastic(law)],
        vec![grip(-0.5, 0.1, -0.1), grip(0.9, 1.5, 0.1)],
        particles,
    )
    .unwrap();
    for _ in 0..60 {
        s.advance(0.01).unwrap();
        let p = s.particles();
        let (mut n, mut xx, mut xy, mut yy) = (0, 0.0, 0.0, 0.0);
        for (&id, &d) in p.id.iter().zip(&p.damage) {
            let x = rest[id as usize];
            let r = [x[0] - notch, x[1] - 0.5];
            // Not the blunt end of the notch itself, which breaks all around.
            if d > 0.5 && (0.1..0.4).contains(&r[0].hypot(r[1])) {
                n += 1;
                xx += r[0] * r[0];
                xy += r[0] * r[1];
                yy += r[1] * r[1];
            }
        }
        if n > 40 {
            return (0.5 * f64::atan2(2.0 * xy, xx - yy)).to_degrees();
        }
    }
    panic!("no crack with fibres at {fibre_angle} degrees");
}

#[test]
fn crack_follows_the_fibre() {
    let cracks = [0.0, 45.0, 90.0].map(|fibre| {
        let crack = crack_angle(fibre);
        println!("fibre at {fibre} degrees: crack at {crack:.1} degrees");
        crack
    });
    // A direction has no sign.
    let off = |crack: f64, fibre: f64| ((crack - fibre + 90.0).rem_euclid(180.0) - 90.0).abs();
    assert!(off(cracks[0], 0.0) < 5.0, "{cracks:?}");
    assert!(off(cracks[2], 90.0) < 5.0, "{cracks:?}");
    // On this coarse grid the oblique crack turns towards the fibres without reaching them: the
    // smeared notch end alone is a fifth of the path.
    assert!((10.0..60.0).contains(&cracks[1]), "{cracks:?}");
}
