//! Energies and stresses that lose no digits near rest and near rotations.

use crate::numbers::{Numbers, norm};
use fem_kinematics::Mat;
use fem_materials::isotropic::{ByStretches, FirstInvariant, Volume};
use fem_materials::*;

/// ψ at R (I + εG) is ε² times a number that hardly depends on ε; an energy that cancels would be
/// off by 1e-16/ε².
fn keeps_digits<M: Material<3>>(material: M, name: &str) {
    let material = Outlined(material);
    let mut numbers = Numbers(31);
    let (R, G) = (numbers.rotation::<3>(), numbers.matrix::<3>());
    let exact = material.energy(&(Mat::identity() + G.scale(1e-4))) / 1e-8;
    for (epsilon, rotation, tolerance) in [
        (1e-6, Mat::identity(), 1e-3),
        (1e-8, Mat::identity(), 1e-3),
        (1e-6, R, 1e-3),
        (1e-9, R, 1e-3),
    ] {
        // a rotation of f64 numbers is off by 1e-16, which is a strain
        let strain: f64 = if rotation == R { 1e-15 } else { 0.0 };
        let F = rotation * (Mat::identity() + G.scale(epsilon));
        let got = material.energy(&F) / (epsilon * epsilon);
        let allowed = tolerance + 20.0 * strain / epsilon;
        assert!(
            (got / exact - 1.0).abs() < allowed,
            "{name} at {epsilon}: {got} for {exact}"
        );
        let P = material.stress(&F);
        assert!(norm(&P) > 0.0);
    }
    let rest = Mat::identity();
    assert_eq!(material.energy(&rest), 0.0, "{name}");
    assert_eq!(norm(&material.stress(&rest)), 0.0, "{name}");
}

#[test]
fn energies_keep_their_digits() {
    let (mu, lambda) = (1.0, 1.5);
    keeps_digits(NeoHookean { mu, lambda }, "neo-Hookean");
    keeps_digits(StVenantKirchhoff { mu, lambda }, "StVK");
    keeps_digits(StableNeoHookeanNoLog { mu, lambda }, "stable neo-Hookean");
    keeps_digits(
        QrAnisotropic {
            mu,
            lambda,
            kx: 10.0,
            ky: 4.0,
        },
        "QR",
    );
    keeps_digits(
        FirstInvariant {
            shape: Yeoh {
                c: [1.0, -0.1, 0.1],
            },
            volume: Volume { K: 5.0 },
        },
        "Yeoh",
    );
    keeps_digits(
        FirstInvariant {
            shape: Gent {
                mu: 1.0,
                limit: 20.0,
            },
            volume: Volume { K: 5.0 },
        },
        "Gent",
    );
}

#[test]
fn linear_energy_keeps_its_digits() {
    let material = Linear {
        mu: 1.0,
        lambda: 1.5,
    };
    let G = Numbers(31).matrix::<3>();
    let at = |e: f64| material.energy(&(Mat::identity() + G.scale(e))) / (e * e);
    assert!((at(1e-8) / at(1e-2) - 1.0).abs() < 1e-7);
}

#[test]
fn stretch_models_lose_what_the_decomposition_loses() {
    let material = Outlined(ByStretches(FixedCorotated {
        mu: 1.0,
        lambda: 1.5,
    }));
    let G = Numbers(31).matrix::<3>();
    let at = |e: f64| material.energy(&(Mat::identity() + G.scale(e))) / (e * e);
    assert!((at(1e-8) / at(1e-5) - 1.0).abs() < 1e-3);
}

#[test]
fn the_energy_of_a_collapsing_element_diverges() {
    let material = Outlined(NeoHookean {
        mu: 1.0,
        lambda: 1.5,
    });
    let at = |s: f64| material.energy(&Mat::<f64, 3>::from_diagonal([1.0, 1.0, s]));
    assert!(at(1e-3) > at(1e-2) && at(1e-6) > at(1e-3) && at(1e-300) > 3e5);
    assert_eq!(at(0.0), f64::INFINITY);
    assert_eq!(at(-0.1), f64::INFINITY);
    assert_eq!(at(f64::NAN), f64::INFINITY);
}
