//! What every registered model owes at any F: the rotations are nalgebra's, the inputs proptest's.

use approx::assert_relative_eq;
use fem_kinematics::Mat;
use fem_materials::registry::{Entry, SolidVisitor, for_each_solid};
use fem_materials::{Material, Symmetry};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

type Gradient = Mat<f64, 3>;

fn plain(m: Matrix3<f64>) -> Gradient {
    m.into()
}

fn size(m: &Gradient) -> f64 {
    m.norm_squared().sqrt()
}

/// Equal to 1e-9 of their size or of `unit`, pascals.
fn same(a: &Gradient, b: &Gradient, unit: f64, what: &str) {
    let apart = size(&(*a - *b));
    assert!(apart <= 1e-9 * (unit + size(b)), "{what}: {apart:e}");
}

/// A gradient, two directions and a rotation.
struct Trial {
    F: Gradient,
    directions: [Gradient; 2],
    Q: Gradient,
}

impl SolidVisitor for Trial {
    fn visit<M: Material<3> + 'static>(&mut self, entry: &Entry<M>) {
        let (F, Q, name) = (&self.F, self.Q, entry.name);
        let model = entry.build(&entry.defaults()).expect(name);
        let (energy, P) = (model.energy(F), model.stress(F));
        let [A, B] = self.directions;
        let of = |F: &Gradient, dF: &Gradient| model.stress_differential(F, dF);
        let (along_a, along_b) = (of(F, &A), of(F, &B));
        let unit = size(&along_a) + size(&along_b);
        // dP/dF is a second derivative: it is symmetric.
        let (ab, ba) = (along_a.dot(&B), along_b.dot(&A));
        assert_relative_eq!(ab, ba, epsilon = 1e-9 * unit, max_relative = 1e-9);
        // The rest shape may turn where the material has no direction. Stated with the world it holds
        // for linear elasticity too.
        if M::SYMMETRY == Symmetry::Isotropic {
            let turned = model.stress(&(Q * F.mul_tr(&Q)));
            same(&turned, &(Q * P.mul_tr(&Q)), unit, name);
        }
        // The small strains of linear elasticity see a rotation of the world.
        if name != "linear" {
            let turned = Q * *F;
            let again = model.energy(&turned);
            assert_relative_eq!(again, energy, epsilon = 1e-9 * unit, max_relative = 1e-9);
            same(&model.stress(&turned), &(Q * P), unit, name);
            same(&of(&turned, &(Q * A)), &(Q * along_a), unit, name);
            // No torque without a couple: P Fᵀ is symmetric.
            let tau = P.mul_tr(F);
            same(&tau, &tau.transpose(), unit, name);
        }
    }
}

fn entries() -> impl Strategy<Value = Matrix3<f64>> {
    prop::array::uniform9(-1.0..1.0).prop_map(|v: [f64; 9]| Matrix3::from_row_slice(&v))
}

fn rotation() -> impl Strategy<Value = Rotation3<f64>> {
    prop::array::uniform3(-3.0..3.0).prop_map(|v: [f64; 3]| Rotation3::new(Vector3::from(v)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn models_are_objective_balanced_and_symmetric(
        (strain, a, b) in (entries(), entries(), entries()),
        (turned, Q) in (rotation(), rotation()),
    ) {
        let mut trial = Trial {
            F: plain(turned.matrix() * (Matrix3::identity() + 0.2 * strain)),
            directions: [a, b].map(plain),
            Q: plain(*Q.matrix()),
        };
        for_each_solid(&mut trial);
    }
}
