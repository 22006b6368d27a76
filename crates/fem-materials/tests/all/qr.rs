//! The general QR framework against the closed form of the anisotropic energy.

use crate::numbers::{Numbers, dual, error, norm, tensor_error};
use fem_kinematics::Mat;
use fem_materials::field::Local1;
use fem_materials::qr::GeneralQr;
use fem_materials::{Material, Outlined, QrAnisotropic, degradation};

const WHOLE: QrAnisotropic = QrAnisotropic {
    mu: 1.0,
    lambda: 1.5,
    kx: 10.0,
    ky: 4.0,
};

fn agree<const D: usize>()
where
    QrAnisotropic: fem_materials::qr::QrEnergy<D>,
{
    let (general, closed) = (Outlined(GeneralQr(WHOLE)), Outlined(WHOLE));
    let mut numbers = Numbers(8);
    for _ in 0..12 {
        // inverted ones too
        let F = numbers.matrix::<D>().scale(1.5);
        let dF = numbers.matrix::<D>();
        let R = fem_kinematics::signed_qr(&F).R;
        let smallest = (0..D - 1).fold(f64::INFINITY, |m, i| m.min(R.0[i][i]));
        let tolerance = 1e-13 / smallest.min(1.0).powi(2);
        let difference = general.energy(&F) - closed.energy(&F);
        assert!(difference.abs() < 1e-13 * (1.0 + closed.energy(&F)));
        assert!(error(&general.stress(&F), &closed.stress(&F)) < 1e-13);
        assert!(error(&GeneralQr(WHOLE).stress_by_division(&F), &closed.stress(&F)) < tolerance);
        let exact = closed.stress_differential(&F, &dF);
        let inverse = 1.0 / F.determinant().abs().min(1.0);
        let got = error(&general.stress_differential(&F, &dF), &exact);
        assert!(got < tolerance * inverse, "3.3: {got}");
        let got = tensor_error(
            &general.stress_derivative(&F),
            &closed.stress_derivative(&F),
        );
        assert!(got < tolerance * inverse, "3.4: {got}");
    }
}

#[test]
fn general_framework_is_the_closed_form() {
    agree::<2>();
    agree::<3>();
}

#[test]
fn division_free_evaluation_keeps_its_digits_and_the_division_does_not() {
    for short in [1e-4, 1e-8, 1e-12] {
        let F = Mat([[1.1, 0.3, 0.2], [0.0, short, 0.4], [0.0, 0.0, 0.9]]);
        let closed = Outlined(WHOLE).stress(&F);
        assert!(error(&Outlined(GeneralQr(WHOLE)).stress(&F), &closed) < 1e-14);
    }
    let F = Mat([[1.1, 0.3, 0.2], [0.0, 1e-12, 0.4], [0.0, 0.0, 0.9]]);
    let closed = Outlined(WHOLE).stress(&F);
    assert!(error(&GeneralQr(WHOLE).stress_by_division(&F), &closed) > 1e-9);
}

#[test]
fn bounded_for_every_deformation() {
    for F in [
        Mat::zeros(),
        Mat::unit(2, 2),
        Mat::from_diagonal([0.0, 1.0, -1.0]),
    ] {
        assert!(norm(&Outlined(WHOLE).stress(&F)) < 100.0);
        assert!(
            Outlined(WHOLE)
                .stress_derivative(&F)
                .apply(&F)
                .norm_squared()
                .is_finite()
        );
        assert!(norm(&Outlined(GeneralQr(WHOLE)).stress(&F)) < 100.0);
    }
}

#[test]
fn mu_and_lambda_minus_mu_are_lames_parameters() {
    let isotropic = Outlined(QrAnisotropic {
        kx: 0.0,
        ky: 0.0,
        ..WHOLE
    });
    let dP = isotropic.stress_differential(&Mat::<f64, 3>::identity(), &Mat::unit(0, 0));
    assert!((dP.0[1][1] - 0.5).abs() < 1e-15 && (dP.0[0][0] - 2.5).abs() < 1e-15);
}

#[test]
fn damage_splits_tension_compression_and_fibers() {
    assert_eq!(degradation(0.0_f64, 0.01), 1.0);
    assert_eq!(degradation(1.0_f64, 0.01), 0.01);
    let broken = WHOLE.degradable(0.0).at(Local1(1.0));
    let only_fibers = QrAnisotropic {
        mu: 0.0,
        lambda: 0.0,
        ..WHOLE
    };
    let stretched = Mat::<f64, 3>::from_diagonal([1.2, 1.1, 1.0]);
    assert!(error(&broken.stress(&stretched), &only_fibers.stress(&stretched)) < 1e-15);
    let pressed = Mat::<f64, 3>::from_diagonal([0.9, 0.8, 1.0]);
    let with_volume = QrAnisotropic { mu: 0.0, ..WHOLE };
    assert!(error(&broken.stress(&pressed), &with_volume.stress(&pressed)) < 1e-15);
    // ψ and P are continuous at J = 1, dP/dF jumps by (1 − g) λ cof F ⊗ cof F
    let half = WHOLE.degradable(0.0).at(Local1(1.0));
    let (above, below) = (1.0 + 1e-9, 1.0 - 1e-9);
    let at = |s| Mat::<f64, 3>::from_diagonal([s, 1.0, 1.0]);
    let jump = half.stress_derivative(&at(above)).apply(&Mat::identity())
        + half
            .stress_derivative(&at(below))
            .apply(&Mat::identity())
            .scale(-1.0);
    assert!((jump.0[1][1] + 1.5 * 3.0).abs() < 1e-6, "{jump:?}");
}

#[test]
fn default_lower_entries_are_those_of_the_energy() {
    use fem_materials::qr::QrEnergy;
    /// The same energy with the default division.
    #[derive(Clone, Copy)]
    struct Divided;
    impl QrEnergy<3> for Divided {
        fn energy<T: fem_kinematics::Real>(&self, R: &Mat<T, 3>) -> T {
            QrEnergy::energy(&WHOLE, R)
        }
        fn gradient<T: fem_kinematics::Real>(&self, R: &Mat<T, 3>) -> Mat<T, 3> {
            QrEnergy::gradient(&WHOLE, R)
        }
        fn gradient_differential<T: fem_kinematics::Real>(
            &self,
            R: &Mat<T, 3>,
            dR: &Mat<T, 3>,
        ) -> Mat<T, 3> {
            QrEnergy::gradient_differential(&WHOLE, R, dR)
        }
    }
    let R = Mat([[1.3_f64, 0.4, -0.2], [0.0, 0.8, 0.5], [0.0, 0.0, -0.7]]);
    let gradient = QrEnergy::gradient(&WHOLE, &R);
    let exact = QrEnergy::lower_entries(&WHOLE, &R, &gradient);
    let divided = Divided.lower_entries(&R, &gradient);
    for i in 0..3 {
        assert!(
            (exact[i] - divided[i]).abs() < 1e-14,
            "{exact:?} {divided:?}"
        );
    }
    let dR = Mat([[0.3, 0.1, -0.5], [0.0, 0.2, 0.9], [0.0, 0.0, 0.4]]);
    let by_dual = QrEnergy::gradient(&WHOLE, &dual(&R, &dR));
    let by_dual = Mat::from_fn(|i, j| by_dual.0[i][j].derivative);
    assert!(error(&QrEnergy::gradient_differential(&WHOLE, &R, &dR), &by_dual) < 1e-14);
}
