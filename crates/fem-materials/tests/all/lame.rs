//! Lamé conversions: round trips, the uniaxial test, and impossible values.

use fem_kinematics::Mat;
use fem_materials::{Lame, Linear, Material, Space};

const SPACES: [Space; 2] = [Space::Solid, Space::Plane];

#[test]
fn every_pair_of_constants_gives_the_same_material() {
    for space in SPACES {
        for nu in [-0.4, 0.1, 0.3, 0.49] {
            let E = 3e3;
            let exact = Lame::from_young_poisson(E, nu, space).unwrap();
            let (mu, lambda) = (exact.mu, exact.lambda);
            let (K, M) = (exact.bulk(space), exact.p_wave());
            assert!((exact.young(space) - E).abs() < 1e-10 * E);
            assert!((exact.poisson(space) - nu).abs() < 1e-13);
            for other in [
                Lame::new(mu, lambda, space),
                Lame::from_bulk_shear(K, mu, space),
                Lame::from_young_shear(E, mu, space),
                Lame::from_lambda_poisson(lambda, nu, space),
                Lame::from_bulk_poisson(K, nu, space),
                Lame::from_young_bulk(E, K, space),
                Lame::from_p_wave_shear(M, mu, space),
                Lame::from_p_wave_poisson(M, nu, space),
            ] {
                let other = other.unwrap();
                assert!(
                    (other.mu - mu).abs() < 1e-11 * mu,
                    "{space:?} {nu}: {other:?} {exact:?}"
                );
                assert!((other.lambda - lambda).abs() < 1e-11 * (mu + lambda.abs()));
            }
        }
    }
}

/// Stretch by e along x and by −ν e across: stress E e along, none across (document 002).
#[test]
fn uniaxial_stress_is_young_times_strain() {
    fn check<const D: usize>(space: Space) {
        let (E, nu, e) = (2e4, 0.3, 1e-3);
        let material = Linear::from(Lame::from_young_poisson(E, nu, space).unwrap());
        let mut F = Mat::<f64, D>::identity();
        F.0[0][0] += e;
        for i in 1..D {
            F.0[i][i] -= nu * e;
        }
        let P = material.stress(&F);
        assert!((P.0[0][0] / (E * e) - 1.0).abs() < 1e-12);
        assert!((P.0[1][1] / (E * e)).abs() < 1e-12);
    }
    check::<3>(Space::Solid);
    check::<2>(Space::Plane);
}

#[test]
fn no_lateral_strain_for_poisson_ratio_0() {
    let lame = Lame::from_young_poisson(7.0, 0.0, Space::Solid).unwrap();
    assert_eq!((lame.mu, lame.lambda), (3.5, 0.0));
}

#[test]
fn impossible_values_are_refused_with_their_names() {
    let refused = [
        Lame::from_young_poisson(1e5, 0.5, Space::Solid),
        Lame::from_young_poisson(1e5, 0.6, Space::Solid),
        Lame::from_young_poisson(1e5, -1.0, Space::Solid),
        Lame::from_young_poisson(-1e5, 0.3, Space::Solid),
        Lame::from_young_poisson(-1e5, -1.2, Space::Solid),
        Lame::from_young_poisson(f64::NAN, 0.3, Space::Solid),
        Lame::from_young_poisson(1e5, 1.0, Space::Plane),
        Lame::from_bulk_shear(-1.0, 1.0, Space::Solid),
        Lame::from_bulk_shear(1.0, f64::INFINITY, Space::Solid),
        Lame::from_young_shear(3.0, 1.0, Space::Solid),
        Lame::from_young_bulk(9.0, 1.0, Space::Solid),
        Lame::from_lambda_poisson(0.0, 0.0, Space::Solid),
        Lame::from_p_wave_shear(1.0, 1.0, Space::Solid),
    ];
    for result in refused {
        let message = result.expect_err("refused").to_string();
        assert!(message.contains("no stable material"), "{message}");
    }
    let message = Lame::from_young_poisson(1e5, 0.6, Space::Solid)
        .unwrap_err()
        .to_string();
    assert!(message.contains("nu = 0.6"), "{message}");
    assert!(Lame::from_young_poisson(1e5, 0.6, Space::Plane).is_ok());
}
