//! Materials against their tables: ψ, P, dP/dF, eigenvalues, projection, activation.

use super::table::{Case, Indicators, Table};
use crate::numbers::{Number, by_rows, distance, entries, norm};
use crate::report::Report;
use fem_kinematics::{F64x8, Lanes, Mat, Tensor4};
use fem_materials::{HessianProjection, Material};

/// The C of |error| ≤ C (2.2e-16 mag + ulp) that every model has to reach.
pub const LARGEST_C: f64 = 32.0;

/// Models that must lose no digit to cancellation near rest: there, |error| ≤ C ulp.
const EXACT_NEAR_REST: [&str; 4] = ["linear", "stvk", "neo_hookean", "snh_nolog"];

/// Compares a material with every case of a table, or with those of one set of parameters.
pub fn check<const D: usize, M: Material<D>>(
    table: &Table,
    material_of: impl Fn(usize) -> Option<M>,
    by_activation: impl Fn(usize, &Mat<f64, D>) -> Option<Vec<f64>>,
    report: &mut Report,
) {
    let group = format!("{} {}D", table.model, table.dim);
    for case in &table.cases {
        match material_of(case.parameters) {
            Some(material) => {
                check_case(&group, &table.model, case, &material, report);
                if let Some(expected) = &case.dP_dalpha {
                    let found = by_activation(case.parameters, &case.F.matrix());
                    check_activation(&group, case, found, &expected.0, report);
                }
            }
            None => report.broken(format!("{group}: case {} has no material", case.id)),
        }
    }
}

/// |error| in units of 2.2e-16 mag + ulp; 0/0, an exact zero met exactly, is 0.
fn in_units(error: f64, mag: Number, ulp: Number) -> f64 {
    let unit = 2.2e-16 * mag.0 + ulp.0;
    if error == 0.0 { 0.0 } else { error / unit }
}

fn check_case<const D: usize, M: Material<D>>(
    group: &str,
    model: &str,
    case: &Case,
    material: &M,
    report: &mut Report,
) {
    let F: Mat<f64, D> = case.F.matrix();
    let Indicators { psi, P, dPdF } = case.mag;
    let mut record = |quantity: &str, error: f64, mag: Number, ulp: Number| {
        let c = in_units(error, mag, ulp);
        report.record(
            group,
            quantity,
            &case.cat,
            &case.id.to_string(),
            c,
            LARGEST_C,
        );
    };

    let energy = material.energy(&F);
    let stress = entries(&material.stress(&F));
    let in_energy = (energy - case.psi.0).abs();
    let in_stress = distance(&stress, &case.P.0);
    record("psi", in_energy, psi, case.ulp.psi);
    record("P", in_stress, P, case.ulp.P);
    if EXACT_NEAR_REST.contains(&model) && case.cat == "near_identity" {
        record("psi/ulp", in_energy, Number(0.0), case.ulp.psi);
        record("P/ulp", in_stress, Number(0.0), case.ulp.P);
    }

    let packed = Mat::<F64x8, D>::from_fn(|i, j| Lanes([F[(i, j)]; 8]));
    let packed_stress = material.stress(&packed);
    let lane = Mat::<f64, D>::from_fn(|i, j| packed_stress[(i, j)].0[3]);
    let in_lane = distance(&entries(&lane), &case.P.0);
    record("P (lanes)", in_lane, P, case.ulp.P);

    if case.kink {
        return;
    }
    let tensor = material.stress_derivative(&F);
    let error = distance(&by_rows(&tensor), &case.dPdF.0);
    record("dP/dF", error, dPdF, case.ulp.dPdF);
    let differential = Tensor4::from_linear_map(|dF| material.stress_differential(&F, dF));
    let error = distance(&by_rows(&differential), &case.dPdF.0);
    record("dP(dF)", error, dPdF, case.ulp.dPdF);
    let error = distance(&eigenvalues(&tensor), &case.eig.0);
    record("eig", error, dPdF, case.ulp.dPdF);
    // The model's own projection is compared with this numeric one by the conformance suite.
    let projected = HessianProjection::Clamp.apply(&tensor);
    let expected = case.psd.as_ref().unwrap_or(&case.dPdF);
    let error = distance(&by_rows(&projected), &expected.0);
    record("psd", error, dPdF, case.ulp.dPdF);
}

/// Compares ∂P/∂α, a muscle's stress by its activation.
fn check_activation(
    group: &str,
    case: &Case,
    found: Option<Vec<f64>>,
    expected: &[f64],
    report: &mut Report,
) {
    let Some(found) = found else {
        report.broken(format!("{group}: case {} has no activation", case.id));
        return;
    };
    let error = distance(&found, expected);
    // The activation has no indicator of its own: its stress is one of the terms of P, and its
    // size is what one activation adds.
    let own = Number(case.mag.P.0.max(norm(expected)));
    let c = in_units(error, own, case.ulp.P);
    let id = case.id.to_string();
    report.record(group, "dP/dalpha", &case.cat, &id, c, LARGEST_C);
}

/// Eigenvalues of dP/dF as a D²×D² matrix, ascending, by a solver that is not ours.
fn eigenvalues<const D: usize>(tensor: &Tensor4<f64, D>) -> Vec<f64> {
    let rows = nalgebra::DMatrix::from_row_slice(D * D, D * D, &by_rows(tensor));
    let symmetric = (&rows + rows.transpose()) * 0.5;
    let mut values = symmetric.symmetric_eigenvalues().as_slice().to_vec();
    values.sort_by(f64::total_cmp);
    values
}
