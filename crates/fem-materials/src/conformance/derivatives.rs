//! Exact derivatives by dual numbers, and central differences as the second witness.

use super::report::{Property, Report};
use super::sample::{Kind, Sample};
use super::size::{Norm, Sizes, norm};
use crate::Material;
use fem_kinematics::{Dual, Mat, Tensor4};

/// F + ε dF.
fn along<const D: usize>(F: &Mat<f64, D>, dF: &Mat<f64, D>) -> Mat<Dual<f64>, D> {
    Mat::from_fn(|i, j| Dual::new(F[(i, j)], dF[(i, j)]))
}

/// The D² unit directions.
fn directions<const D: usize>() -> impl Iterator<Item = (usize, usize, Mat<f64, D>)> {
    (0..D * D).map(|n| (n / D, n % D, Mat::unit(n / D, n % D)))
}

pub(super) fn check<const D: usize, M: Material<D>>(
    material: &M,
    sample: &Sample<D>,
    report: &mut Report,
) {
    let F = &sample.F;
    if !material.energy(F).is_finite() {
        return;
    }
    let size = Sizes::at(material, F);
    let P = material.stress(F);
    let tensor = material.stress_derivative(F);

    let from_differential = Tensor4::from_linear_map(|dF| material.stress_differential(F, dF));
    let apart = (tensor + from_differential.scale(-1.0)).norm();
    report.record(
        Property::DerivativeIsDifferential,
        apart / size.derivative,
        F,
    );
    let transposed = Tensor4::from_fn(|i, j, k, l| tensor.get(k, l, i, j));
    let skew = (tensor + transposed.scale(-1.0)).norm();
    report.record(Property::DerivativeIsSymmetric, skew / size.derivative, F);

    // Where singular values coincide a decomposition has no derivative for a dual number to
    // carry; the closed forms do, and the differences below test them.
    if sample.kind != Kind::Repeated {
        let mut gradient = Mat::zeros();
        let mut worst: f64 = 0.0;
        for (i, j, dF) in directions() {
            let moved = along(F, &dF);
            gradient[(i, j)] = material.energy(&moved).derivative;
            let dP = material.stress(&moved);
            let exact = Mat::from_fn(|a, b| dP[(a, b)].derivative);
            let error = norm(&(material.stress_differential(F, &dF) - exact));
            worst = if error <= worst { worst } else { error };
        }
        report.record(
            Property::StressIsEnergyGradient,
            norm(&(P - gradient)) / size.stress,
            F,
        );
        report.record(
            Property::DifferentialIsStressDerivative,
            worst / size.derivative,
            F,
        );
    }
    differences(material, F, &size, report);
}

/// Fourth-order central differences over a ladder of steps; the best step counts, because the
/// large ones carry truncation (or a kink of a muscle curve) and the small ones rounding.
fn differences<const D: usize, M: Material<D>>(
    material: &M,
    F: &Mat<f64, D>,
    size: &Sizes,
    report: &mut Report,
) {
    let (P, tensor) = (material.stress(F), material.stress_derivative(F));
    let (mut best_stress, mut best_derivative) = (f64::INFINITY, f64::INFINITY);
    for step in [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6] {
        let mut gradient = Mat::zeros();
        let mut hessian = Tensor4::zeros();
        for (k, l, dF) in directions() {
            for (weight, at) in [(8.0, 1.0), (-8.0, -1.0), (-1.0, 2.0), (1.0, -2.0)] {
                let moved = *F + dF.scale(step * at);
                let factor = weight / (12.0 * step);
                gradient[(k, l)] += factor * material.energy(&moved);
                let P = material.stress(&moved);
                for i in 0..D {
                    for j in 0..D {
                        *hessian.entry_mut(i, j, k, l) += factor * P[(i, j)];
                    }
                }
            }
        }
        best_stress = best_stress.min(norm(&(P - gradient)) / size.stress);
        best_derivative =
            best_derivative.min((tensor + hessian.scale(-1.0)).norm() / size.derivative);
    }
    report.record(Property::StressByDifferences, best_stress, F);
    report.record(Property::DerivativeByDifferences, best_derivative, F);
}
