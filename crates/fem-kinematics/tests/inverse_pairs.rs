//! Decompositions undo products and products undo decompositions, det F < 0 included.
#![allow(non_snake_case)]

use approx::assert_abs_diff_eq;
use fem_kinematics::{Mat, polar, signed_qr, signed_svd};
use proptest::prelude::*;

type Mat3 = Mat<f64, 3>;

fn any_matrix() -> impl Strategy<Value = Mat3> {
    let entries = prop::array::uniform3(prop::array::uniform3(-1.0..1.0));
    (entries, -3..=3).prop_map(|(rows, size)| Mat(rows).scale(10_f64.powi(size)))
}

/// By unit quaternions, which no decomposition knows of.
fn rotation() -> impl Strategy<Value = Mat3> {
    let quaternions = prop::array::uniform4(-1.0..1.0_f64);
    let long = |q: &[f64; 4]| q.iter().map(|c| c * c).sum::<f64>() > 0.01;
    quaternions
        .prop_filter("too short for a direction", long)
        .prop_map(|q| {
            let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
            let [w, x, y, z] = q.map(|c| c / length);
            Mat([
                [
                    1.0 - 2.0 * (y * y + z * z),
                    2.0 * (x * y - w * z),
                    2.0 * (x * z + w * y),
                ],
                [
                    2.0 * (x * y + w * z),
                    1.0 - 2.0 * (x * x + z * z),
                    2.0 * (y * z - w * x),
                ],
                [
                    2.0 * (x * z - w * y),
                    2.0 * (y * z + w * x),
                    1.0 - 2.0 * (x * x + y * y),
                ],
            ])
        })
}

/// σ₁ > σ₂ > |σ₃|, far enough apart for the factors to be determined; half of the last are negative.
fn stretches() -> impl Strategy<Value = [f64; 3]> {
    (2.0..3.0, 1.0..1.8, -0.8..0.8).prop_map(|(a, b, c)| [a, b, c])
}

fn assert_close(found: &Mat3, expected: &Mat3, epsilon: f64) {
    let (found, expected) = (found.0.as_flattened(), expected.0.as_flattened());
    assert_abs_diff_eq!(found, expected, epsilon = epsilon);
}

proptest! {
    #[test]
    fn factors_multiply_to_what_was_decomposed(F in any_matrix()) {
        let largest = F.0.iter().flatten().fold(0.0_f64, |m, c| m.max(c.abs()));
        let rounding = 1e-14 * largest;
        let svd = signed_svd(&F);
        assert_close(&svd.compose(svd.sigma), &F, rounding);
        let stretched = polar(&F);
        assert_close(&(stretched.R * stretched.S), &F, rounding);
        let qr = signed_qr(&F);
        assert_close(&(qr.Q * qr.R), &F, rounding);
    }

    #[test]
    fn singular_values_are_those_that_were_put_in(
        U in rotation(), V in rotation(), sigma in stretches(),
    ) {
        let F = (U * Mat::from_diagonal(sigma)).mul_tr(&V);
        let found = signed_svd(&F);
        assert_abs_diff_eq!(found.sigma[..], sigma[..], epsilon = 1e-13);
        // Each pair of axes is determined up to its sign.
        for k in 0..3 {
            let own = Mat::outer(found.U.column(k), found.V.column(k));
            assert_close(&own, &Mat::outer(U.column(k), V.column(k)), 1e-12);
        }
    }

    #[test]
    fn rotation_and_stretch_are_those_that_were_put_in(
        R in rotation(), V in rotation(), sigma in stretches(),
    ) {
        let S = (V * Mat::from_diagonal(sigma)).mul_tr(&V);
        let found = polar(&(R * S));
        assert_close(&found.R, &R, 1e-12);
        assert_close(&found.S, &S, 1e-12);
    }

    #[test]
    fn triangular_factors_are_those_that_were_put_in(
        Q in rotation(),
        diagonal in stretches(),
        above in prop::array::uniform3(-1.0..1.0),
    ) {
        let [d, e, f] = diagonal;
        let R = Mat([[d, above[0], above[1]], [0.0, e, above[2]], [0.0, 0.0, f]]);
        let found = signed_qr(&(Q * R));
        assert_close(&found.Q, &Q, 1e-12);
        assert_close(&found.R, &R, 1e-12);
    }
}
