//! Exact properties of the decompositions over every kind of matrix.
#![allow(non_snake_case)]

mod common;
use common::*;
use fem_kinematics::*;

fn check_rotation<const D: usize>(Q: &Mat<f64, D>, what: &str, F: &Mat<f64, D>) {
    let error = largest(&(Q.tr_mul(Q) - Mat::identity()));
    assert!(error <= 1e-15, "{what}: QᵀQ − I = {error:e} for {F:?}");
    assert!(
        (Q.determinant() - 1.0).abs() <= 1e-15,
        "{what}: det = {}",
        Q.determinant()
    );
}

fn check_svd<const D: usize>(F: &Mat<f64, D>) {
    let svd = signed_svd(F);
    check_rotation(&svd.U, "U", F);
    check_rotation(&svd.V, "V", F);
    let size = largest(F);
    let error = largest(&(svd.compose(svd.sigma) - *F));
    assert!(error <= 3e-15 * size, "error {:e} for {F:?}", error / size);
    for i in 1..D {
        assert!(svd.sigma[i - 1] >= svd.sigma[i].abs(), "{:?}", svd.sigma);
    }
    if F.determinant() / size.powi(D as i32) < -1e-14 {
        assert!(svd.sigma[D - 1] < 0.0);
    }
}

#[test]
fn svd_of_every_kind() {
    for F in matrices::<2>() {
        check_svd(&F);
    }
    for F in matrices::<3>() {
        check_svd(&F);
    }
}

#[test]
fn svd_agrees_with_an_independent_one() {
    for F in matrices::<3>() {
        let size = largest(&F);
        if !(1e-100..1e100).contains(&size) {
            continue;
        }
        let m = nalgebra::SMatrix::<f64, 3, 3>::from_fn(|i, j| F.0[i][j]);
        let mut reference: Vec<f64> = m.singular_values().iter().copied().collect();
        reference.sort_by(|a, b| b.total_cmp(a));
        let ours = signed_svd(&F).sigma;
        for i in 0..3 {
            assert!((ours[i].abs() - reference[i]).abs() <= 4e-15 * size);
        }
    }
}

#[test]
fn lanes_have_the_bits_of_the_scalar() {
    fn check<const D: usize>() {
        let all = matrices::<D>();
        for chunk in all.chunks_exact(8) {
            let packed =
                Mat::<F64x8, D>::from_fn(|i, j| Lanes(std::array::from_fn(|k| chunk[k].0[i][j])));
            let lanes = signed_svd(&packed);
            for k in 0..8 {
                let one = signed_svd(&chunk[k]);
                for i in 0..D {
                    assert_eq!(one.sigma[i].to_bits(), lanes.sigma[i].0[k].to_bits());
                    for j in 0..D {
                        assert_eq!(one.U.0[i][j].to_bits(), lanes.U.0[i][j].0[k].to_bits());
                        assert_eq!(one.V.0[i][j].to_bits(), lanes.V.0[i][j].0[k].to_bits());
                    }
                }
            }
        }
    }
    check::<2>();
    check::<3>();
}

#[test]
fn symmetric_eigen_of_every_kind() {
    fn check<const D: usize>() {
        for F in matrices::<D>() {
            let A = F.symmetric_part();
            let eigen = symmetric_eigen(&A);
            check_rotation(&eigen.vectors, "eigenvectors", &A);
            let back = (eigen.vectors * Mat::from_diagonal(eigen.values)).mul_tr(&eigen.vectors);
            assert!(largest(&(back - A)) <= 4e-15 * largest(&F));
            assert!(eigen.values.windows(2).all(|w| w[0] >= w[1]));
        }
    }
    check::<2>();
    check::<3>();
}

fn polar_and_qr<const D: usize>() {
    for F in matrices::<D>() {
        let size = largest(&F);
        let p = polar(&F);
        check_rotation(&p.R, "R", &F);
        assert!(largest(&(p.R * p.S - F)) <= 6e-15 * size, "{F:?}");
        assert_eq!(p.S, p.S.transpose());
        let qr = signed_qr(&F);
        check_rotation(&qr.Q, "Q", &F);
        assert!(largest(&(qr.Q * qr.R - F)) <= 2e-15 * size, "{F:?}");
        for i in 0..D {
            assert!(i + 1 == D || qr.R.0[i][i] >= 0.0);
            assert!((0..i).all(|j| qr.R.0[i][j] == 0.0));
        }
        if qr.unique
            && size < 1e80
            && size > 1e-80
            && F.determinant().abs() > 1e-12 * size.powi(D as i32)
        {
            assert_eq!(qr.R.0[D - 1][D - 1] > 0.0, F.determinant() > 0.0);
        }
    }
}

