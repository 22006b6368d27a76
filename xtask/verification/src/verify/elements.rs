//! Single elements against `elements_<d>d.json`: rest shape, F, energy, forces, stiffness.

use super::VerifyError;
use super::runtime::{RuntimeMaterial, with_material};
use crate::numbers::{Number, Numbers, distance, entries, norm};
use crate::report::Report;
use crate::shared::read_json;
use fem_kinematics::{Mat, RestShape, Tensor4, deformation_gradient, shape_matrix};
use serde::Deserialize;
use std::collections::BTreeMap;
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
    X: Numbers,
    x: Numbers,
    Dm_inv: Numbers,
    vol: Number,
    F: Numbers,
    Bm: Numbers,
    models: Vec<Model>,
}

#[derive(Deserialize)]
struct Model {
    model: String,
    params: BTreeMap<String, String>,
    energy: Number,
    forces: Numbers,
    K: Numbers,
    ulp_forces: Number,
}

/// Every element of the table of D dimensions.
///
/// # Errors
/// If the table can't be read.
pub fn check<const D: usize>(folder: &Path, report: &mut Report) -> Result<(), VerifyError> {
    let table: Table = read_json(&folder.join(format!("elements_{D}d.json")))?;
    for case in &table.cases {
        let (X, x) = (case.X.vectors::<D>(), case.x.vectors::<D>());
        let Dm = shape_matrix(&X);
        let rest = RestShape::from_shape_matrix(&Dm);
        let F = deformation_gradient(&shape_matrix(&x), &rest.inverse);
        let condition = norm(&entries(&Dm)) * norm(&case.Dm_inv.0);
        let group = format!("elements {D}D");
        let mut record = |quantity: &str, got: &[f64], exact: &[f64], change: f64| {
            let c = distance(got, exact) / (EPSILON * norm(exact) + change);
            report.record(&group, quantity, &case.cat, &case.id.to_string(), c, C);
        };
        // D_m⁻¹ is known to ε cond(D_m), what one rounding of the rest positions does to it.
        let relative = EPSILON * condition;
        let inverse = entries(&rest.inverse);
        record(
            "Dm⁻¹",
            &inverse,
            &case.Dm_inv.0,
            relative * norm(&case.Dm_inv.0),
        );
        record(
            "volume",
            &[rest.volume],
            &[case.vol.0],
            relative * case.vol.0,
        );
        let normals = entries(&rest.area_normals());
        record("Bm", &normals, &case.Bm.0, relative * norm(&case.Bm.0));
        let stretch = norm(&entries(&shape_matrix(&x))) * norm(&case.Dm_inv.0);
        record("F", &entries(&F), &case.F.0, EPSILON * stretch * condition);
        let deformed = norm(&entries(&shape_matrix(&x)));
        for model in &case.models {
            let check = |material: &dyn RuntimeMaterial| {
                let group = format!("element {} {D}D", model.model);
                let P = Mat::from_fn(|i, j| material.stress(&entries(&F))[D * i + j]);
                let mut record = |quantity: &str, got: &[f64], exact: &[f64], change: f64| {
                    let c = distance(got, exact) / (EPSILON * norm(exact) + change);
                    report.record(&group, quantity, &case.cat, &case.id.to_string(), c, C);
                };
                // What a rounding of the rest and of the deformed positions moves: F by
                // ε cond(D_m)|F|, thus the energy by f·x and the forces by K x times that.
                let shift = relative * deformed;
                let energy = rest.volume * material.energy(&entries(&F));
                let by_position = (norm(&model.forces.0) + norm(&model.K.0) * shift) * shift;
                record("energy", &[energy], &[model.energy.0], by_position);
                let forces: Vec<f64> = (0..=D)
                    .flat_map(|a| P.mul_vec(rest.area_normal(a)))
                    .collect();
                let change = model.ulp_forces.0 + norm(&model.K.0) * shift;
                record("forces", &forces, &model.forces.0, change);
                let K = stiffness(
                    &rest,
                    &tensor_from_rows(&material.derivative_rows(&entries(&F))),
                );
                let change = relative * norm(&model.K.0) * (1.0 + third_derivative(material, &F));
                record("K", &K, &model.K.0, change);
            };
            if let Err(error) = with_material(&model.model, D, &model.params, check) {
                report.broken(format!("elements_{D}d.json: {error}"));
            }
        }
    }
    Ok(())
}

/// K = ∂²E/∂x², by rows, from the rows g_a of D_m⁻¹: K_ab = V Σ (g_a)_j (g_b)_l ∂P_ij/∂F_kl.
fn stiffness<const D: usize>(rest: &RestShape<f64, D>, tensor: &Tensor4<f64, D>) -> Vec<f64> {
    let normals: Vec<[f64; D]> = (0..=D).map(|a| rest.area_normal(a)).collect();
    let mut K = Vec::new();
    for a in &normals {
        let row: Vec<_> = normals.iter().map(|b| tensor.contract(*a, *b)).collect();
        for i in 0..D {
            for block in &row {
                K.extend(block.0[i].map(|k| k / rest.volume));
            }
        }
    }
    K
}

/// |F| |∂²P/∂F²| / |∂P/∂F|, roughly: how strongly a relative change of F is amplified in ∂P/∂F.
fn third_derivative<const D: usize>(material: &dyn RuntimeMaterial, F: &Mat<f64, D>) -> f64 {
    let (h, here) = (1e-6, material.derivative_rows(&entries(F)));
    let moved: Vec<f64> = entries(F)
        .iter()
        .enumerate()
        .map(|(n, f)| f * (1.0 + if n % 2 == 0 { h } else { -h }))
        .collect();
    distance(&material.derivative_rows(&moved), &here) / (h * norm(&here))
}

fn tensor_from_rows<const D: usize>(rows: &[f64]) -> Tensor4<f64, D> {
    Tensor4::from_fn(|i, j, k, l| rows[(D * i + j) * D * D + D * k + l])
}
