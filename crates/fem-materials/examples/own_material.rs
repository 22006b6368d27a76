//! A material of your own in one file: the formulas once, for any scalar, and the two lines that
//! prove them. Run with `cargo run --example own_material --features conformance`.
#![allow(non_snake_case)]

use fem_kinematics::{Mat, Real};
use fem_materials::{Material, conformance};

/// A hyperelastic foam (Blatz and Ko 1962 with β = 1), finite only for J = det F > 0:
/// ψ = μ/2 (|F|² − D + 2 (1/J − 1)).
#[derive(Clone, Copy, Debug)]
struct Foam {
    /// Shear modulus μ, Pa.
    mu: f64,
}

impl<const D: usize> Material<D> for Foam {
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let J = F.determinant();
        let psi = T::from_f64(0.5 * self.mu)
            * (F.norm_squared() - T::from_f64(D as f64)
                + T::from_f64(2.0) * (J.recip() - T::one()));
        T::select(T::zero().lt(J), psi, T::from_f64(f64::INFINITY))
    }

    // ∂J/∂F = cof F, so P = μ (F − cof F / J²)
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let mu = T::from_f64(self.mu);
        F.scale(mu) - F.cofactor().scale(mu / F.determinant().squared())
    }

    // dP = μ (dF − d(cof F)/J² + 2 cof F (cof F : dF)/J³)
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let (mu, J, cof) = (T::from_f64(self.mu), F.determinant(), F.cofactor());
        let push = T::from_f64(2.0) * mu * cof.dot(dF) / (J * J * J);
        dF.scale(mu) - F.cofactor_differential(dF).scale(mu / (J * J)) + cof.scale(push)
    }
}

fn main() {
    let foam = Foam { mu: 2.0e4 };
    conformance::check::<2, _>(&foam).assert();
    let report = conformance::check::<3, _>(&foam);
    report.assert();
    println!("{report}");
}