/// A column that depends on those before it is replaced by one at right angles to them, wherever they
/// point.
#[test]
fn a_frame_is_completed_beside_any_axis() {
    let r = 0.5_f64.sqrt();
    for first in [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
        [-r, -r, 0.0],
        [-0.6, 0.0, 0.8],
    ] {
        let F = Mat::<f64, 3>::from_fn(|i, j| first[i] * [1.0, -2.0, 0.0][j]);
        let Qr { Q, R, .. } = signed_qr(&F);
        check_rotation(&Q, "Q", &F);
        assert!(largest(&(Q * R - F)) < 1e-15, "{first:?}");
    }
    // Beside 1 squares underflow, and a column of zeros leaves no frame to differentiate.
    let tiny = Mat([
        [1.0, 0.0, 0.0],
        [0.0, 1.1e-160, 3e-161],
        [0.0, 2.3e-161, 1.2e-160],
    ]);
    check_rotation(&signed_qr(&tiny).Q, "Q", &tiny);
    let none = Mat::<f64, 3>::from_diagonal([0.0, 1.0, 2.0]);
    let change = Mat::identity();
    assert!(!signed_qr(&none).q_differential(&change).exists);
    // Of rank one, and only to rounding: two sums of singular values are no numbers to divide by.
    let mut random = Random(17);
    for _ in 0..20 {
        let [u, v]: [[f64; 3]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit()));
        assert!(!polar(&Mat::outer(u, v)).unique());
    }
}

/// d²R in two directions: the differential of dual numbers against differences of itself.
#[test]
fn the_differential_of_a_rotation_has_a_differential() {
    let mut random = Random(23);
    for _ in 0..20 {
        let (F, dF, dG) = (
            random.tame::<3>(),
            random.matrix::<3>(),
            random.matrix::<3>(),
        );
        let rate = |F: &Mat<f64, 3>| polar(F).rotation_differential(&dG).value;
        let h = 1e-5;
        let moved = |t: f64| rate(&(F + dF.scale(t)));
        let slope = (moved(h) - moved(-h)).scale(0.5 / h);
        let dual = Mat::<_, 3>::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]));
        let fixed = Mat::<_, 3>::from_fn(|i, j| Dual::new(dG.0[i][j], 0.0));
        let found = polar(&dual).rotation_differential(&fixed).value;
        let found = Mat::<f64, 3>::from_fn(|i, j| found.0[i][j].derivative);
        assert!(largest(&(found - slope)) < 1e-8 * (1.0 + largest(&slope)));
    }
}

#[test]
fn polar_and_qr_of_every_kind() {
    polar_and_qr::<2>();
    polar_and_qr::<3>();
}

fn differentials_by_dual_numbers<const D: usize>() {
    let mut random = Random(5);
    for F in (0..100)
        .map(|_| random.matrix())
        .chain([Mat::identity(), Mat::from_diagonal([2.0; D])])
        .collect::<Vec<Mat<f64, D>>>()
    {
        let dF = random.matrix::<D>();
        let dual = Mat::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]));
        let derivative = |M: Mat<Dual<f64>, D>| Mat::from_fn(|i, j| M.0[i][j].derivative);
        let close = |a: Mat<f64, D>, b: Mat<f64, D>| {
            let error = largest(&(a - b));
            assert!(error <= 1e-12 * (1.0 + largest(&a)), "{error:e} for {F:?}");
        };
        let (p, dual_p) = (polar(&F), polar(&dual));
        if p.unique() {
            close(
                p.rotation_differential(&dF).ok().unwrap(),
                derivative(dual_p.R),
            );
            close(
                p.stretch_differential(&dF).ok().unwrap(),
                derivative(dual_p.S),
            );
            close(
                p.rotation_derivative().value.apply(&dF),
                derivative(dual_p.R),
            );
            close(
                p.stretch_derivative().value.apply(&dF),
                derivative(dual_p.S),
            );
        }
        let (qr, dual_qr) = (signed_qr(&F), signed_qr(&dual));
        close(qr.q_differential(&dF).ok().unwrap(), derivative(dual_qr.Q));
        close(qr.r_differential(&dF).ok().unwrap(), derivative(dual_qr.R));
        close(qr.q_derivative().value.apply(&dF), derivative(dual_qr.Q));
        close(qr.r_derivative().value.apply(&dF), derivative(dual_qr.R));
    }
}

