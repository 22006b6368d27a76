//! Energies W(i) of the isochoric first invariant i = J^(−2/3) tr C − 3, with a volume term.

use crate::material::{Material, Symmetry};
use crate::near_rest::{RestMeasures, infinite_unless_positive};
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4};

/// W(i), i = J^(−2/3) tr C − 3 ≥ 0.
pub trait FirstInvariantEnergy: Copy + Send + Sync {
    /// (W, W′, W″) at i, Pa; W = +∞ beyond the model's domain.
    fn energy_and_slopes<T: Real>(&self, i: T) -> [T; 3];
}

/// The volume term K/2 (ln J)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Bulk modulus K, Pa.
    pub K: f64,
}

impl Volume {
    /// K ln J.
    #[inline(always)]
    pub(crate) fn pressure<T: Real>(&self, log_J: T) -> T {
        T::from_f64(self.K) * log_J
    }
    /// K/2 (ln J)².
    #[inline(always)]
    pub(crate) fn energy<T: Real>(&self, log_J: T) -> T {
        T::from_f64(0.5 * self.K) * log_J * log_J
    }
}

/// ψ = W(J^(−2/3) tr C − 3) + K/2 (ln J)²; finite only for J > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstInvariant<W> {
    /// W.
    pub shape: W,
    /// K/2 (ln J)².
    pub volume: Volume,
}

/// i and what its derivatives need.
pub(crate) struct Isochoric<T: Real> {
    /// i = J^(−2/3) tr C − 3, without cancellation near rest.
    pub i: T,
    /// ∂i/∂F = 2 J^(−2/3) (F − tr C/3 F⁻ᵀ).
    pub gradient: Mat<T, 3>,
    /// J.
    pub J: T,
    /// ln J.
    pub log_J: T,
    /// F⁻ᵀ.
    pub H: Mat<T, 3>,
    /// J^(−2/3).
    shrink: T,
    /// tr C.
    trace: T,
}

impl<T: Real> Isochoric<T> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new(F: &Mat<T, 3>) -> Self {
        let f = T::from_f64;
        let rest = RestMeasures::new(F);
        let log_J = rest.log_J();
        let shrink_minus_1 = (f(-2.0 / 3.0) * log_J).exp_m1();
        let shrink = shrink_minus_1 + T::one();
        let trace = F.norm_squared();
        let H = F.cofactor().scale(rest.J.recip());
        Self {
            // J^(−2/3) (3 + 2 tr E) − 3
            i: f(3.0) * shrink_minus_1 + f(2.0) * shrink * rest.E.trace(),
            gradient: (*F - H.scale(f(1.0 / 3.0) * trace)).scale(f(2.0) * shrink),
            J: rest.J,
            log_J,
            H,
            shrink,
            trace,
        }
    }

    /// The change of the gradient for dF.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn gradient_differential(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let f = T::from_f64;
        let dH = self.H * dF.tr_mul(&self.H);
        self.gradient.scale(f(-2.0 / 3.0) * self.H.dot(dF))
            + (*dF - self.H.scale(f(2.0 / 3.0) * F.dot(dF)) + dH.scale(f(1.0 / 3.0) * self.trace))
                .scale(f(2.0) * self.shrink)
    }

    /// Adds s ∂²i/∂F² to `terms`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn add_hessian(&self, terms: Terms<T, 3>, s: T, F: &Mat<T, 3>) -> Terms<T, 3> {
        let f = T::from_f64;
        let c = f(2.0) * s * self.shrink;
        terms
            .identity(c)
            .transposed(f(1.0 / 3.0) * c * self.trace, &self.H, &self.H)
            .outer(f(-2.0 / 3.0) * c, &self.H, F)
            .outer(f(-2.0 / 3.0) * s, &self.gradient, &self.H)
    }
}

impl<W: FirstInvariantEnergy> Material<3> for FirstInvariant<W> {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let d = Isochoric::new(F);
        let [w, _, _] = self.shape.energy_and_slopes(d.i);
        infinite_unless_positive(d.J, w + self.volume.energy(d.log_J))
    }
    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let d = Isochoric::new(F);
        let [_, w1, _] = self.shape.energy_and_slopes(d.i);
        d.gradient.scale(w1) + d.H.scale(self.volume.pressure(d.log_J))
    }
    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let d = Isochoric::new(F);
        let [_, w1, w2] = self.shape.energy_and_slopes(d.i);
        let (K, p) = (T::from_f64(self.volume.K), self.volume.pressure(d.log_J));
        d.gradient.scale(w2 * d.gradient.dot(dF))
            + d.gradient_differential(F, dF).scale(w1)
            + d.H.scale(K * d.H.dot(dF))
            - (d.H * dF.tr_mul(&d.H)).scale(p)
    }
    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        let d = Isochoric::new(F);
        let [_, w1, w2] = self.shape.energy_and_slopes(d.i);
        let terms = Terms::new()
            .outer(w2, &d.gradient, &d.gradient)
            .outer(T::from_f64(self.volume.K), &d.H, &d.H)
            .transposed(-self.volume.pressure(d.log_J), &d.H, &d.H);
        d.add_hessian(terms, w1, F).0
    }
}
