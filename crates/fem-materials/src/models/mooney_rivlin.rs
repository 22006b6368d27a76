//! Isochoric Mooney-Rivlin elasticity (document 000, 4.2, 4.3.1, 4.5.1.2, 4.5.1.3).

use crate::material::{Material, Symmetry};
use crate::near_rest::{infinite_unless_positive, inverse_cube_root};
use crate::registry::{Entry, Parameter, Register};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// ψ = A I₁ + B I₂ with I₁ = J^(−2/3) tr C and I₂ = J^(−4/3) ((tr C)² − tr C²)/2, C = FᵀF.
///
/// Feels no change of volume, so add a volume term such as [`VolumetricLog`](super::VolumetricLog);
/// with that one the Lamé parameters at rest are μ = 2(A + B), λ = K − 4/3 (A + B). The rest state
/// has the energy 3A + 3B. Finite only for J > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlin {
    /// A (μ₁₀ in PhysBAM), Pa.
    pub A: f64,
    /// B (μ₀₁ in PhysBAM), Pa.
    pub B: f64,
}

const PARAMETERS: [Parameter; 2] = [
    Parameter::pascals("A", "6e4", "coefficient of I1"),
    Parameter::pascals("B", "2e4", "coefficient of I2"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "mooney_rivlin_isochoric",
        aliases: &["mooney_rivlin_dev"],
        elastic: None,
        about: "rubber and flesh beyond neo-Hookean, to be added to a volume term (document 000)",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            Ok(MooneyRivlin {
                A: p.number("A")?,
                B: p.number("B")?,
            })
        },
    });
}

/// What every derivative needs.
struct Parts<T> {
    /// F⁻ᵀ.
    H: Mat<T, 3>,
    /// C = FᵀF.
    C: Mat<T, 3>,
    /// ∂/∂F of ((tr C)² − tr C²)/2 is 2M, M = tr C F − F C.
    M: Mat<T, 3>,
    /// tr C.
    I: T,
    /// ((tr C)² − tr C²)/2.
    K2: T,
    /// A J^(−2/3).
    a: T,
    /// B J^(−4/3).
    b: T,
}

impl MooneyRivlin {
    #[inline(always)]
    fn parts<T: Real>(&self, F: &Mat<T, 3>) -> Parts<T> {
        let C = F.tr_mul(F);
        let J = F.determinant();
        let shrink = inverse_cube_root(J).squared();
        let I = C.trace();
        // Sum of the principal minors: the same number without the difference of two squares.
        let c = &C.0;
        let minor = |i: usize, j: usize| c[i][i] * c[j][j] - c[i][j] * c[j][i];
        Parts {
            H: F.cofactor().scale(J.recip()),
            M: F.scale(I) - *F * C,
            K2: minor(0, 1) + minor(0, 2) + minor(1, 2),
            a: T::from_f64(self.A) * shrink,
            b: T::from_f64(self.B) * shrink * shrink,
            C,
            I,
        }
    }
}

impl Material<3> for MooneyRivlin {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let p = self.parts(F);
        infinite_unless_positive(F.determinant(), p.a * p.I + p.b * p.K2)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let p = self.parts(F);
        let two = T::from_f64(2.0);
        let (s, t) = (T::from_f64(2.0 / 3.0), T::from_f64(4.0 / 3.0));
        F.scale(two * p.a) + p.M.scale(two * p.b) - p.H.scale(s * p.a * p.I + t * p.b * p.K2)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let p = self.parts(F);
        let (N, q, pressure) = p.volume_coupling(F);
        let (two, four) = (T::from_f64(2.0), T::from_f64(4.0));
        let hd = p.H.dot(dF);
        let linear = dF.scale(two * (p.a + p.b * p.I))
            - (*dF * p.C + *F * dF.tr_mul(F) + F.mul_tr(F) * *dF).scale(two * p.b)
            + (p.H * dF.tr_mul(&p.H)).scale(pressure);
        linear - N.scale(hd) + p.H.scale(q * hd - N.dot(dF)) + F.scale(four * p.b * F.dot(dF))
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        let p = self.parts(F);
        let (N, q, pressure) = p.volume_coupling(F);
        let (two, four) = (T::from_f64(2.0), T::from_f64(4.0));
        // q H (H:dF) − N (H:dF) − H (N:dF) = (q H − N) (H:dF) − H (N:dF)
        Terms::new()
            .identity(two * (p.a + p.b * p.I))
            .right(&p.C.scale(-two * p.b))
            .left(&F.mul_tr(F).scale(-two * p.b))
            .transposed(-two * p.b, F, F)
            .transposed(pressure, &p.H, &p.H)
            .outer(four * p.b, F, F)
            .outer(T::one(), &(p.H.scale(q) - N), &p.H)
            .outer(-T::one(), &p.H, &N)
            .0
    }
}

impl<T: Real> Parts<T> {
    /// N, q and p in dP ∋ −N (H:dF) − H (N:dF) + q H (H:dF) + p H dFᵀ H.
    #[inline(always)]
    fn volume_coupling(&self, F: &Mat<T, 3>) -> (Mat<T, 3>, T, T) {
        let f = T::from_f64;
        let N = F.scale(f(4.0 / 3.0) * self.a) + self.M.scale(f(8.0 / 3.0) * self.b);
        let q = f(4.0 / 9.0) * self.a * self.I + f(16.0 / 9.0) * self.b * self.K2;
        let pressure = f(2.0 / 3.0) * self.a * self.I + f(4.0 / 3.0) * self.b * self.K2;
        (N, q, pressure)
    }
}