#[test]
fn polar_and_qr_differentials_by_dual_numbers() {
    differentials_by_dual_numbers::<2>();
    differentials_by_dual_numbers::<3>();
}

fn svd_differentials<const D: usize>() {
    let mut random = Random(6);
    for _ in 0..100 {
        // Values well apart, for the derivatives of U and V grow as 1/gap.
        let stretch = std::array::from_fn(|i| 2.0 - 0.7 * i as f64);
        let F = (random.rotation::<D>() * Mat::from_diagonal(stretch)).mul_tr(&random.rotation());
        let dF = random.matrix::<D>();
        let dual: Mat<Dual<f64>, D> = Mat::from_fn(|i, j| Dual::new(F.0[i][j], dF.0[i][j]));
        let (svd, expected) = (signed_svd(&F), signed_svd(&dual));
        let d = svd.differential(&dF).ok().expect("values are distinct");
        let (dU, dV) = (
            svd.u_derivative().value.apply(&dF),
            svd.v_derivative().value.apply(&dF),
        );
        for i in 0..D {
            assert!((d.dsigma[i] - expected.sigma[i].derivative).abs() < 1e-12);
            assert!((svd.sigma_gradient(i).dot(&dF) - d.dsigma[i]).abs() < 1e-14);
            for j in 0..D {
                let (u, v) = (expected.U.0[i][j].derivative, expected.V.0[i][j].derivative);
                assert!((d.dU.0[i][j] - u).abs() < 1e-12, "{} {u}", d.dU.0[i][j]);
                assert!((d.dV.0[i][j] - v).abs() < 1e-12, "{} {v}", d.dV.0[i][j]);
                assert!((dU.0[i][j] - u).abs() < 1e-12 && (dV.0[i][j] - v).abs() < 1e-12);
            }
        }
    }
    // Repeated values: U and V have no derivative, and it is said.
    let repeated = signed_svd(&Mat::<f64, D>::identity());
    assert!(!repeated.differential(&Mat::identity()).exists);
    assert_eq!(repeated.u_derivative().ok(), None);
    // R = U Vᵀ has one there, but not where two values cancel.
    assert!(polar(&Mat::<f64, D>::identity()).unique());
    let mut diagonal = [1.0; D];
    diagonal[D - 1] = -1.0;
    assert_eq!(
        polar(&Mat::from_diagonal(diagonal))
            .rotation_derivative()
            .ok(),
        None
    );
    assert!(!signed_qr(&Mat::<f64, D>::zeros()).unique);
}

#[test]
fn svd_differentials_by_dual_numbers() {
    svd_differentials::<2>();
    svd_differentials::<3>();
}

#[test]
fn differentials_by_a_ladder_of_steps() {
    let mut random = Random(7);
    for _ in 0..10 {
        let (F, dF) = (random.tame::<3>(), random.matrix::<3>());
        let (dR, dQ) = (
            polar(&F).rotation_differential(&dF).value,
            signed_qr(&F).q_differential(&dF).value,
        );
        let best = |exact: &Mat<f64, 3>, f: &dyn Fn(&Mat<f64, 3>) -> Mat<f64, 3>| {
            (2..8)
                .map(|n| {
                    let h = 10f64.powi(-n);
                    let step = f(&(F + dF.scale(h))) - f(&(F - dF.scale(h)));
                    largest(&(step.scale(0.5 / h) - *exact))
                })
                .fold(f64::INFINITY, f64::min)
        };
        assert!(best(&dR, &|F| polar(F).R) < 1e-8);
        assert!(best(&dQ, &|F| signed_qr(F).Q) < 1e-8);
    }
}

#[test]
fn second_derivatives_by_nested_dual_numbers() {
    // tr S = Σσ: its Hessian is ∂R/∂F, also at the repeated values of a rotation.
    let mut random = Random(8);
    for F in [Mat::identity(), random.rotation::<3>(), random.tame::<3>()] {
        let (a, b) = (random.matrix::<3>(), random.matrix::<3>());
        let nested: Mat<Dual<Dual<f64>>, 3> = Mat::from_fn(|i, j| {
            Dual::new(Dual::new(F.0[i][j], a.0[i][j]), Dual::new(b.0[i][j], 0.0))
        });
        let second = polar(&nested).S.trace().derivative.derivative;
        let expected = polar(&F).rotation_differential(&a).value.dot(&b);
        assert!((second - expected).abs() < 1e-12, "{second} {expected}");
    }
}
