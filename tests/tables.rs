//! The reference tables, and what the comparison with them says about a model with a mistake.
#![allow(non_snake_case, missing_docs)]

use fem_kinematics::{Mat, Real};
use fem_materials::{Material, NeoHookean};
use verification::report::{Report, Style};
use verification::shared::folder_or_skip;
use verification::verify::{check_conformance, check_tables, materials, table::Table};

#[test]
fn every_model_agrees_with_its_table() {
    let Some(folder) = folder_or_skip(None, "reference") else {
        return;
    };
    let mut report = Report::default();
    check_tables(&folder, &mut report).expect("the tables can be read");
    println!("{}", report.tables(Style::Plain));
    println!("{}", report.summary(Style::Plain));
    report.assert();
}

#[test]
fn every_model_passes_the_conformance_suite() {
    let seed = fem_materials::conformance::fresh_seed();
    println!("seed {seed:#x}");
    let mut report = Report::default();
    check_conformance(seed, 2, &mut report);
    report.assert();
}

/// One case written by hand: neo-Hookean at diag(2, 1), μ = 1, λ = 1.5.
const TABLE: &str = r#"{
    "model": "neo_hookean", "dim": 2, "params": [{"mu": "1.0", "lambda": "1.5"}],
    "cases": [{"id": 7, "cat": "moderate", "p": 0, "F": "2 0 0 1",
        "psi": "1.1671925798787057", "P": "2.01986038542 0 0 1.03972077084",
        "dPdF": "2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2", "eig": "1 1 2 2", "psd": null, "kink": true,
        "ulp": {"psi": "1e-12", "P": "1e-11", "dPdF": "1e-15"},
        "mag": {"psi": "1", "P": "1", "dPdF": "1"}}]
}"#;

/// Neo-Hookean with the shear modulus off by one part in a million in the stress alone.
#[derive(Clone, Copy)]
struct Planted(NeoHookean);

impl Material<2> for Planted {
    fn energy<T: Real>(&self, F: &Mat<T, 2>) -> T {
        self.0.energy(F)
    }
    fn stress<T: Real>(&self, F: &Mat<T, 2>) -> Mat<T, 2> {
        self.0.stress(F) + F.scale(T::from_f64(1e-6))
    }
    fn stress_differential<T: Real>(&self, F: &Mat<T, 2>, dF: &Mat<T, 2>) -> Mat<T, 2> {
        self.0.stress_differential(F, dF)
    }
}

#[test]
fn a_planted_mistake_is_caught_by_name() {
    let table: Table = serde_json::from_str(TABLE).expect("the case above has the format");
    let right = NeoHookean {
        mu: 1.0,
        lambda: 1.5,
    };
    let mut report = Report::default();
    materials::check::<2, _>(&table, |_| Some(right), |_, _| None, &mut report);
    report.assert();

    let mut report = Report::default();
    materials::check::<2, _>(&table, |_| Some(Planted(right)), |_, _| None, &mut report);
    assert!(!report.passed());
    let summary = report.summary(Style::Plain);
    assert!(
        summary.contains("FAILED neo_hookean 2D / P / moderate"),
        "{summary}"
    );
    assert!(summary.contains("id 7"), "{summary}");
    let failed: Vec<_> = report.failures().map(|e| e.quantity.as_str()).collect();
    assert_eq!(failed, ["P", "P (lanes)"]);
}

#[test]
fn a_table_without_a_model_fails_the_run() {
    let folder = std::env::temp_dir().join(format!("tables-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let unknown = TABLE.replace("neo_hookean", "unobtainium");
    std::fs::write(folder.join("unobtainium_2d.json"), unknown).expect("a small file");
    let mut report = Report::default();
    let error = check_tables(&folder, &mut report).expect_err("there is no lame.json");
    std::fs::remove_dir_all(&folder).expect("removed again");
    assert!(error.to_string().contains("lame.json"), "{error}");
    assert!(report.summary(Style::Plain).contains("unobtainium_2d.json"));
}
