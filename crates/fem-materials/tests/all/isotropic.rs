//! The frame of the singular vectors against the direct formulas.

use crate::numbers::{Numbers, error, norm, tensor_error, tensor_norm};
use fem_kinematics::{Mat, Tensor4, signed_svd};
use fem_materials::curves::BuiltinCurve;
use fem_materials::isotropic::{
    ByInvariants, ByStretches, DiagonalBlocks, Eta, combined_stress, mooney_rivlin_alpha_beta_gamma,
};
use fem_materials::*;

const A: f64 = 6e4;
const B: f64 = 2e4;
const K: f64 = 6e4;
/// The test point of the errata.
const SIGMA: [f64; 3] = [1.7, 0.9, 0.55];

#[test]
fn corrected_alpha_beta_eta_of_document_000_are_the_derivative() {
    let blocks = mooney_rivlin_alpha_beta_gamma([A, B, K], SIGMA).blocks();
    let exact = Outlined(Flesh::new(A, B, K)).stress_derivative(&Mat::from_diagonal(SIGMA));
    assert!(tensor_error(&blocks.to_tensor(), &exact) < 1e-14);
    // entries outside the blocks are exactly 0
    assert_eq!(exact.get(0, 0, 0, 1), 0.0);
    assert_eq!(exact.get(0, 1, 0, 2), 0.0);
    // eta is symmetric, and 8B/9 instead of 8B/3 (document 000, eq. 34) would not be
    let eta = Eta::new([A, B, K], SIGMA).0;
    assert_eq!(eta, eta.transpose());
}

#[test]
fn combined_stress_of_eq_15_is_the_sum_of_its_parts() {
    let mut numbers = Numbers(5);
    let F = Mat::identity() + numbers.matrix::<3>().scale(0.3);
    let svd = signed_svd(&F);
    let a0 = [0.6, 0.0, 0.8];
    let term = FiberTerm {
        direction: a0,
        max_isometric_stress: 3e5,
        activation: 0.7,
        optimal_stretch: 1.0,
    };
    let law = FiberLaw {
        curve: BuiltinCurve::default(),
        stretch: Stretch::Isochoric,
    };
    let direct = Outlined(Flesh::new(A, B, K)).stress(&F) + term.stress(&law, &F);
    // T of document 000, 4.3.3 is F2'(λ)/λ; the fiber is turned by Vᵀ.
    let lambda = term.normalized_stretch(&law, &F);
    let point = |c: fem_materials::curves::CurvePoint<f64>| c.value;
    use fem_materials::curves::TensionCurve;
    let pull = 3e5 * (0.7 * point(law.curve.active(lambda)) + point(law.curve.passive(lambda)));
    let P_hat = combined_stress([A, B, K], svd.sigma, svd.V.tr_mul_vec(a0), pull / lambda);
    assert!(error(&svd.to_world(&P_hat), &direct) < 1e-14);
    // taking F2' itself for T is wrong by a factor λ
    let wrong = combined_stress([A, B, K], svd.sigma, svd.V.tr_mul_vec(a0), pull);
    assert!(error(&svd.to_world(&wrong), &direct) > 1e-3);
}

#[test]
fn plain_fiber_stress_by_the_rotated_direction_is_the_direct_one() {
    let mut numbers = Numbers(6);
    let F = Mat::identity() + numbers.matrix::<3>().scale(0.4);
    let svd = signed_svd(&F);
    let term = FiberTerm {
        direction: [0.6, 0.0, 0.8],
        max_isometric_stress: 3e5,
        activation: 1.0,
        optimal_stretch: 1.0,
    };
    let turned = FiberTerm {
        direction: svd.V.tr_mul_vec(term.direction),
        ..term
    };
    let law = FiberLaw {
        curve: BuiltinCurve::default(),
        stretch: Stretch::Total,
    };
    let P_hat = turned.stress(&law, &Mat::from_diagonal(svd.sigma));
    assert!(error(&svd.to_world(&P_hat), &term.stress(&law, &F)) < 1e-13);
}

/// Models that come twice: by invariants and directly.
#[test]
fn invariants_give_the_same_numbers_as_the_direct_forms() {
    let (mu, lambda) = (1.3e4, 2.7e4);
    let mut numbers = Numbers(11);
    for _ in 0..10 {
        let F = Mat::identity() + numbers.matrix::<3>().scale(0.3);
        if F.determinant() <= 0.0 {
            continue;
        }
        let same = |a: &Tensor4<f64, 3>, b| assert!(tensor_error(a, &b) < 1e-13);
        same(
            &Outlined(ByInvariants(InvNeoHookean { mu, lambda })).stress_derivative(&F),
            Outlined(NeoHookean { mu, lambda }).stress_derivative(&F),
        );
        same(
            &Outlined(ByInvariants(InvStVenantKirchhoff { mu, lambda })).stress_derivative(&F),
            Outlined(StVenantKirchhoff { mu, lambda }).stress_derivative(&F),
        );
        // document 004's II = tr C², I₂ = (I² − II)/2 in document 000
        let by_invariants = ByInvariants(InvMooneyRivlin {
            mu01: B,
            mu10: A,
            v1: 0.0,
        });
        let direct = MooneyRivlin { A, B };
        same(
            &Outlined(by_invariants).stress_derivative(&F),
            Outlined(direct).stress_derivative(&F),
        );
        let difference = direct.energy(&F) - by_invariants.energy(&F);
        assert!((difference - 3.0 * (A + B)).abs() < 1e-9);
    }
}

