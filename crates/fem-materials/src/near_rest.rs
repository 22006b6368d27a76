//! Strain measures that keep their digits near rest and near every rotation.
//!
//! tr FᵀF − D, ln J and J − 1 are differences of numbers near 1; an energy made of them loses
//! half of its digits at strains of 1e-8. All three follow from the Green strain E without such
//! a difference: tr FᵀF − D = 2 tr E and J² − 1 = det(I + 2E) − 1.

use fem_kinematics::{Mat, Real};

/// E, J and J − 1 of one F.
#[derive(Clone, Copy)]
pub(crate) struct RestMeasures<T: Real, const D: usize> {
    /// Green strain E = (FᵀF − I)/2.
    pub E: Mat<T, D>,
    /// J = det F.
    pub J: T,
    /// J − 1.
    pub J_minus_1: T,
    /// J² − 1.
    squared_minus_1: T,
    /// E is small and J > 0.
    near: T::Mask,
}

impl<T: Real, const D: usize> RestMeasures<T, D> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new(F: &Mat<T, D>) -> Self {
        let E = green_strain(F);
        let J = F.determinant();
        let near = E.norm_squared().lt(T::from_f64(0.02)) & T::zero().lt(J);
        let squared_minus_1 = E
            .scale(T::from_f64(2.0))
            .determinant_of_identity_plus_minus_one();
        let J_minus_1 = T::select(near, squared_minus_1 / (T::one() + J), J - T::one());
        Self {
            E,
            J,
            J_minus_1,
            squared_minus_1,
            near,
        }
    }

    /// ln J; NaN for J < 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn log_J(&self) -> T {
        let small = T::select(self.near, self.squared_minus_1, T::zero());
        let near = T::from_f64(0.5) * small.ln_1p();
        if !T::any(!self.near) {
            return near;
        }
        T::select(self.near, near, self.J.ln())
    }
}

/// E = (FᵀF − I)/2 = (G + Gᵀ + GᵀG)/2 with G = F − I.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn green_strain<T: Real, const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
    let G = *F - Mat::identity();
    G.symmetric_part() + G.tr_mul(&G).scale(T::from_f64(0.5))
}

/// `value` where J > 0, else +∞.
#[inline(always)]
pub(crate) fn infinite_unless_positive<T: Real>(J: T, value: T) -> T {
    T::select(T::zero().lt(J), value, T::from_f64(f64::INFINITY))
}

/// x^(−1/3), x > 0: by one exponential and one Newton step, which removes the error that the
/// exponential inherits from a large logarithm.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn inverse_cube_root<T: Real>(x: T) -> T {
    let r = (T::from_f64(-1.0 / 3.0) * x.ln()).exp();
    r + r * (T::one() - x * r * r * r) * T::from_f64(1.0 / 3.0)
}
