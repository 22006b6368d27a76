//! Rotations of the world and of the material.

use super::random::Random;
use super::report::{Property, Report};
use super::sample::Sample;
use super::size::{Sizes, norm};
use crate::Material;

/// ψ(QF) = ψ(F), P(QF) = Q P(F).
pub(super) fn objectivity<const D: usize, M: Material<D>>(
    material: &M,
    sample: &Sample<D>,
    random: &mut Random,
    report: &mut Report,
) {
    let (F, Q) = (&sample.F, random.rotation());
    let energy = material.energy(F);
    if !energy.is_finite() {
        return;
    }
    let size = Sizes::at(material, F);
    let turned = Q * *F;
    let in_energy = (material.energy(&turned) - energy).abs() / size.energy;
    let in_stress = norm(&(material.stress(&turned) - Q * material.stress(F))) / size.stress;
    report.record(Property::Objectivity, in_energy, F);
    report.record(Property::Objectivity, in_stress, F);
}

/// ψ(QFQᵀ) = ψ(F), P(QFQᵀ) = Q P(F) Qᵀ. For an objective material this is the invariance under
/// rotations of the material alone; stated with both it holds for linear elasticity as well.
pub(super) fn isotropy<const D: usize, M: Material<D>>(
    material: &M,
    sample: &Sample<D>,
    random: &mut Random,
    report: &mut Report,
) {
    let (F, Q) = (&sample.F, random.rotation());
    let energy = material.energy(F);
    if !energy.is_finite() {
        return;
    }
    let size = Sizes::at(material, F);
    let turned = Q * F.mul_tr(&Q);
    let in_energy = (material.energy(&turned) - energy).abs() / size.energy;
    let expected = Q * material.stress(F).mul_tr(&Q);
    let in_stress = norm(&(material.stress(&turned) - expected)) / size.stress;
    report.record(Property::Isotropy, in_energy, F);
    report.record(Property::Isotropy, in_stress, F);
}
