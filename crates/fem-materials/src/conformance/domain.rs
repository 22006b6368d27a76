//! Rest, collapse, inversion and NaN.

use super::random::Random;
use super::report::{Property, Report, zero_if};
use super::size::{Sizes, norm};
use crate::Material;
use fem_kinematics::Mat;

/// P(I) = 0.
pub(super) fn rest<const D: usize, M: Material<D>>(material: &M, report: &mut Report) {
    let I = Mat::identity();
    let error = norm(&material.stress(&I)) / Sizes::at(material, &I).stress;
    report.record(Property::RestIsStressFree, error, &I);
}

/// Deformations at the edge of what makes sense: flat, collapsed to a line or a point, inverted,
/// very large and very small.
fn extremes<const D: usize>(random: &mut Random) -> Vec<Mat<f64, D>> {
    let mut all = vec![Mat::zeros(), Mat::unit(0, 0), Mat::unit(D - 1, 0)];
    let flat = Mat::from_fn(|i, j| if i == j && i + 1 < D { 1.0 } else { 0.0 });
    let mirror = Mat::from_fn(|i, j| match (i == j, i + 1 == D) {
        (true, true) => -1.0,
        (true, false) => 1.0,
        _ => 0.0,
    });
    all.extend([flat, mirror]);
    for size in [1e-6, 1.0, 1e4] {
        all.push(random.rotation().scale(size));
        all.push(random.rotation() * mirror.scale(size));
        let (u, v) = (random.matrix::<D>().0[0], random.matrix::<D>().0[0]);
        all.push(Mat::outer(u, v).scale(size));
    }
    all
}

/// No NaN from a real F, and no finite energy from a NaN.
pub(super) fn extreme<const D: usize, M: Material<D>>(
    material: &M,
    random: &mut Random,
    report: &mut Report,
) {
    for F in extremes(random) {
        let energy = material.energy(&F);
        let well = if energy.is_finite() {
            material
                .stress(&F)
                .0
                .iter()
                .flatten()
                .all(|p| p.is_finite())
        } else {
            energy == f64::INFINITY
        };
        report.record(Property::NeverNan, zero_if(well), &F);
    }
    for i in 0..D {
        for j in 0..D {
            let mut F = Mat::identity();
            F[(i, j)] = f64::NAN;
            let hidden = material.energy(&F).is_finite();
            report.record(Property::NanIsNotHidden, zero_if(!hidden), &F);
        }
    }
}

/// ψ = +∞ for det F ≤ 0.
pub(super) fn positive_determinant<const D: usize, M: Material<D>>(
    material: &M,
    random: &mut Random,
    report: &mut Report,
) {
    for F in extremes(random).iter().filter(|F| F.determinant() <= 0.0) {
        let infinite = material.energy(F) == f64::INFINITY;
        report.record(Property::InfiniteOutsideDomain, zero_if(infinite), F);
    }
}
