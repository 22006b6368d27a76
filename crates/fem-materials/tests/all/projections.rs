//! Closed-form definite parts against the eigenvalues of the whole tensor.

use crate::numbers::{Numbers, tensor_error, tensor_norm};
use fem_kinematics::{Mat, Tensor4};
use fem_materials::curves::{Blemker, PhysBam};
use fem_materials::isotropic::ByStretches;
use fem_materials::*;

const PROJECTIONS: [HessianProjection; 2] = [HessianProjection::Clamp, HessianProjection::Absolute];

/// Is the closed form the numeric one? Returns how many samples were indefinite.
fn compare<const D: usize, M: Material<D>>(model: M, size: f64) -> usize {
    let model = Outlined(model);
    let mut numbers = Numbers(91);
    let mut indefinite = 0;
    for _ in 0..12 {
        let F = Mat::identity() + numbers.matrix::<D>().scale(size);
        if !model.energy(&F).is_finite() {
            continue;
        }
        let derivative = model.stress_derivative(&F);
        indefinite += usize::from(derivative.eigenvalues()[0] < 0.0);
        for projection in PROJECTIONS {
            let closed = model.projected_derivative(&F, projection);
            let numeric = projection.apply(&derivative);
            let error = tensor_norm(&(closed + numeric.scale(-1.0)));
            assert!(
                error < 1e-11 * tensor_norm(&derivative),
                "{projection:?} {error:e} at {F:?}"
            );
        }
    }
    indefinite
}

#[test]
fn isotropic_blocks_project_as_the_whole_tensor_does() {
    let (mu, lambda) = (1.0, 4.0);
    assert!(compare::<3, _>(NeoHookean { mu, lambda }, 0.6) > 0);
    assert!(compare::<2, _>(NeoHookean { mu, lambda }, 0.6) > 0);
    assert!(compare::<3, _>(Flesh::new(6e4, 2e4, 6e4), 0.6) > 0);
    assert!(compare::<3, _>(StVenantKirchhoff { mu, lambda }, 0.6) > 0);
    assert!(compare::<3, _>(StableNeoHookean { mu, lambda }, 1.5) > 0);
    assert!(compare::<3, _>(ByStretches(CorotatedLinear { mu, lambda }), 0.5) > 0);
}

#[test]
fn the_plain_fiber_has_the_eigenvalues_of_the_errata() {
    let fiber = |activation| Fiber {
        field: FiberLaw {
            curve: PhysBam::default(),
            stretch: Stretch::Total,
        },
        local: FiberTerm {
            direction: [0.6, 0.0, 0.8],
            max_isometric_stress: 3e5,
            activation,
            optimal_stretch: 1.0,
        },
    };
    assert!(compare::<3, _>(fiber(1.0), 0.4) > 0);
    let F = Mat([[1.15, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]]);
    let values = fiber(0.8).stress_derivative(&F).eigenvalues();
    let zeros = values.iter().filter(|x| x.abs() < 1e-9 * 3e5).count();
    assert_eq!(zeros, 6);
}

#[test]
fn qr_fibers_have_the_eigenvalues_k_and_k_times_one_minus_inverse_s() {
    // without the isotropic part, whose sum with the fibers has other eigenvalues
    let fibers = QrAnisotropic {
        mu: 0.0,
        lambda: 0.0,
        kx: 10.0,
        ky: 4.0,
    };
    assert!(compare::<3, _>(fibers, 0.5) > 0);
    assert!(compare::<2, _>(QrAnisotropic { ky: 0.0, ..fibers }, 0.5) > 0);
}

#[test]
fn mixed_models_are_definite_after_projection() {
    let mut numbers = Numbers(17);
    let muscle = Sum(
        Flesh::new(6e4, 2e4, 6e4),
        Fiber {
            field: FiberLaw {
                curve: Blemker::default(),
                stretch: Stretch::Isochoric,
            },
            local: FiberTerm {
                direction: [0.0, 0.6, 0.8],
                max_isometric_stress: 3e5,
                activation: 0.9,
                optimal_stretch: 1.1,
            },
        },
    );
    let woven = QrAnisotropic {
        mu: 1.0,
        lambda: 5.0,
        kx: 10.0,
        ky: 4.0,
    };
    let definite = |t: Tensor4<f64, 3>| t.eigenvalues()[0] >= -1e-11 * tensor_norm(&t);
    for _ in 0..8 {
        let F = Mat::identity() + numbers.matrix::<3>().scale(0.5);
        assert!(definite(
            Outlined(woven).projected_derivative(&F, HessianProjection::Clamp)
        ));
        if F.determinant() > 0.0 {
            let derivative = Outlined(muscle).projected_derivative(&F, HessianProjection::Clamp);
            assert!(definite(derivative));
        }
    }
}

#[test]
fn no_projection_is_the_derivative_itself() {
    let model = Outlined(Flesh::new(6e4, 2e4, 6e4));
    let F = Mat([[1.15, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]]);
    let same = model.projected_derivative(&F, HessianProjection::None);
    assert_eq!(tensor_error(&same, &model.stress_derivative(&F)), 0.0);
}
