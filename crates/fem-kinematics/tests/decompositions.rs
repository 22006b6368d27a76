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
