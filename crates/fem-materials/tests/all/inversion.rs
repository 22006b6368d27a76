//! Elements that are flat or turned inside out.

use crate::numbers::{Numbers, dual, error, norm, tensor_error};
use fem_kinematics::Mat;
use fem_materials::inversion::{Continuation, Smoothness, Thresholded, VolumeBarrier, continued};
use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
use fem_materials::{Flesh, Material, NeoHookean, Outlined};

const HOW: Continuation = Continuation {
    threshold: 0.4,
    stiffness: 8e4,
    smoothness: Smoothness::C2,
};

fn smooth() -> [impl Material<3>; 2] {
    let flesh = Flesh::new(6e4, 2e4, 6e4);
    [Smoothness::C1, Smoothness::C2]
        .map(|smoothness| continued::<_, 3>(flesh, Continuation { smoothness, ..HOW }))
        .map(|material| Outlined(material.unwrap()))
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
    let soft = NeoHookean {
        mu: 1.0,
        lambda: 2.0,
    };
    let two_d = Outlined(continued::<_, 2>(soft, HOW).unwrap());
    assert!(
        two_d
            .energy(&Mat::from_diagonal([1.0_f64, -0.3]))
            .is_finite()
    );
}

#[test]
fn the_documents_threshold_keeps_the_stress_but_not_the_energy() {
    let flesh = Flesh::new(6e4, 2e4, 6e4);
    let material = Outlined(Thresholded::new(flesh, 0.25).unwrap());
    let inside = turned([1.2, 0.9, 0.3]);
    assert_eq!(material.stress(&inside), Outlined(flesh).stress(&inside));
    let [a, b] = [0.1, -0.7].map(|s| turned([1.2, 0.9, s]));
    assert!(error(&material.stress(&a), &material.stress(&b)) < 1e-12);
    assert!((material.energy(&a) - material.energy(&b)).abs() < 1e-9 * material.energy(&a));
    // not the gradient of the energy: the energy does not change, the stress is not 0
    let along = (b - a).scale(1.0 / norm(&(b - a)));
    assert!(material.stress(&a).dot(&along).abs() > 1e3);
}

#[test]
fn a_threshold_or_a_stiffness_that_divides_by_nothing_is_refused() {
    let flesh = Flesh::new(6e4, 2e4, 6e4);
    for threshold in [0.0, -0.3, f64::NAN, f64::INFINITY] {
        assert!(Thresholded::new(flesh, threshold).is_err(), "{threshold}");
        let how = Continuation { threshold, ..HOW };
        assert!(continued::<_, 3>(flesh, how).is_err(), "{threshold}");
    }
    for stiffness in [-1.0, f64::NAN, f64::INFINITY] {
        let how = Continuation { stiffness, ..HOW };
        assert!(continued::<_, 3>(flesh, how).is_err(), "{stiffness}");
    }
}

/// Builds one model with its defaults but one parameter.
struct With(&'static str, &'static str, &'static str, Vec<bool>);

impl ModelVisitor for With {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        let Self(model, parameter, value, built) = self;
        if entry.is(model) {
            let own = entry.parameters.iter().map(|p| (p.name, p.default));
            let with =
                own.map(|(name, text)| (name, if name == *parameter { *value } else { text }));
            built.push(entry.build(&with.collect()).is_ok());
        }
    }
}

#[test]
fn directions_that_are_no_unit_vectors_and_negative_stiffnesses_are_refused() {
    for (model, parameter, value, right) in [
        ("fiber_tilde", "a0", "0.6 0 0.8", true),
        ("fiber_tilde", "a0", "0.6 0 0.9", false),
        ("muscle_dev", "a0", "0 0 0", false),
        ("hgo", "a1", "0.8004 0.6 0", true),
        ("hgo", "a1", "2 0 0", false),
        ("hgo", "a2", "0 0.99 0", false),
        ("qr_aniso", "ky", "0", true),
        ("qr_aniso", "ky", "-1", false),
        ("qr_damage", "ky", "-1", false),
    ] {
        let mut visitor = With(model, parameter, value, Vec::new());
        for_each_model(&mut visitor);
        let built = visitor.3;
        assert!(
            !built.is_empty() && built.iter().all(|&b| b == right),
            "{model} {parameter} {value}"
        );
    }
}

#[test]
fn the_late_barrier_has_its_exact_derivatives_and_is_nothing_before_its_threshold() {
    let barrier = VolumeBarrier::new(0.3, 5e4).unwrap();
    let dF = Numbers(11).matrix::<3>();
    // Before the parabola (u = 0.72, 0.15, 0.01), flat on it, and inside out.
    for sigma in [
        [1.2, 0.9, 0.2],
        [1.1, 0.4, 0.1],
        [0.3, 0.2, 0.05],
        [1.0, 0.0, 0.5],
        [1.0, 0.8, -0.3],
    ] {
        let F = turned(sigma);
        let P = barrier.stress(&F);
        let slope = barrier.energy(&dual(&F, &dF)).derivative;
        assert!(barrier.energy(&F) > 0.0 && norm(&P) > 0.0);
        assert!((P.dot(&dF) - slope).abs() < 1e-12 * norm(&P), "{sigma:?}");
        let by_dual = barrier.stress(&dual(&F, &dF));
        let by_dual = Mat::from_fn(|i, j| by_dual.0[i][j].derivative);
        assert!(error(&barrier.stress_differential(&F, &dF), &by_dual) < 1e-11);
        let derivative = Material::<3>::stress_derivative(&barrier, &F);
        assert!(error(&derivative.apply(&dF), &by_dual) < 1e-11, "{sigma:?}");
    }
    let before = turned([1.0, 0.6, 0.50001]);
    assert_eq!(barrier.energy(&before), 0.0);
    assert_eq!(norm(&barrier.stress(&before)), 0.0);
    // What it takes to press an element flat: φ'(u) − u φ''(u) where the parabola begins.
    let u = 0.002_f64;
    let q = (1.0 - u) / u;
    let slope = (1.0 - u) * (2.0 * u.ln() - q);
    let curvature = -2.0 * u.ln() + 4.0 * q + q * q;
    let flat = barrier.stress(&Mat::from_diagonal([1.0, 1.0, 0.0])).0[2][2];
    let expected = 5e4 / 0.3 * (slope - u * curvature);
    assert!((flat / expected - 1.0).abs() < 1e-12 && expected < -1e3 * 5e4 / 0.3);
    // Beyond, energy and push go on rising; where the parabola begins nothing jumps.
    let along = |j: f64| Mat::from_diagonal([1.0, 1.0, j]);
    let energy = |j: f64| barrier.energy(&along(j));
    assert!(
        energy(-0.5) > energy(-0.1) && energy(-0.1) > energy(0.0) && energy(0.0) > energy(0.02)
    );
    let begin = 0.3 * u;
    let jump = |f: &dyn Fn(f64) -> f64| (f(begin + 1e-9) / f(begin - 1e-9) - 1.0).abs();
    let pressure = |j: f64| barrier.stress(&along(j)).0[2][2];
    let stiffness = |j: f64| barrier.stress_differential(&along(j), &along(1.0)).0[2][2];
    assert!(jump(&energy) < 2e-5 && jump(&pressure) < 2e-5 && jump(&stiffness) < 2e-5);
    for (threshold, modulus) in [(1.0, 1e4), (0.0, 1e4), (f64::NAN, 1e4), (0.2, 0.0)] {
        assert!(VolumeBarrier::new(threshold, modulus).is_err());
    }
}
