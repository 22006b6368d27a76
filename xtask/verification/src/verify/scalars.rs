//! Lamé's parameters and the muscle curves.

use super::VerifyError;
use crate::numbers::Number;
use crate::report::Report;
use crate::shared::read_json;
use fem_materials::curves::{Blemker, PhysBam, TensionCurve};
use fem_materials::{Lame, Space};
use serde::Deserialize;
use std::path::Path;

const C: f64 = 32.0;

#[derive(Deserialize)]
struct LameTable {
    cases: Vec<LameCase>,
}

#[derive(Deserialize)]
struct LameCase {
    E: Number,
    nu: Number,
    mu: Number,
    lambda_2d: Option<Number>,
    lambda_3d: Option<Number>,
}

/// E, ν → μ, λ in the solid and in the plane; impossible pairs are refused.
///
/// # Errors
/// If the table can't be read.
pub fn check_lame(folder: &Path, report: &mut Report) -> Result<(), VerifyError> {
    let table: LameTable = read_json(&folder.join("lame.json"))?;
    for (index, case) in table.cases.iter().enumerate() {
        let (E, nu) = (case.E.0, case.nu.0);
        for (category, space, expected) in [
            ("solid", Space::Solid, case.lambda_3d),
            ("plane", Space::Plane, case.lambda_2d),
        ] {
            let mut record = |quantity: &str, error: f64| {
                report.record("lame", quantity, category, &index.to_string(), error, C);
            };
            match (Lame::from_young_poisson(E, nu, space), expected) {
                (Ok(lame), Some(lambda)) => {
                    // λ has a pole at ν = 1/(d − 1): what one rounding of ν moves it by.
                    let pole = match space {
                        Space::Solid => 1.0 - 2.0 * nu,
                        Space::Plane => 1.0 - nu,
                    };
                    let unit = 2.2e-16 * (1.0 + nu.abs() / pole.abs() + nu.abs() / (1.0 + nu));
                    let relative = |got: f64, exact: f64| match got - exact == 0.0 {
                        true => 0.0,
                        false => (got - exact).abs() / (unit * exact.abs()),
                    };
                    record("mu", relative(lame.mu, case.mu.0));
                    record("lambda", relative(lame.lambda, lambda.0));
                }
                (Err(_), None) => record("refused", 0.0),
                (Ok(_), None) | (Err(_), Some(_)) => record("refused", f64::INFINITY),
            }
        }
    }
    Ok(())
}

#[derive(Deserialize)]
struct CurveTable {
    cases: Vec<CurveCase>,
}

#[derive(Deserialize)]
struct CurveCase {
    curve: String,
    P1: Number,
    P2: Number,
    lambda_star: Number,
    l: Number,
    Fa: Number,
    fa: Number,
    dfa: Number,
    Fp: Number,
    fp: Number,
    dfp: Number,
    #[serde(default)]
    kink: bool,
}

/// Tension curves, their integrals and slopes.
///
/// # Errors
/// If the table can't be read.
pub fn check_curves(folder: &Path, report: &mut Report) -> Result<(), VerifyError> {
    let table: CurveTable = read_json(&folder.join("muscle_curves.json"))?;
    for case in &table.cases {
        let (P1, P2, lambda_star) = (case.P1.0, case.P2.0, case.lambda_star.0);
        match case.curve.as_str() {
            "physbam" => check_curve(
                &PhysBam {
                    P1,
                    P2,
                    lambda_star,
                },
                case,
                report,
            ),
            "blemker" => check_curve(
                &Blemker {
                    P1,
                    P2,
                    lambda_star,
                },
                case,
                report,
            ),
            other => report.broken(format!("muscle_curves.json: no curve `{other}`")),
        }
    }
    Ok(())
}

fn check_curve(curve: &impl TensionCurve, case: &CurveCase, report: &mut Report) {
    let l = case.l.0;
    let (active, passive) = (curve.active(l), curve.passive(l));
    let category = format!("curve {}", case.curve);
    let mut record = |quantity: &str, got: f64, exact: f64, slope: f64| {
        // One rounding of l moves a curve by its slope; its polynomials have terms of size 1,
        // and beyond that of its own size.
        let unit = 2.2e-16 * (1.0 + exact.abs() + slope.abs() * l.abs());
        let error = (got - exact).abs() / unit;
        report.record(
            "muscle_curves",
            quantity,
            &category,
            &case.l.0.to_string(),
            error,
            C,
        );
    };
    record("Fa", active.integral, case.Fa.0, case.fa.0);
    record("fa", active.value, case.fa.0, case.dfa.0);
    record("Fp", passive.integral, case.Fp.0, case.fp.0);
    record("fp", passive.value, case.fp.0, case.dfp.0);
    if !case.kink {
        record("dfa", active.slope, case.dfa.0, 10.0);
        record("dfp", passive.slope, case.dfp.0, 10.0 * case.dfp.0);
    }
}
