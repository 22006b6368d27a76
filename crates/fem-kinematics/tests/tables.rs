//! The decompositions against tables of 25 digits; skipped where the tables are absent.
#![allow(non_snake_case)]

use fem_kinematics::*;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;

fn table(name: &str) -> Option<Value> {
    let shared = std::env::var_os("FEM_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let path = shared.join("reference").join(name);
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(serde_json::from_str(&text).expect("a table is valid JSON")),
        Err(_) => {
            println!("skipped: no {}", path.display());
            None
        }
    }
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    let text = value.as_str()?;
    Some(
        text.split_whitespace()
            .map(|x| x.parse().unwrap())
            .collect(),
    )
}

fn number(value: &Value) -> f64 {
    value.as_str().map_or(f64::INFINITY, |x| x.parse().unwrap())
}

fn flat<const D: usize>(M: &Mat<f64, D>) -> Vec<f64> {
    M.0.iter().flatten().copied().collect()
}

fn flat4<const D: usize>(t: &Tensor4<f64, D>) -> Vec<f64> {
    let mut all = Vec::new();
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                for l in 0..D {
                    all.push(t.get(i, j, k, l));
                }
            }
        }
    }
    all
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The factor C in |error| = C (2.2e-16 + cond) |X|, the worst of each quantity.
#[derive(Default)]
struct Worst(BTreeMap<&'static str, (f64, String)>);

impl Worst {
    fn note(&mut self, what: &'static str, got: &[f64], expected: &[f64], cond: f64, case: &Value) {
        let allowed = (f64::EPSILON + cond) * norm(expected);
        self.within(what, got, expected, allowed, case);
    }

    fn within(
        &mut self,
        what: &'static str,
        got: &[f64],
        expected: &[f64],
        allowed: f64,
        case: &Value,
    ) {
        let difference: Vec<f64> = got.iter().zip(expected).map(|(a, b)| a - b).collect();
        let error = norm(&difference);
        let factor = if error == 0.0 { 0.0 } else { error / allowed };
        let entry = self.0.entry(what).or_insert((0.0, String::new()));
        if factor > entry.0 || factor.is_nan() {
            *entry = (factor, format!("case {} ({})", case["id"], case["cat"]));
        }
    }
}

fn check<const D: usize>(name: &str) {
    let Some(table) = table(name) else { return };
    let cases = table["cases"].as_array().unwrap();
    assert!(cases.len() > 50);
    let mut worst = Worst::default();
    for case in cases {
        let entries = numbers(&case["F"]).unwrap();
        let F = Mat::<f64, D>::from_fn(|i, j| entries[D * i + j]);
        let cond = &case["cond"];
        let svd = signed_svd(&F);
        let sigma = numbers(&case["sigma"]).unwrap();
        for i in 0..D {
            // Rounding F alone moves a value by ε σ₁, which is all that a value of zero is allowed.
            let cond = number(&cond["sigma"][i]);
            let own = if sigma[i] == 0.0 {
                0.0
            } else {
                cond * sigma[i].abs()
            };
            let allowed = own + f64::EPSILON * sigma[0];
            worst.within("sigma", &[svd.sigma[i]], &[sigma[i]], allowed, case);
        }
        let condition = number(&cond["UV"]);
        if condition < 1e-9 {
            let (U, V) = (numbers(&case["U"]).unwrap(), numbers(&case["V"]).unwrap());
            for j in 0..D {
                let reference: Vec<f64> = (0..D)
                    .map(|i| U[D * i + j])
                    .chain((0..D).map(|i| V[D * i + j]))
                    .collect();
                let ours: Vec<f64> = svd.U.column(j).into_iter().chain(svd.V.column(j)).collect();
                let sign = ours
                    .iter()
                    .zip(&reference)
                    .map(|(a, b)| a * b)
                    .sum::<f64>()
                    .signum();
                let ours: Vec<f64> = ours.iter().map(|x| x * sign).collect();
                worst.note("U, V", &ours, &reference, condition, case);
            }
        }
        let p = polar(&F);
        let c = number(&cond["R_polar"]);
        worst.note(
            "R",
            &flat(&p.R),
            &numbers(&case["R_polar"]).unwrap(),
            c,
            case,
        );
        worst.note("S", &flat(&p.S), &numbers(&case["S"]).unwrap(), 0.0, case);
        let c = number(&cond["dR_polar"]);
        let derivative = p
            .rotation_derivative()
            .ok()
            .expect("tables hold unique rotations");
        worst.note(
            "dR",
            &flat4(&derivative),
            &numbers(&case["dR_polar"]).unwrap(),
            c,
            case,
        );
        let qr = signed_qr(&F);
        if let Some(Q) = numbers(&case["Q"]) {
            worst.note("Q", &flat(&qr.Q), &Q, number(&cond["Q"]), case);
            let c = number(&cond["R_qr"]);
            worst.note(
                "R (QR)",
                &flat(&qr.R),
                &numbers(&case["R_qr"]).unwrap(),
                c,
                case,
            );
            let c = number(&cond["dQ"]);
            let dQ = qr.q_derivative().ok().expect("the table has it");
            worst.note("dQ", &flat4(&dQ), &numbers(&case["dQ"]).unwrap(), c, case);
            let dR = qr.r_derivative().ok().expect("the table has it");
            worst.note(
                "dR (QR)",
                &flat4(&dR),
                &numbers(&case["dR_qr"]).unwrap(),
                c,
                case,
            );
        }
        if let Some(expected) = numbers(&case["dSigma"])
            && condition < 1e-9
        {
            let mut ours = Vec::new();
            for n in 0..D {
                ours.extend(flat(&svd.sigma_gradient(n)));
            }
            worst.note("dSigma", &ours, &expected, condition, case);
        }
    }
    for (what, (factor, case)) in &worst.0 {
        println!("{name} {what}: C = {factor:.2}, {case}");
    }
    for (what, (factor, case)) in &worst.0 {
        assert!(*factor <= 32.0, "{what}: C = {factor} in {case}");
    }
}

#[test]
fn tables_2d() {
    check::<2>("kinematics_2d.json");
}

#[test]
fn tables_3d() {
    check::<3>("kinematics_3d.json");
}
