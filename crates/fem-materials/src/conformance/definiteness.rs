//! Projected derivatives against the numeric projection of eigenvalues.

use super::Claim;
use super::report::{Property, Report};
use super::sample::Sample;
use super::size::{Norm, Sizes};
use crate::{HessianProjection, Material};
use fem_kinematics::{Tensor4, jacobi_eigen};

pub(super) fn check<const D: usize, M: Material<D>>(
    material: &M,
    sample: &Sample<D>,
    claims: &[Claim],
    report: &mut Report,
) {
    let F = &sample.F;
    if !material.energy(F).is_finite() {
        return;
    }
    let size = Sizes::at(material, F).derivative;
    let tensor = material.stress_derivative(F);
    for projection in [
        HessianProjection::None,
        HessianProjection::Clamp,
        HessianProjection::Absolute,
    ] {
        let projected = material.projected_derivative(F, projection);
        let by_terms = claims.contains(&Claim::ProjectedByTerms);
        if projection == HessianProjection::None || !by_terms {
            let numeric = projection.apply(&tensor);
            let apart = (projected + numeric.scale(-1.0)).norm();
            report.record(Property::ProjectionIsNumeric, apart / size, F);
        }
        if projection != HessianProjection::None {
            let stiffer = projected + tensor.scale(-1.0);
            let size = size + projected.norm();
            for negative in [most_negative(&projected), most_negative(&stiffer)] {
                report.record(Property::ProjectedIsDefinite, negative / size, F);
            }
        }
    }
}

/// Minus the smallest eigenvalue, or 0 if that is positive.
fn most_negative<const D: usize>(tensor: &Tensor4<f64, D>) -> f64 {
    fn of<const N: usize>(rows: impl Fn(usize, usize) -> f64, size: f64) -> f64 {
        let half = 0.5 / size;
        let A: [[f64; N]; N] =
            core::array::from_fn(|i| core::array::from_fn(|j| half * (rows(i, j) + rows(j, i))));
        let (values, _) = jacobi_eigen(&A);
        size * values.into_iter().fold(0.0, |worst: f64, v| worst.max(-v))
    }
    let size = tensor.norm();
    if size == 0.0 {
        return 0.0;
    }
    let entry = |a: usize, b: usize| tensor.get(a / D, a % D, b / D, b % D);
    if D == 2 {
        of::<4>(entry, size)
    } else {
        of::<9>(entry, size)
    }
}
