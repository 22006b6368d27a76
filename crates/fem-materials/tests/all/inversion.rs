//! Elements that are flat or turned inside out.

use crate::numbers::{Numbers, dual, error, norm, tensor_error};
use fem_kinematics::Mat;
use fem_materials::inversion::{Continuation, Smoothness, Thresholded, continued};
use fem_materials::{Flesh, Material, NeoHookean, Outlined};

const HOW: Continuation = Continuation {
    threshold: 0.4,
    stiffness: 8e4,
    smoothness: Smoothness::C2,
};

fn smooth() -> [impl Material<3>; 2] {
    let flesh = Flesh::new(6e4, 2e4, 6e4);
    [Smoothness::C1, Smoothness::C2]
        .map(|smoothness| Outlined(continued::<_, 3>(flesh, Continuation { smoothness, ..HOW })))
}

fn turned(sigma: [f64; 3]) -> Mat<f64, 3> {
    let mut numbers = Numbers(4);
    let (U, V) = (numbers.rotation::<3>(), numbers.rotation::<3>());
    (U * Mat::from_diagonal(sigma)).mul_tr(&V)
}

#[test]
fn continued_energy_has_its_exact_derivatives_everywhere() {
    let dF = Numbers(9).matrix::<3>();
    for material in smooth() {
        for sigma in [
            [1.3, 0.9, 0.6],
            [1.3, 0.9, 0.2],
            [1.3, 0.35, 0.1],
            [1.1, 0.3, -0.2],
            [0.3, 0.2, -0.1],
        ] {
            let F = turned(sigma);
            let P = material.stress(&F);
            let slope = material.energy(&dual(&F, &dF)).derivative;
            assert!(
                (P.dot(&dF) - slope).abs() < 1e-11 * (norm(&P) + 1e5),
                "{sigma:?}"
            );
            let by_dual = material.stress(&dual(&F, &dF));
            let by_dual = Mat::from_fn(|i, j| by_dual.0[i][j].derivative);
            let got = error(&material.stress_differential(&F, &dF), &by_dual);
            assert!(got < 1e-11, "{sigma:?}: {got}");
        }
    }
}

#[test]
fn above_the_threshold_it_is_the_material_itself() {
    let F = turned([1.3, 0.9, 0.41]);
    let flesh = Outlined(Flesh::new(6e4, 2e4, 6e4));
    for material in smooth() {
        assert!((material.energy(&F) / flesh.energy(&F) - 1.0).abs() < 1e-14);
        assert!(error(&material.stress(&F), &flesh.stress(&F)) < 1e-13);
        let got = tensor_error(
            &material.stress_derivative(&F),
            &flesh.stress_derivative(&F),
        );
        assert!(got < 1e-12, "{got}");
    }
}

#[test]
fn smooth_at_the_threshold_as_often_as_promised() {
    let at = |s| turned([1.2, 0.8, s]);
    let (above, below) = (at(0.4 + 1e-10), at(0.4 - 1e-10));
    let [c1, c2] = smooth();
    for material in smooth() {
        assert!(error(&material.stress(&above), &material.stress(&below)) < 1e-8);
    }
    let jump = |m: &dyn Fn(&Mat<f64, 3>) -> fem_kinematics::Tensor4<f64, 3>| {
        tensor_error(&m(&above), &m(&below))
    };
    assert!(jump(&|F| c2.stress_derivative(F)) < 1e-7);
    assert!(jump(&|F| c1.stress_derivative(F)) > 1e-3);
}

#[test]
fn repeated_values_below_the_threshold_are_no_special_case() {
    for material in smooth() {
        let repeated = material.stress_derivative(&turned([0.2; 3]));
        let near = material.stress_derivative(&turned([0.2 + 1e-9, 0.2, 0.2 - 1e-9]));
        assert!(tensor_error(&near, &repeated) < 1e-7);
        // one on each side, a hair apart
        let straddle = material.stress_derivative(&turned([0.9, 0.4 + 1e-9, 0.4 - 1e-9]));
        assert!(norm(&straddle.apply(&Mat::identity())).is_finite());
    }
}

#[test]
fn an_inverted_element_is_pushed_back() {
    for material in smooth() {
        let [deep, flat, open] = [-0.5, 0.0, 0.6].map(|s| material.energy(&turned([1.0, 1.0, s])));
        assert!(deep > flat && flat > open && deep.is_finite());
    }
    let two_d = Outlined(continued::<_, 2>(
        NeoHookean {
            mu: 1.0,
            lambda: 2.0,
        },
        HOW,
    ));
    assert!(
        two_d
            .energy(&Mat::from_diagonal([1.0_f64, -0.3]))
            .is_finite()
    );
}

#[test]
fn the_documents_threshold_keeps_the_stress_but_not_the_energy() {
    let flesh = Flesh::new(6e4, 2e4, 6e4);
    let material = Outlined(Thresholded {
        inner: flesh,
        threshold: 0.25,
    });
    let inside = turned([1.2, 0.9, 0.3]);
    assert_eq!(material.stress(&inside), Outlined(flesh).stress(&inside));
    let [a, b] = [0.1, -0.7].map(|s| turned([1.2, 0.9, s]));
    assert!(error(&material.stress(&a), &material.stress(&b)) < 1e-12);
    assert!((material.energy(&a) - material.energy(&b)).abs() < 1e-9 * material.energy(&a));
    // not the gradient of the energy: the energy does not change, the stress is not 0
    let along = (b - a).scale(1.0 / norm(&(b - a)));
    assert!(material.stress(&a).dot(&along).abs() > 1e3);
}
