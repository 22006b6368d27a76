//! What parameters mean, against closed forms with values that no default has: a factor left out, or
//! one that is 1 by default, changes no derivative.

use crate::numbers::{Numbers, error, norm};
use fem_kinematics::{Mat, signed_svd};
use fem_materials::curves::PhysBam;
use fem_materials::field::Local1;
use fem_materials::inversion::Thresholded;
use fem_materials::qr::GeneralQr;
use fem_materials::{
    FiberLaw, FiberTerm, Flesh, Lame, Material, Outlined, QrAnisotropic, StableNeoHookean,
    StableNeoHookeanNoLog, Stretch, degradation,
};

/// A fiber along x with its peak at the stretch 1.25, in F = diag(1.5, 1, 1).
#[test]
fn a_fiber_pulls_by_its_stretch_over_the_optimal_one() {
    let term = FiberTerm {
        direction: [1.0, 0.0, 0.0],
        max_isometric_stress: 2e5,
        activation: 0.7,
        optimal_stretch: 1.25,
    };
    let F = Mat::from_diagonal([1.5, 1.0, 1.0]);
    let isochoric = 1.5_f64.powf(2.0 / 3.0);
    for (stretch, lambda) in [(Stretch::Total, 1.5_f64), (Stretch::Isochoric, isochoric)] {
        let law = FiberLaw {
            curve: PhysBam::default(),
            stretch,
        };
        let e = lambda / 1.25 - 1.0;
        assert!(e > 0.0 && e < 0.4);
        // 1 − 25/6 e², and P₁ (exp(P₂ e) − P₂ e − 1); their integrals from l = 1.
        let active = 1.0 - 25.0 / 6.0 * e * e;
        let passive = 0.05 * ((6.6 * e).exp() - 6.6 * e - 1.0);
        let work = e - 25.0 / 18.0 * e.powi(3);
        let stored = 0.05 / 6.6 * ((6.6 * e).exp() - 1.0 - 6.6 * e - (6.6 * e).powi(2) / 2.0);
        let energy = 2e5 * (0.7 * work + stored);
        assert!((term.energy(&law, &F) / energy - 1.0).abs() < 1e-12);
        // ψ' by the stretch λ, times ∂λ/∂F along the fiber: λ/1.5, less a third of it by J.
        let along = match stretch {
            Stretch::Total => 1.0,
            Stretch::Isochoric => 2.0 / 3.0 * lambda / 1.5,
        };
        let pull = 2e5 / 1.25 * (0.7 * active + passive) * along;
        let P = term.stress(&law, &F);
        assert!((P.0[0][0] / pull - 1.0).abs() < 1e-12, "{stretch:?}");
        assert!((term.normalized_stretch(&law, &F) - lambda / 1.25).abs() < 1e-14);
    }
}

/// dP = λ tr(ε) I + 2 µ ε at rest, and no stress there.
#[test]
fn stable_neo_hookean_flesh_has_lames_constants_at_rest() {
    fn check<M: Material<3>>(material: M, lame: Lame) {
        let material = Outlined(material);
        let rest = Mat::<f64, 3>::identity();
        assert!(norm(&material.stress(&rest)) < 1e-12 * lame.mu);
        let mut numbers = Numbers(21);
        for _ in 0..4 {
            let dF = numbers.matrix::<3>();
            let strain = dF.symmetric_part();
            let hooke = strain.scale(2.0 * lame.mu) + rest.scale(lame.lambda * strain.trace());
            assert!(error(&material.stress_differential(&rest, &dF), &hooke) < 1e-12);
        }
    }
    for (mu, lambda) in [(3e4, 7e4), (5e3, 1e6), (2e4, -1e3)] {
        let lame = Lame { mu, lambda };
        check(StableNeoHookean::from_lame(lame), lame);
        check(StableNeoHookeanNoLog::from_lame(lame), lame);
    }
}

#[test]
fn the_threshold_lifts_singular_values_to_itself_and_no_further() {
    let mut numbers = Numbers(17);
    let (U, V) = (numbers.rotation::<3>(), numbers.rotation::<3>());
    let thresholded = Thresholded::new(Flesh::new(6e4, 2e4, 6e4), 0.25).unwrap();
    for (sigma, lifted) in [
        ([1.2, 0.9, 0.1], [1.2, 0.9, 0.25]),
        ([1.2, 0.7, -0.2], [1.2, 0.7, 0.25]),
        ([0.2, 0.1, 0.05], [0.25; 3]),
        ([1.2, 0.4, 0.3], [1.2, 0.4, 0.3]),
    ] {
        let found = thresholded.lifted(&(U * Mat::from_diagonal(sigma)).mul_tr(&V));
        let found = signed_svd(&found).sigma;
        let turned = (U * Mat::from_diagonal(lifted)).mul_tr(&V);
        let expected = signed_svd(&turned).sigma;
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-14, "{sigma:?}: {found:?}");
        }
    }
}

const WHOLE: QrAnisotropic = QrAnisotropic {
    mu: 2.0,
    lambda: 3.0,
    kx: 10.0,
    ky: 0.0,
};

/// With F upper triangular P₂₁ is µ F₂₁ + (λ (J − 1) − µ) cof₂₁, nothing of it of the fiber.
#[test]
fn the_plane_stress_without_division_keeps_its_digits_where_the_fiber_collapses() {
    for short in [1e-4_f64, 1e-9, 1e-13, 0.0] {
        let F = Mat([[short, 0.3], [0.0, 0.9]]);
        let volume = 3.0 * (0.9 * short - 1.0) - 2.0;
        let P = Outlined(GeneralQr(WHOLE)).stress(&F);
        // Along the fiber 1 − 1/r₁₁ times r₁₁; the sign of a fiber of no length is not determined.
        let expected = [
            [2.0 * short + 0.9 * volume + 10.0 * (short - 1.0), 0.6],
            [-0.3 * volume, 1.8 + short * volume],
        ];
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let off = (P.0[i][j] - expected[i][j]).abs();
            assert!(off < 1e-13, "r11 = {short:e}, entry {i}{j}: off by {off:e}");
        }
    }
}

#[test]
fn a_half_broken_element_keeps_a_quarter_of_what_can_break() {
    // (1 − r)(1 − d)² + r
    for (d, r, g) in [
        (0.5_f64, 0.0_f64, 0.25),
        (0.5, 0.2, 0.4),
        (0.3, 0.0, 0.49),
        (0.9, 0.01, 0.0199),
    ] {
        assert!((degradation(d, r) - g).abs() < 1e-15, "{d} {r}");
    }
    let half = Outlined(WHOLE.degradable(0.2).at(Local1(0.5)));
    // Sheared at constant volume: µ alone is felt, and it is degraded.
    let F = Mat([[1.0_f64, 0.4], [0.0, 1.0]]);
    let P = half.stress(&F);
    assert!((P.0[0][1] - 0.4 * 2.0 * 0.4).abs() < 1e-14, "{P:?}");
}