#[test]
fn alpha_beta_gamma_of_document_004_are_the_derivative() {
    let model = ByInvariants(InvMooneyRivlin {
        mu01: B,
        mu10: A,
        v1: 0.5 * K,
    });
    let F_hat = Mat::from_diagonal(SIGMA);
    let blocks = model.alpha_beta_gamma(SIGMA).blocks();
    let exact = Outlined(model).stress_derivative(&F_hat);
    assert!(tensor_error(&blocks.to_tensor(), &exact) < 1e-14);
    let P = Outlined(model).stress(&F_hat);
    let diagonal = Mat::from_diagonal(model.diagonal_stress(SIGMA));
    assert!(error(&diagonal, &P) < 1e-14);
}

#[test]
fn alpha_beta_gamma_survive_a_flat_element() {
    let model = ByInvariants(InvStVenantKirchhoff {
        mu: 1.0,
        lambda: 1.5,
    });
    let flat = [1.2, 0.8, 0.0];
    let exact = Outlined(model).stress_derivative(&Mat::from_diagonal(flat));
    let blocks = model.alpha_beta_gamma(flat).blocks();
    assert!(tensor_error(&blocks.to_tensor(), &exact) < 1e-15);
}

#[test]
fn rotated_blocks_are_the_derivative_in_2d_and_3d() {
    fn check<const D: usize>() {
        let model = Outlined(NeoHookean {
            mu: 1.0,
            lambda: 2.0,
        });
        let F = Mat::<f64, D>::identity() + Numbers(3).matrix().scale(0.4);
        let svd = signed_svd(&F);
        let at_rest = model.stress_derivative(&Mat::from_diagonal(svd.sigma));
        let blocks = DiagonalBlocks::from_tensor(&at_rest);
        assert!(tensor_error(&blocks.rotated(&svd), &model.stress_derivative(&F)) < 1e-13);
    }
    check::<2>();
    check::<3>();
}

#[test]
fn repeated_and_nearly_repeated_stretches_are_no_special_case() {
    let ogden = Ogden {
        terms: [(4e5, 1.3), (1e3, 5.0), (-1e4, -2.0)],
        K: 2e6,
    };
    let mut numbers = Numbers(21);
    let (U, V) = (numbers.rotation::<3>(), numbers.rotation::<3>());
    let at = |sigma| (U * Mat::from_diagonal(sigma)).mul_tr(&V);
    let repeated = Outlined(ByStretches(ogden)).stress_derivative(&at([1.2; 3]));
    for gap in [1e-4, 1e-7, 1e-8, 1e-9, 1e-12] {
        let near = at([1.2 + gap, 1.2, 1.2 - gap]);
        let derivative = Outlined(ByStretches(ogden)).stress_derivative(&near);
        let error = tensor_error(&derivative, &repeated);
        assert!(error < 20.0 * gap + 1e-13, "gap {gap}: {error}");
    }
    // one exponent 2 and a volume term: deviatoric neo-Hookean, which needs no stretches
    let one = Outlined(ByStretches(Ogden {
        terms: [(1e5, 2.0)],
        K: 3e5,
    }));
    let flesh = Outlined(Flesh::new(5e4, 0.0, 3e5));
    for sigma in [
        [1.2; 3],
        [1.5, 0.8, 0.8],
        [1.5, 1.5 - 1e-10, 0.4],
        [2.0, 1.1, 0.3],
    ] {
        let F = at(sigma);
        assert!(
            norm(&(one.stress(&F) - flesh.stress(&F))) < 1e-9 * 1e5,
            "{sigma:?}"
        );
        let error = tensor_error(&one.stress_derivative(&F), &flesh.stress_derivative(&F));
        assert!(error < 1e-12, "{sigma:?}: {error}");
    }
}

#[test]
fn corotated_models_are_finite_where_the_rotation_is_not_determined() {
    let F = Mat::<f64, 3>::from_diagonal([1.0, 0.5, -0.5]);
    let derivative = Outlined(ByStretches(FixedCorotated {
        mu: 1.0,
        lambda: 1.0,
    }))
    .stress_derivative(&F);
    assert!(tensor_norm(&derivative).is_finite());
}
