//! The nearly incompressible block of SPP 1748 (Schröder et al. 2021): a quarter of it, in mm and MPa.
#![allow(non_snake_case)]

use fem_assembly::{AssemblyError, Dofs};
use fem_kinematics::{Mat, Real};
use fem_materials::Material;

/// µ, MPa.
pub const MU: f64 = 1.61148;
/// λ, MPa.
pub const LAMBDA: f64 = 499.92568;
/// On [25, 50]² of the top, MPa.
pub const PRESSURE: f64 = 3.0;
/// Of the quarter, mm.
pub const SIZE: f64 = 50.0;

/// µ/2 (I₁ − 3 − 2 ln J) + λ/2 (J − 1)².
#[derive(Clone, Copy)]
pub struct Rubber {
    pub mu: f64,
    pub lambda: f64,
}

impl Material<3> for Rubber {
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let (mu, lambda) = (T::from_f64(0.5 * self.mu), T::from_f64(0.5 * self.lambda));
        let J = F.determinant();
        let shear = F.norm_squared() - T::from_f64(3.0) - T::from_f64(2.0) * J.ln();
        let energy = mu * shear + lambda * (J - T::one()) * (J - T::one());
        T::select(T::zero().lt(J), energy, T::from_f64(f64::INFINITY))
    }
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let J = F.determinant();
        F.scale(mu) + F.cofactor().scale(lambda * (J - T::one()) - mu * J.recip())
    }
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let (mu, lambda) = (T::from_f64(self.mu), T::from_f64(self.lambda));
        let (J, cof) = (F.determinant(), F.cofactor());
        let dJ = cof.dot(dF);
        let slope = lambda + mu * (J * J).recip();
        dF.scale(mu)
            + cof.scale(slope * dJ)
            + F.cofactor_differential(dF)
                .scale(lambda * (J - T::one()) - mu * J.recip())
    }
}

/// Bottom on rollers, top held sideways, two planes of symmetry.
pub fn dofs(nodes: &[[f64; 3]]) -> Result<Dofs<3>, AssemblyError> {
    let mut axes = Vec::new();
    for (n, &[x, y, z]) in nodes.iter().enumerate() {
        let top = z == SIZE;
        for (axis, prescribed) in [x == SIZE || top, y == SIZE || top, z == 0.0]
            .into_iter()
            .enumerate()
        {
            if prescribed {
                axes.push((n, axis));
            }
        }
    }
    Dofs::new(nodes, &[], &axes)
}
