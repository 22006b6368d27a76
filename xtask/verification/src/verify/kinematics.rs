//! Decompositions and their derivatives against the tables `kinematics_<d>d.json`.

use super::VerifyError;
use crate::numbers::{Numbers, by_rows, distance, entries, norm};
use crate::report::Report;
use crate::shared::read_json;
use fem_kinematics::{Mat, Tensor4, polar, signed_qr, signed_svd};
use serde::Deserialize;
use std::path::Path;

const C: f64 = 32.0;
const EPSILON: f64 = 2.2e-16;

#[derive(Deserialize)]
struct Table {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    id: usize,
    cat: String,
    F: Numbers,
    sigma: Numbers,
    U: Numbers,
    V: Numbers,
    R_polar: Numbers,
    S: Numbers,
    dR_polar: Numbers,
    Q: Option<Numbers>,
    R_qr: Option<Numbers>,
    dQ: Option<Numbers>,
    dR_qr: Option<Numbers>,
    dSigma: Option<Numbers>,
    dU: Option<Numbers>,
    dV: Option<Numbers>,
    cond: Conditions,
}

/// Change for one rounding of F, relative except for U and V.
#[derive(Deserialize)]
struct Conditions {
    R_polar: Numbers,
    dR_polar: Numbers,
    /// One for each value.
    sigma: Vec<Numbers>,
    UV: Numbers,
    Q: Option<Numbers>,
    R_qr: Option<Numbers>,
    dQ: Option<Numbers>,
}

/// Every case of the table of D dimensions.
///
/// # Errors
/// If the table can't be read.
pub fn check<const D: usize>(folder: &Path, report: &mut Report) -> Result<(), VerifyError> {
    let table: Table = read_json(&folder.join(format!("kinematics_{D}d.json")))?;
    for case in &table.cases {
        check_case::<D>(case, report);
    }
    Ok(())
}

fn check_case<const D: usize>(case: &Case, report: &mut Report) {
    let group = format!("kinematics {D}D");
    let F: Mat<f64, D> = case.F.matrix();
    let size = norm(&case.F.0);
    // error ≤ C (ε |X| + change of X for one rounding of F)
    let mut record = |quantity: &str, got: &[f64], exact: &[f64], change: f64| {
        let error = distance(got, exact);
        let unit = EPSILON * norm(exact) + change;
        let c = if error == 0.0 { 0.0 } else { error / unit };
        report.record(&group, quantity, &case.cat, &case.id.to_string(), c, C);
    };
    let first = |n: &Option<Numbers>| n.as_ref().map_or(0.0, |n| n.0[0]);

    let svd = signed_svd(&F);
    let back = svd.U * Mat::from_diagonal(svd.sigma).mul_tr(&svd.V);
    record("UΣVᵀ = F", &entries(&back), &case.F.0, 0.0);
    let identity = entries(&Mat::<f64, D>::identity());
    record("UᵀU = I", &entries(&svd.U.tr_mul(&svd.U)), &identity, 0.0);
    record("VᵀV = I", &entries(&svd.V.tr_mul(&svd.V)), &identity, 0.0);
    let determinants = [svd.U.determinant(), svd.V.determinant()];
    record("det U, V = 1", &determinants, &[1.0, 1.0], 0.0);
    for (n, cond) in case.cond.sigma.iter().enumerate() {
        let exact = case.sigma.0[n];
        let cond = if exact == 0.0 {
            0.0
        } else {
            cond.0[0] * exact.abs()
        };
        // A vanishing value is known to a rounding of F.
        let change = cond + if exact == 0.0 { EPSILON * size } else { 0.0 };
        record("sigma", &[svd.sigma[n]], &[exact], change);
    }
    let distinct = case.cond.UV.0[0];
    if distinct.is_finite() {
        let sign = paired_signs(&svd.V, &case.V.matrix());
        record("U", &entries(&(svd.U * sign)), &case.U.0, distinct);
        record("V", &entries(&(svd.V * sign)), &case.V.0, distinct);
        if let (Some(dSigma), Some(dU), Some(dV)) = (&case.dSigma, &case.dU, &case.dV) {
            let got: Vec<f64> = (0..D)
                .flat_map(|n| entries(&svd.sigma_gradient(n)))
                .collect();
            record("dσ", &got, &dSigma.0, distinct);
            // Turned by `distinct`, U and V carry their own derivatives along; the rates 1/(σᵢ − σⱼ)
            // lose as much again.
            let signed = |tensor: Tensor4<f64, D>| {
                by_rows(&Tensor4::from_linear_map(|dF| tensor.apply(dF) * sign))
            };
            let change = |exact: &Numbers| distinct * norm(&exact.0);
            record("dU", &signed(svd.u_derivative().value), &dU.0, change(dU));
            record("dV", &signed(svd.v_derivative().value), &dV.0, change(dV));
        }
    }

    let polar = polar(&F);
    let turn = case.cond.R_polar.0[0] * norm(&case.R_polar.0);
    record("R (polar)", &entries(&polar.R), &case.R_polar.0, turn);
    record("S", &entries(&polar.S), &case.S.0, size * (turn + EPSILON));
    let change = case.cond.dR_polar.0[0] * norm(&case.dR_polar.0);
    let dR = polar.rotation_derivative();
    record("dR (polar)", &by_rows(&dR.value), &case.dR_polar.0, change);

    if let (Some(Q), Some(R)) = (&case.Q, &case.R_qr) {
        let qr = signed_qr(&F);
        record("Q", &entries(&qr.Q), &Q.0, first(&case.cond.Q) * norm(&Q.0));
        record(
            "R (QR)",
            &entries(&qr.R),
            &R.0,
            first(&case.cond.R_qr) * norm(&R.0),
        );
        if let (Some(dQ), Some(dR)) = (&case.dQ, &case.dR_qr) {
            let relative = first(&case.cond.dQ);
            let got = by_rows(&qr.q_derivative().value);
            record("dQ", &got, &dQ.0, relative * norm(&dQ.0));
            // dR = Qᵀ dF − (Qᵀ dQ) R: the error of dQ, times R.
            let got = by_rows(&qr.r_derivative().value);
            let change = relative * (norm(&dR.0) + norm(&dQ.0) * norm(&R.0));
            record("dR (QR)", &got, &dR.0, change);
        }
    }
}

/// The diagonal matrix of the column signs that bring `V` closest to `table`.
fn paired_signs<const D: usize>(V: &Mat<f64, D>, table: &Mat<f64, D>) -> Mat<f64, D> {
    let overlap = V.tr_mul(table);
    Mat::from_diagonal(core::array::from_fn(|i| overlap[(i, i)].signum()))
}
