//! Linear elasticity (document 002).

use crate::lame::Lame;
use crate::material::{Material, Symmetry};
use crate::registry::{Entry, Parameter, Register, lame_itself};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = μ |e|² + λ/2 (tr e)², e = (F + Fᵀ)/2 − I.
///
/// The only model with a constant stiffness, and the only one that takes a rotation for a
/// strain: for small displacements alone. Defined for every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

impl From<Lame> for Linear {
    fn from(Lame { mu, lambda }: Lame) -> Self {
        Self { mu, lambda }
    }
}

/// μ and λ, as Lamé's.
pub(crate) const LAME: [Parameter; 2] = [
    Parameter::pascals("mu", "1e5", "shear modulus"),
    Parameter::pascals("lambda", "4e5", "first Lamé parameter"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    let entry = Entry {
        name: "linear",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "small displacements, a first test; one factorization solves every load",
        domain: "all F",
        parameters: &LAME,
        from_parameters: |p| {
            Ok(Linear {
                mu: p.non_negative("mu")?,
                lambda: p.number("lambda")?,
            })
        },
    };
    visitor.plane(&entry);
    visitor.solid(&entry);
}

impl Linear {
    /// 2μ e + λ tr(e) I.
    #[inline(always)]
    fn law<T: Real, const D: usize>(&self, e: &Mat<T, D>) -> Mat<T, D> {
        let pressure = T::from_f64(self.lambda) * e.trace();
        e.scale(T::from_f64(2.0 * self.mu)) + Mat::from_diagonal([pressure; D])
    }
}

impl<const D: usize> Material<D> for Linear {
    // Not isotropic in the sense of the trait: ψ(F R) differs from ψ(F).
    const SYMMETRY: Symmetry = Symmetry::Anisotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>) -> T {
        let e = (*F - Mat::identity()).symmetric_part();
        let trace = e.trace();
        T::from_f64(self.mu) * e.norm_squared() + T::from_f64(0.5 * self.lambda) * trace * trace
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        self.law(&(*F - Mat::identity()).symmetric_part())
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, _F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        self.law(&dF.symmetric_part())
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, _F: &Mat<T, D>) -> Tensor4<T, D> {
        let (mu, I) = (T::from_f64(self.mu), Mat::identity());
        Terms::new()
            .identity(mu)
            .transposed(mu, &I, &I)
            .outer(T::from_f64(self.lambda), &I, &I)
            .0
    }
}
