//! The anisotropic energy of doc 001, sections 3.1 and 3.6, as a law whose damage is a per-particle
//! number in the particle's own scalar.
//!
//! No QR decomposition is needed: r₁₁ = |F e₁|, √(r₁₂² + r₂₂²) = |F e₂|, Π r_ii = det F and
//! Σ r_ij² = |F|², hence
//!
//! ```text
//! P = g μ (F − cof F) + g± λ (J − 1) cof F + Σ_k k_k (1 − 1/s_k) (F e_k) e_kᵀ,   s_k = |F e_k|,
//! ```
//!
//! with g = (1 − r)(1 − d)² + r, and g± = g where J ≥ 1, else 1.

use crate::law::Law;
use fem_kinematics::{Mat, Real};

/// Fibres along e₁ (and in 3D e₂) of the fibre frame in a matrix that can tear; the fibres cannot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreReinforced {
    /// μ of the model, Pa.
    pub mu: f64,
    /// λ of the model, Pa: Lamé's λ plus μ.
    pub lambda: f64,
    /// Fibre stiffness along e₁, Pa.
    pub kx: f64,
    /// Fibre stiffness along e₂, Pa; 3D only.
    pub ky: f64,
    /// What is left of the stiffness at d = 1, 0 to 1.
    pub residual: f64,
}

struct Coefficients<T> {
    mu: T,
    lambda: T,
    fibres: [T; 2],
}

impl FibreReinforced {
    /// From Young's modulus (Pa) and Poisson's ratio of the matrix in 3D (plane strain in 2D).
    pub fn from_young_poisson(young: f64, poisson: f64, kx: f64, ky: f64) -> Self {
        let mu = young / (2.0 * (1.0 + poisson));
        let lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        // ERRATUM: the model's λ is Lamé's plus μ (section 3.1 reads as if they were the same).
        Self {
            mu,
            lambda: lame + mu,
            kx,
            ky,
            residual: 1e-3,
        }
    }

    #[inline(always)]
    fn coefficients<T: Real, const D: usize>(&self, J: T, d: T) -> Coefficients<T> {
        let left = T::one() - d;
        let r = T::from_f64(self.residual);
        let g = (T::one() - r) * left * left + r;
        let tension = T::one().le(J);
        let ky = if D == 3 { self.ky } else { 0.0 };
        Coefficients {
            mu: g * T::from_f64(self.mu),
            lambda: T::from_f64(self.lambda) * T::select(tension, g, T::one()),
            fibres: [T::from_f64(self.kx), T::from_f64(ky)],
        }
    }

    /// Fibres that a dimension has: one in 2D, two in 3D.
    #[inline(always)]
    fn fibre_count<const D: usize>() -> usize {
        D - 1
    }
}

/// |F e_k| and its reciprocal, the latter 0 for a collapsed fibre: the stress is bounded there but
/// has no limit, and 0 is the mean of all directions.
#[inline(always)]
fn stretch<T: Real, const D: usize>(F: &Mat<T, D>, k: usize) -> (T, T) {
    let a = F.column(k);
    let mut square = a[0] * a[0];
    for c in 1..D {
        square += a[c] * a[c];
    }
    let s = square.sqrt();
    let collapsed = s.le(T::zero());
    let safe = T::select(collapsed, T::one(), s);
    (s, T::select(collapsed, T::zero(), safe.recip()))
}

impl<const D: usize> Law<D> for FibreReinforced {
    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, D>, d: T) -> T {
        let j = (*F - Mat::identity()).determinant_of_identity_plus_minus_one();
        let c = self.coefficients::<T, D>(j + T::one(), d);
        let half = T::from_f64(0.5);
        let mut psi = c.mu * (half * (F.norm_squared() - T::from_f64(D as f64)) - j)
            + half * c.lambda * j * j;
        for k in 0..Self::fibre_count::<D>() {
            let e = stretch(F, k).0 - T::one();
            psi += half * c.fibres[k] * e * e;
        }
        psi
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, D>, d: T) -> Mat<T, D> {
        let cofactor = F.cofactor();
        let J = F.determinant();
        let c = self.coefficients::<T, D>(J, d);
        let mut P = F.scale(c.mu) + cofactor.scale(c.lambda * (J - T::one()) - c.mu);
        for k in 0..Self::fibre_count::<D>() {
            let (_, per_s) = stretch(F, k);
            let tension = c.fibres[k] * (T::one() - per_s);
            for i in 0..D {
                P.0[i][k] += tension * F.0[i][k];
            }
        }
        P
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, D>, dF: &Mat<T, D>, d: T) -> Mat<T, D> {
        let cofactor = F.cofactor();
        let J = F.determinant();
        let c = self.coefficients::<T, D>(J, d);
        let mut dP = dF.scale(c.mu)
            + cofactor.scale(c.lambda * cofactor.dot(dF))
            + F.cofactor_differential(dF)
                .scale(c.lambda * (J - T::one()) - c.mu);
        for k in 0..Self::fibre_count::<D>() {
            let (_, per_s) = stretch(F, k);
            let w = dF.column(k);
            let mut along = T::zero();
            for i in 0..D {
                along += F.0[i][k] * per_s * w[i];
            }
            // k [(1 − 1/s)(I − u uᵀ) + u uᵀ] w
            for i in 0..D {
                let u = F.0[i][k] * per_s;
                dP.0[i][k] += c.fibres[k] * ((T::one() - per_s) * w[i] + per_s * along * u);
            }
        }
        dP
    }
}
