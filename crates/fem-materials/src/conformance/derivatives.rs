//! Exact derivatives by dual numbers, and central differences as the second witness.

use super::report::{Property, Report, worse};
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

/// Directions of the differences over a whole run.
#[derive(Default)]
pub(super) struct Directions {
    all: usize,
    /// Left out for a kink, of which the material's own derivative is the only witness.
    skipped: usize,
}

impl Directions {
    /// The share left out becomes a finding: noise looks like a kink, but is everywhere.
    pub(super) fn record<const D: usize>(&self, report: &mut Report) {
        if self.all > 0 {
            let share = self.skipped as f64 / self.all as f64;
            report.record(
                Property::DifferencesLeftOut,
                share,
                &Mat::<f64, D>::identity(),
            );
        }
    }
}

pub(super) fn check<const D: usize, M: Material<D>>(
    material: &M,
    sample: &Sample<D>,
    count: &mut Directions,
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
            worst = worse(worst, error);
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
    differences(material, F, &size, count, report);
}

/// Steps of the differences. Large ones carry truncation, small ones rounding.
const LADDER: [f64; 8] = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6, 2e-7];
/// The step within which a kink spoils every difference.
const NEAREST: f64 = 1e-6;

/// Fourth-order central differences over a ladder of steps; in each direction the best step counts.
fn differences<const D: usize, M: Material<D>>(
    material: &M,
    F: &Mat<f64, D>,
    size: &Sizes,
    count: &mut Directions,
    report: &mut Report,
) {
    let (P, tensor) = (material.stress(F), material.stress_derivative(F));
    let (mut of_stress, mut of_derivative) = (0.0, 0.0);
    for (k, l, dF) in directions() {
        let exact = Mat::from_fn(|i, j| tensor.get(i, j, k, l));
        let (mut best_slope, mut best_change) = (f64::INFINITY, f64::INFINITY);
        for step in LADDER {
            let (mut slope, mut change) = (0.0, Mat::zeros());
            for (weight, at) in [(8.0, 1.0), (-8.0, -1.0), (-1.0, 2.0), (1.0, -2.0)] {
                let moved = *F + dF.scale(step * at);
                let factor = weight / (12.0 * step);
                slope += factor * material.energy(&moved);
                change += material.stress(&moved).scale(factor);
            }
            best_slope = best_slope.min((P[(k, l)] - slope).abs() / size.stress);
            best_change = best_change.min(norm(&(exact - change)) / size.derivative);
        }
        let tight = best_slope < 1e-9 && best_change < 1e-9;
        count.all += 1;
        if tight || !kinked(material, F, &dF, size) {
            of_stress += best_slope * best_slope;
            of_derivative += best_change * best_change;
        } else {
            count.skipped += 1;
        }
    }
    report.record(Property::StressByDifferences, of_stress.sqrt(), F);
    report.record(Property::DerivativeByDifferences, of_derivative.sqrt(), F);
}

/// Does the second derivative bend within the smallest stencil, as a muscle curve does where its
/// pieces meet, or damage where tension turns to compression? Its second differences then are far
/// above h².
fn kinked<const D: usize, M: Material<D>>(
    material: &M,
    F: &Mat<f64, D>,
    dF: &Mat<f64, D>,
    size: &Sizes,
) -> bool {
    let at = |n: f64| material.stress_derivative(&(*F + dF.scale(n * NEAREST)));
    let along: [Tensor4<f64, D>; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(at);
    along.windows(3).any(|w| {
        let bend = (w[0] + w[1].scale(-2.0) + w[2]).norm();
        bend > 1e-9 * size.derivative
    })
}
