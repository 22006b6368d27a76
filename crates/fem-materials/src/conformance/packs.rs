//! One source for every scalar: lanes and single precision against `f64`.

use super::report::{Property, Report, zero_if};
use super::sample::Sample;
use super::size::{Norm, Sizes, norm};
use crate::Material;
use fem_kinematics::{F64x8, Lanes, Mat, Tensor4};

/// Eight deformation gradients side by side.
fn pack<const D: usize>(eight: &[Mat<f64, D>; 8]) -> Mat<F64x8, D> {
    Mat::from_fn(|i, j| Lanes(core::array::from_fn(|n| eight[n][(i, j)])))
}

fn lane<const D: usize>(m: &Mat<F64x8, D>, n: usize) -> Mat<f64, D> {
    Mat::from_fn(|i, j| m[(i, j)].0[n])
}

fn lane_of_tensor<const D: usize>(t: &Tensor4<F64x8, D>, n: usize) -> Tensor4<f64, D> {
    Tensor4::from_fn(|i, j, k, l| t.get(i, j, k, l).0[n])
}

/// Every lane against the scalar, and a spoilt lane against its neighbors.
pub(super) fn lanes<const D: usize, M: Material<D>>(
    material: &M,
    samples: &[Sample<D>],
    report: &mut Report,
) {
    for chunk in samples.chunks(8) {
        let eight = core::array::from_fn(|n| chunk[n % chunk.len()].F);
        let packed = pack(&eight);
        let energy = material.energy(&packed);
        let stress = material.stress(&packed);
        let tensor = material.stress_derivative(&packed);
        for n in 0..chunk.len() {
            let F = &eight[n];
            let alone = material.energy(F);
            if !alone.is_finite() {
                report.record(Property::LanesAgree, zero_if(energy.0[n] == alone), F);
                continue;
            }
            let size = Sizes::at(material, F);
            let in_stress = norm(&(lane(&stress, n) - material.stress(F)));
            let in_tensor =
                (lane_of_tensor(&tensor, n) + material.stress_derivative(F).scale(-1.0)).norm();
            let p = Property::LanesAgree;
            report.record(p, (energy.0[n] - alone).abs() / size.energy, F);
            report.record(p, in_stress / size.stress, F);
            report.record(p, in_tensor / size.derivative, F);
        }
        for spoiler in [Mat::zeros(), Mat::identity().scale(f64::NAN)] {
            let mut spoilt = eight;
            spoilt[5] = spoiler;
            let packed = pack(&spoilt);
            let (again, P) = (material.energy(&packed), material.stress(&packed));
            for n in (0..chunk.len()).filter(|&n| n != 5 && energy.0[n].is_finite()) {
                let same = again.0[n].to_bits() == energy.0[n].to_bits()
                    && lane(&P, n) == lane(&stress, n);
                report.record(Property::LanesAreIndependent, zero_if(same), &eight[n]);
            }
        }
    }
}

/// `f32` at a deformation that both precisions represent exactly.
pub(super) fn single<const D: usize, M: Material<D>>(
    material: &M,
    sample: &Sample<D>,
    report: &mut Report,
) {
    let short = Mat::from_fn(|i, j| sample.F[(i, j)] as f32);
    let F = Mat::from_fn(|i, j| f64::from(short[(i, j)]));
    let energy = material.energy(&F);
    if !energy.is_finite() {
        return;
    }
    let size = Sizes::at(material, &F);
    // An exponential of a large stretch has a value in `f64` that no `f32` can hold.
    let largest = size.energy.max(size.stress).max(size.derivative);
    if !(largest < 1e-3 * f64::from(f32::MAX)) {
        return;
    }
    let wide = |m: Mat<f32, D>| Mat::from_fn(|i, j| f64::from(m[(i, j)]));
    let in_energy = (f64::from(material.energy(&short)) - energy).abs();
    let in_stress = norm(&(wide(material.stress(&short)) - material.stress(&F)));
    let tensor = material.stress_derivative(&short);
    let in_tensor = (Tensor4::from_fn(|i, j, k, l| f64::from(tensor.get(i, j, k, l)))
        + material.stress_derivative(&F).scale(-1.0))
    .norm();
    let p = Property::SingleAgrees;
    report.record(p, in_energy / size.energy, &F);
    report.record(p, in_stress / size.stress, &F);
    report.record(p, in_tensor / size.derivative, &F);
}
