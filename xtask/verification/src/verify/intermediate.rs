//! What stands in the tables between F and ψ: invariants, the derivatives of ψ by them, and the
//! stretch of a fiber.

use super::VerifyError;
use super::table::{Case, Table};
use crate::numbers::{Number, norm};
use crate::report::Report;
use crate::shared::read_json;
use fem_kinematics::{Invariants, Mat};
use fem_materials::curves::PhysBam;
use fem_materials::isotropic::InvariantEnergy;
use fem_materials::{
    FiberLaw, FiberTerm, InvMooneyRivlin, InvNeoHookean, InvStVenantKirchhoff, Stretch,
};
use std::path::Path;

const C: f64 = 32.0;
const EPSILON: f64 = 2.2e-16;

/// The parameter set of a case.
struct Set<'a>(&'a Table, &'a Case);

impl Set<'_> {
    /// Its numbers of this name; empty, and thus refused below, where the table has none.
    fn numbers(&self, name: &str) -> Vec<f64> {
        let text = self.0.params.get(self.1.parameters);
        let words = text.and_then(|set| set.get(name));
        words.map_or(Vec::new(), |words| {
            let numbers = words.split_whitespace();
            numbers.map(|w| w.parse().unwrap_or(f64::NAN)).collect()
        })
    }
    fn number(&self, name: &str) -> f64 {
        self.numbers(name).first().copied().unwrap_or(f64::NAN)
    }
}

/// The invariants and ψ_I, ψ_II, … of the models by invariants; l of the models with fibers.
///
/// # Errors
/// If a table can't be read.
pub fn check(folder: &Path, report: &mut Report) -> Result<(), VerifyError> {
    let read = |name: &str| -> Result<Table, VerifyError> {
        Ok(read_json(&folder.join(format!("{name}_3d.json")))?)
    };
    invariants(&read("inv_neo_hookean")?, report, |set| InvNeoHookean {
        mu: set.number("mu"),
        lambda: set.number("lambda"),
    });
    invariants(&read("inv_stvk")?, report, |set| InvStVenantKirchhoff {
        mu: set.number("mu"),
        lambda: set.number("lambda"),
    });
    invariants(&read("inv_mooney_rivlin")?, report, |set| InvMooneyRivlin {
        mu01: set.number("mu01"),
        mu10: set.number("mu10"),
        v1: set.number("v1"),
    });
    for name in ["fiber_dev", "fiber_tilde", "muscle_dev", "muscle_tilde"] {
        fiber_stretch(&read(name)?, report);
    }
    Ok(())
}

fn invariants<M: InvariantEnergy>(table: &Table, report: &mut Report, model: impl Fn(&Set) -> M) {
    let group = format!("{} by invariants", table.model);
    for case in &table.cases {
        let (Some(exact), Some(first), Some(second)) =
            (&case.invariants, &case.psi_I, &case.psi_II)
        else {
            report.broken(format!("{group}: case {} has no invariants", case.id));
            continue;
        };
        let mut record = |quantity: &str, error: f64, unit: f64| {
            let c = if error == 0.0 { 0.0 } else { error / unit };
            report.record(&group, quantity, &case.cat, &case.id.to_string(), c, C);
        };
        let F: Mat<f64, 3> = case.F.matrix();
        let size = norm(&case.F.0);
        let found = Invariants::new(&F);
        for (n, (name, found)) in [
            ("I", found.first),
            ("II", found.second),
            ("III", found.third),
        ]
        .into_iter()
        .enumerate()
        {
            // One rounding of F moves the invariants by their slopes; III, a square, by that of J.
            let slope = [
                2.0 * size,
                4.0 * size.powi(3),
                2.0 * case.J.0.abs() * size.powi(2),
            ][n];
            let unit = EPSILON * (exact.0[n].abs() + slope * size)
                + (EPSILON * size.powi(3)).powi(2) * f64::from(n == 2);
            record(name, (found - exact.0[n]).abs(), unit);
        }

        // In units of energy: a derivative by an invariant times that invariant. Terms that cancel
        // in one derivative stand alone in the next.
        let at: [f64; 3] = core::array::from_fn(|n| exact.0[n]);
        let model = model(&Set(table, case));
        let gradient = model.gradient(at);
        let hessian = model.hessian(at);
        let entry = |i: usize, j: usize| hessian[[[0, 1, 2], [1, 3, 4], [2, 4, 5]][i][j]];
        let linear: f64 = (0..3).map(|i| (first.0[i] * at[i]).abs()).sum();
        let square: f64 = (0..9)
            .map(|n| (second.0[n] * at[n / 3] * at[n % 3]).abs())
            .sum();
        let unit = EPSILON * (linear + square);
        let error = (0..3).map(|i| ((gradient[i] - first.0[i]) * at[i]).abs());
        record("ψ_I", error.sum(), unit);
        let error = (model.energy(at) - case.psi.0).abs();
        record("ψ(I, II, III)", error, EPSILON * (case.mag.psi.0 + linear));
        let error = (0..9).map(|n| {
            let (i, j) = (n / 3, n % 3);
            ((entry(i, j) - second.0[n]) * at[i] * at[j]).abs()
        });
        record("ψ_II", error.sum(), unit);
    }
}

fn fiber_stretch(table: &Table, report: &mut Report) {
    let group = format!("{} stretch", table.model);
    let stretch = if table.model.ends_with("dev") {
        Stretch::Isochoric
    } else {
        Stretch::Total
    };
    let law = FiberLaw {
        curve: PhysBam::default(),
        stretch,
    };
    for case in &table.cases {
        let set = Set(table, case);
        let (direction, Some(Number(exact))) = (set.numbers("a0"), case.l) else {
            report.broken(format!("{group}: case {} has no stretch", case.id));
            continue;
        };
        let term = FiberTerm {
            direction: core::array::from_fn(|k| direction.get(k).copied().unwrap_or(f64::NAN)),
            max_isometric_stress: 1.0,
            activation: 0.0,
            optimal_stretch: set.number("lambda_ofl"),
        };
        let F: Mat<f64, 3> = case.F.matrix();
        let found = term.normalized_stretch(&law, &F);
        // |F a₀| moves by a rounding of F; J^(−1/3) by a third of what J does.
        let size = norm(&case.F.0);
        let volume =
            size.powi(3) / (3.0 * case.J.0.abs()) * f64::from(stretch == Stretch::Isochoric);
        let fiber = size * exact
            / F.mul_vec(term.direction)
                .iter()
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt();
        let unit = EPSILON * (exact + fiber + volume * exact);
        let error = (found - exact).abs() / unit;
        report.record(&group, "l", &case.cat, &case.id.to_string(), error, C);
    }
}
