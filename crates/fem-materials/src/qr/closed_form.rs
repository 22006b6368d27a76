//! The anisotropic energy of document 001 without a QR decomposition.
//!
//! Σ rᵢⱼ² = |F|², Π rᵢᵢ = det F, r₁₁ = |F e₁| and √(r₁₂² + r₂₂²) = |F e₂|, so the energy and all
//! its derivatives are closed forms in F, its cofactor and two columns. They hold for every F and
//! keep the digits that Q A R⁻ᵀ loses as r₁₁ or r₂₂ → 0.

use crate::isotropic;
use crate::near_rest::RestMeasures;
use crate::tensor_terms::Terms;
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Tensor4, dot};

/// The coefficients of the energy in one element or particle; with lanes, one per lane.
///
/// ψ = μ/2 (|F|² − D) − μ (J − 1) + λ/2 (J − 1)² + k_x/2 (|F e₁| − 1)² + k_y/2 (|F e₂| − 1)²,
/// the last term in 3D only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coefficients<T> {
    /// μ, Pa.
    pub mu: T,
    /// λ, Pa; at rest Lamé's λ is this minus μ.
    pub lambda: T,
    /// Stiffness of the fibers along the first axis of the rest shape, Pa.
    pub kx: T,
    /// Stiffness of the fibers along the second axis, Pa; not used in 2D.
    pub ky: T,
}

/// A family of fibers at one F.
struct Strand<T, const D: usize> {
    /// Its axis in the rest shape.
    axis: usize,
    /// k, Pa.
    k: T,
    /// F e/|F e|, 0 where that is 0/0.
    u: [T; D],
    /// 1/|F e|, huge but finite for F e = 0.
    inverse_length: T,
    /// |F e| − 1.
    extension: T,
}

impl<T: Real> Coefficients<T> {
    /// ψ of an element with damage d (document 001, section 3.6): `g` = (1 − r)(1 − d)² + r
    /// scales the μ terms always, the λ term only in tension (J ≥ 1) and the fibers never.
    #[inline(always)]
    pub fn degraded<const D: usize>(&self, g: T, F: &Mat<T, D>) -> Self {
        let tension = T::zero().le(RestMeasures::new(F).J_minus_1);
        Self {
            mu: g * self.mu,
            lambda: T::select(tension, g, T::one()) * self.lambda,
            ..*self
        }
    }

    /// ψ, Pa.
    #[inline(always)]
    pub fn energy<const D: usize>(&self, F: &Mat<T, D>) -> T {
        let half = T::from_f64(0.5);
        let rest = RestMeasures::new(F);
        let j = rest.J_minus_1;
        let mut psi = self.mu * (rest.E.trace() - j) + half * self.lambda * j * j;
        for axis in 0..D - 1 {
            let strand = self.strand(F, &rest, axis);
            psi += half * strand.k * strand.extension * strand.extension;
        }
        psi
    }

    /// P = μ F + (λ (J − 1) − μ) cof F + Σ k (1 − 1/s) (F e) eᵀ, Pa.
    #[inline(always)]
    pub fn stress<const D: usize>(&self, F: &Mat<T, D>) -> Mat<T, D> {
        let rest = RestMeasures::new(F);
        let mut P = F.scale(self.mu) + F.cofactor().scale(self.lambda * rest.J_minus_1 - self.mu);
        for axis in 0..D - 1 {
            let strand = self.strand(F, &rest, axis);
            let pull = strand.k * strand.extension;
            for i in 0..D {
                P.0[i][strand.axis] += pull * strand.u[i];
            }
        }
        P
    }

    /// dP = ∂P/∂F : dF.
    #[inline(always)]
    pub fn stress_differential<const D: usize>(&self, F: &Mat<T, D>, dF: &Mat<T, D>) -> Mat<T, D> {
        let rest = RestMeasures::new(F);
        let cof = F.cofactor();
        let mut dP = dF.scale(self.mu)
            + cof.scale(self.lambda * cof.dot(dF))
            + F.cofactor_differential(dF)
                .scale(self.lambda * rest.J_minus_1 - self.mu);
        for axis in 0..D - 1 {
            let strand = self.strand(F, &rest, axis);
            let w = dF.column(strand.axis);
            let along = dot(strand.u, w);
            let across = strand.k * strand.extension * strand.inverse_length;
            for i in 0..D {
                dP.0[i][strand.axis] += across * w[i] + (strand.k - across) * along * strand.u[i];
            }
        }
        dP
    }

    /// ∂P/∂F, Pa.
    #[inline(always)]
    pub fn stress_derivative<const D: usize>(&self, F: &Mat<T, D>) -> Tensor4<T, D> {
        let rest = RestMeasures::new(F);
        let cof = F.cofactor();
        let isotropic = Terms::new()
            .identity(self.mu)
            .outer(self.lambda, &cof, &cof)
            .cofactor(self.lambda * rest.J_minus_1 - self.mu, F)
            .0;
        self.add_fibers(isotropic, F, &rest, HessianProjection::None)
    }

    /// ∂P/∂F with its negative eigenvalues projected: the isotropic part in the frame of the
    /// singular vectors, each fiber through its eigenvalues k (once) and k (1 − 1/s).
    #[inline(always)]
    pub fn projected_derivative<const D: usize>(
        &self,
        F: &Mat<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        if projection == HessianProjection::None {
            return self.stress_derivative(F);
        }
        let rest = RestMeasures::new(F);
        let passive = Self {
            kx: T::zero(),
            ky: T::zero(),
            ..*self
        };
        let isotropic =
            isotropic::projected(F, projection, |F_hat| passive.stress_derivative(F_hat));
        self.add_fibers(isotropic, F, &rest, projection)
    }

    /// The fiber along an axis. A function and not a closure, which would stay outside the kernel that
    /// calls it twice.
    #[inline(always)]
    fn strand<const D: usize>(
        &self,
        F: &Mat<T, D>,
        rest: &RestMeasures<T, D>,
        axis: usize,
    ) -> Strand<T, D> {
        let v = F.column(axis);
        let (square, tiny) = (dot(v, v), T::from_f64(1e-36));
        let length = T::select(square.lt(tiny), tiny, square).sqrt();
        let inverse_length = length.recip();
        let mut u = v;
        for x in &mut u {
            *x *= inverse_length;
        }
        Strand {
            axis,
            k: if axis == 0 { self.kx } else { self.ky },
            u,
            inverse_length,
            // |F e|² − 1 = 2 E_ee
            extension: T::from_f64(2.0) * rest.E.0[axis][axis] / (length + T::one()),
        }
    }

    #[inline(always)]
    fn add_fibers<const D: usize>(
        &self,
        mut derivative: Tensor4<T, D>,
        F: &Mat<T, D>,
        rest: &RestMeasures<T, D>,
        projection: HessianProjection,
    ) -> Tensor4<T, D> {
        for axis in 0..D - 1 {
            let strand = self.strand(F, rest, axis);
            let across = projection.eigenvalue(strand.k * strand.extension * strand.inverse_length);
            let along = projection.eigenvalue(strand.k);
            let block = &mut derivative.0[strand.axis][strand.axis];
            *block += Mat::outer(strand.u, strand.u).scale(along - across);
            for i in 0..D {
                block.0[i][i] += across;
            }
        }
        derivative
    }
}
