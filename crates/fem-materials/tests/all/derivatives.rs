//! Every registered model: P is the derivative of ψ and dP that of P, by dual numbers.
use crate::numbers::{Numbers, dual, norm};
use fem_kinematics::{F64x8, Mat};
use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
use fem_materials::{HessianProjection, Material, Outlined};

struct Check;

impl ModelVisitor for Check {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        let model = Outlined(entry.build(&entry.defaults()).expect(entry.name));
        let mut numbers = Numbers(0x9e37_79b9_7f4a_7c15);
        let rest = Mat::<f64, D>::identity();
        let scale = norm(&model.stress_derivative(&rest).apply(&rest)) + model.energy(&rest).abs();
        for case in 0..24 {
            let size = [0.01, 0.2, 0.5, 1.5][case % 4];
            let F = rest + numbers.matrix::<D>().scale(size);
            let dF = numbers.matrix::<D>();
            if !model.energy(&F).is_finite() {
                continue;
            }
            let name = entry.name;
            let tolerance = 1e-11;
            let P = model.stress(&F);
            let slope = model.energy(&dual(&F, &dF)).derivative;
            let floor = norm(&P) + scale;
            assert!(
                (P.dot(&dF) - slope).abs() <= tolerance * floor,
                "{name} {D}D: P:dF = {}, dψ = {slope} at {F:?}",
                P.dot(&dF)
            );
            let dP = model.stress_differential(&F, &dF);
            let by_dual = model.stress(&dual(&F, &dF));
            let by_dual = Mat::from_fn(|i, j| by_dual.0[i][j].derivative);
            let floor = norm(&dP) + scale;
            assert!(
                norm(&(dP - by_dual)) <= tolerance * floor,
                "{name} {D}D: dP = {dP:?}, by dual numbers {by_dual:?} at {F:?}"
            );
            let tensor = model.stress_derivative(&F);
            assert!(
                norm(&(tensor.apply(&dF) - dP)) <= tolerance * floor,
                "{name} {D}D: stress_derivative is not stress_differential at {F:?}"
            );
            // Where there are no registers the one stands for the other, to the last bit.
            let exact = model.projected_derivative(&F, HessianProjection::None);
            assert_eq!(exact, tensor, "{name} {D}D: a projection that is none");
            let other = numbers.matrix::<D>();
            let symmetric = (other.dot(&dP) - dF.dot(&tensor.apply(&other))).abs();
            assert!(
                symmetric <= 10.0 * tolerance * floor,
                "{name} {D}D: not symmetric"
            );
            let (energy, stress) = model.energy_and_stress(&F);
            assert!(
                (energy - model.energy(&F)).abs() <= 1e-13 * (energy.abs() + scale),
                "{name}"
            );
            assert!(norm(&(stress - P)) <= 1e-13 * (norm(&P) + scale), "{name}");
            for projection in [HessianProjection::Clamp, HessianProjection::Absolute] {
                let all = model.evaluate(&F, projection);
                let work = dF.dot(&all.derivative.apply(&dF));
                assert!(
                    work >= -1e-9 * floor,
                    "{name} {D}D: {projection:?} left {work} at {F:?}"
                );
            }
            let lanes = Mat::<F64x8, D>::from_f64(&F);
            let P8 = model.stress(&lanes);
            for i in 0..D {
                for j in 0..D {
                    assert!(
                        (P8.0[i][j].0[5] - P.0[i][j]).abs() <= 1e-13 * (norm(&P) + scale),
                        "{name} {D}D: lanes"
                    );
                }
            }
            let F32 = Mat::<f32, D>::from_fn(|i, j| F.0[i][j] as f32);
            let single = f64::from(model.energy(&F32));
            assert!(
                (single - energy).abs()
                    <= 1e-4 * (energy.abs() + scale) * F.norm_squared().max(1.0),
                "{name} {D}D: f32 {single} against {energy}"
            );
        }
    }
}

#[test]
fn every_model_agrees_with_dual_numbers() {
    for_each_model(&mut Check);
}

struct Rotations;

impl ModelVisitor for Rotations {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        let model = Outlined(entry.build(&entry.defaults()).expect(entry.name));
        let mut numbers = Numbers(77);
        let (s, c) = 0.7_f64.sin_cos();
        let mut R = Mat::<f64, D>::identity();
        R.0[0][0] = c;
        R.0[0][1] = -s;
        R.0[1][0] = s;
        R.0[1][1] = c;
        for _ in 0..8 {
            let F = Mat::identity() + numbers.matrix::<D>().scale(0.3);
            let (psi, turned) = (model.energy(&F), model.energy(&(R * F)));
            if psi.is_finite() && entry.name != "linear" {
                let P = model.stress(&F);
                assert!(
                    (psi - turned).abs() <= 1e-10 * (norm(&P) + psi.abs()),
                    "{}",
                    entry.name
                );
                let difference = model.stress(&(R * F)) - R * P;
                let stiff = norm(&model.stress_differential(&F, &Mat::identity()));
                assert!(
                    norm(&difference) <= 1e-11 * (norm(&P) + stiff),
                    "{}",
                    entry.name
                );
            }
        }
    }
}

#[test]
fn every_model_but_linear_ignores_rotations_of_the_world() {
    for_each_model(&mut Rotations);
}
