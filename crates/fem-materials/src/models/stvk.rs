//! St. Venant-Kirchhoff elasticity (document 002).

use super::linear::LAME;
use crate::lame::Lame;
use crate::material::{Material, Symmetry};
use crate::near_rest::green_strain;
use crate::registry::{Entry, Register, lame_itself};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = μ |E|² + λ/2 (tr E)², E = (FᵀF − I)/2.
///
/// The cheapest model that knows rotations. It softens under compression and lets elements
/// collapse (below a stretch of 1/√3), so: moderate strains only. Defined for every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StVenantKirchhoff {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

impl From<Lame> for StVenantKirchhoff {
    fn from(Lame { mu, lambda }: Lame) -> Self {
        Self { mu, lambda }
    }
}

pub(crate) fn register(visitor: &mut impl Register) {
    let entry = Entry {
        name: "stvk",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "large rotations, moderate strain, no compression",
        domain: "all F",
        parameters: &LAME,
        from_parameters: |p| {
            Ok(StVenantKirchhoff {
                mu: p.non_negative("mu")?,
                lambda: p.number("lambda")?,
            })
        },
    };
    visitor.plane(&entry);
    visitor.solid(&entry);
}

impl StVenantKirchhoff {
    /// Second Piola-Kirchhoff stress S = 2μ E + λ tr(E) I.
    #[inline(always)]
    fn law<T: Real, const D: usize>(&self, E: &Mat<T, D>) -> Mat<T, D> {
        let pressure = T::from_f64(self.lambda) * E.trace();
        E.scale(T::from_f64(2.0 * self.mu)) + Mat::from_diagonal([pressure; D])
    }
}

impl<const D: usize> Material<D> for StVenantKirchhoff {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let E = green_strain(F);
        let trace = E.trace();
        T::from_f64(self.mu) * E.norm_squared() + T::from_f64(0.5 * self.lambda) * trace * trace
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        *F * self.law(&green_strain(F))
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let dE = F.tr_mul(dF).symmetric_part();
        *dF * self.law(&green_strain(F)) + *F * self.law(&dE)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let mu = T::from_f64(self.mu);
        // F 2μ dE = μ (F dFᵀ F + F Fᵀ dF), F λ tr(dE) = λ F (F : dF)
        Terms::new()
            .right(&self.law(&green_strain(F)))
            .left(&F.mul_tr(F).scale(mu))
            .transposed(mu, F, F)
            .outer(T::from_f64(self.lambda), F, F)
            .0
    }
}
