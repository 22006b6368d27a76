//! What to do with the negative eigenvalues of dP/dF: nothing, clamp, or flip.

use crate::jacobi::{SymmetricEigen, symmetric_eigen};
use crate::mat::Mat;
use crate::scalar::Real;
use crate::tensor4::Tensor4;

/// The treatment of negative eigenvalues of an element's dP/dF.
///
/// A strained body can be stable as a whole while most of its elements are indefinite, so a
/// solver starts with [`HessianProjection::None`] and projects only when it meets negative
/// curvature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HessianProjection {
    /// The exact derivative.
    #[default]
    None,
    /// Negative eigenvalues become 0: the nearest positive semidefinite tensor (document 000, 5.6).
    Clamp,
    /// Negative eigenvalues change sign, which keeps the length of steps along them
    /// (Chen, Sharp and Jacobson 2024, "Stabler Neo-Hookean Simulation: Absolute Eigenvalue
    /// Filtering for Projected Newton").
    Absolute,
}

impl HessianProjection {
    /// The projection on one eigenvalue.
    #[inline(always)]
    pub fn eigenvalue<T: Real>(self, value: T) -> T {
        match self {
            Self::None => value,
            Self::Clamp => T::select(value.lt(T::zero()), T::zero(), value),
            Self::Absolute => value.abs(),
        }
    }

    /// The projection on a symmetric 2×2 matrix [[α, β], [β, α]]: returns the new (α, β).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn twin<T: Real>(self, alpha: T, beta: T) -> (T, T) {
        let half = T::from_f64(0.5);
        let symmetric = self.eigenvalue(alpha + beta);
        let antisymmetric = self.eigenvalue(alpha - beta);
        (
            half * (symmetric + antisymmetric),
            half * (symmetric - antisymmetric),
        )
    }

    /// The projection on a symmetric N×N matrix, by its eigenvalues.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn matrix<T: Real, const D: usize>(self, A: &Mat<T, D>) -> Mat<T, D> {
        if self == Self::None {
            return *A;
        }
        let SymmetricEigen { values, vectors } = symmetric_eigen(A);
        let scaled = Mat::from_fn(|i, k| vectors.0[i][k] * self.eigenvalue(values[k]));
        scaled.mul_tr(&vectors)
    }

    /// The projection on the whole tensor, by the eigenvalues of its D²×D² matrix; the slow way that
    /// works for every model. Compiled once for each scalar (a call is nothing beside it), for the
    /// instructions of every processor: not for packs.
    #[inline(never)]
    pub fn apply<T: Real, const D: usize>(self, derivative: &Tensor4<T, D>) -> Tensor4<T, D> {
        match self {
            Self::None => *derivative,
            _ => derivative.project(|value| self.eigenvalue(value)),
        }
    }
}
