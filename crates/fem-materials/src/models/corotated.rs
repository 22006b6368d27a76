//! Elasticity of the stretch that remains once the rotation is taken out: F = R S.

use super::linear::LAME;
use crate::isotropic::{ByStretches, StretchEnergy, positive_sum};
use crate::lame::Lame;
use crate::near_rest::RestMeasures;
use crate::registry::{Entry, Parameter, ParameterError, Parameters, Register, lame_itself};
use fem_kinematics::{Mat, Polar, Real, Svd, vector};

/// ψ = μ |S − I|² + λ/2 tr(S − I)² (document 002): linear elasticity in a frame that turns along.
///
/// S has a negative eigenvalue where det F < 0, R is always a rotation. Defined for every F with a
/// determined rotation (σ_{D−1} + σ_D > 0). The volume term is weak under large compression:
/// [`FixedCorotated`] has a better one.
// ERRATUM: document 002 takes R = U Vᵀ of a plain SVD, a reflection for det F < 0; and the sign of
// its (vanishing) term with dR is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorotatedLinear {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

/// ψ = μ |F − R|² + λ/2 (J − 1)² (Stomakhin et al. 2012).
///
/// The corotated model with a volume term that resists collapse and inversion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCorotated {
    /// Shear modulus μ, Pa.
    pub mu: f64,
    /// First Lamé parameter λ, Pa.
    pub lambda: f64,
}

/// ψ = μ |F − R|²: as rigid as possible (Sorkine and Alexa 2007), with no volume term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arap {
    /// Shear modulus μ, Pa; λ is 0.
    pub mu: f64,
}

fn lame(p: &Parameters) -> Result<Lame, ParameterError> {
    Ok(Lame {
        mu: p.non_negative("mu")?,
        lambda: p.number("lambda")?,
    })
}

impl From<Lame> for CorotatedLinear {
    fn from(Lame { mu, lambda }: Lame) -> Self {
        Self { mu, lambda }
    }
}

impl From<Lame> for FixedCorotated {
    fn from(Lame { mu, lambda }: Lame) -> Self {
        Self { mu, lambda }
    }
}

const ARAP: [Parameter; 1] = [LAME[0]];

pub(crate) fn register(visitor: &mut impl Register) {
    let corotated = Entry {
        name: "corotated",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "large rotations with a nearly linear response",
        domain: "σ_(D−1) + σ_D > 0",
        parameters: &LAME,
        from_parameters: |p| Ok(ByStretches(CorotatedLinear::from(lame(p)?))),
    };
    visitor.plane(&corotated);
    visitor.solid(&corotated);
    let fixed = Entry {
        name: "fixed_corotated",
        aliases: &[],
        elastic: Some(lame_itself),
        about: "large rotations and compression; usual in the material point method",
        domain: "σ_(D−1) + σ_D > 0",
        parameters: &LAME,
        from_parameters: |p| Ok(ByStretches(FixedCorotated::from(lame(p)?))),
    };
    visitor.plane(&fixed);
    visitor.solid(&fixed);
    let arap = Entry {
        name: "arap",
        aliases: &[],
        elastic: None,
        about: "shapes to be deformed, not matter: as rigid as possible",
        domain: "σ_(D−1) + σ_D > 0",
        parameters: &ARAP,
        from_parameters: |p| {
            Ok(ByStretches(Arap {
                mu: p.non_negative("mu")?,
            }))
        },
    };
    visitor.plane(&arap);
    visitor.solid(&arap);
}

/// R of F = R S, and F − R = R (S − I), of which |F − R|² = |S − I|² and R : (F − R) = tr(S − I).
///
/// Unlike σᵢ − 1, an entry of F − R is exact but for the rounding of R, and the derivative of R has
/// no 1/(σᵢ − σⱼ).
#[inline(always)]
fn strained<T: Real, const D: usize>(F: &Mat<T, D>, svd: &Svd<T, D>) -> (Mat<T, D>, Mat<T, D>) {
    let R = Polar::from_svd(F, svd).R;
    (R, *F - R)
}

/// Σ (σᵢ − 1).
#[inline(always)]
fn trace<T: Real, const D: usize>(sigma: &[T; D]) -> T {
    let mut sum = T::zero();
    for s in sigma {
        sum += *s - T::one();
    }
    sum
}

/// Σ (σᵢ − 1)².
#[inline(always)]
fn squares<T: Real, const D: usize>(sigma: &[T; D]) -> T {
    let mut sum = T::zero();
    for s in sigma {
        sum += (*s - T::one()).squared();
    }
    sum
}

/// 2 (σᵢ + σⱼ − 2)/(σᵢ + σⱼ): the turning stiffness of Σ (σ − 1)².
#[inline(always)]
fn turning<T: Real, const D: usize>(sigma: &[T; D], i: usize, j: usize) -> T {
    let two = T::from_f64(2.0);
    two * ((sigma[i] - T::one()) + (sigma[j] - T::one())) / positive_sum(sigma, i, j)
}

impl<const D: usize> StretchEnergy<D> for CorotatedLinear {
    #[inline(always)]
    fn energy_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> T {
        let (R, strain) = strained(F, svd);
        let t = R.dot(&strain);
        T::from_f64(self.mu) * strain.norm_squared() + T::from_f64(0.5 * self.lambda) * t * t
    }
    /// 2μ (F − R) + λ tr(S − I) R.
    #[inline(always)]
    fn stress_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> Mat<T, D> {
        let (R, strain) = strained(F, svd);
        let pressure = T::from_f64(self.lambda) * R.dot(&strain);
        strain.scale(T::from_f64(2.0 * self.mu)) + R.scale(pressure)
    }
    #[inline(always)]
    fn energy<T: Real>(&self, sigma: &[T; D]) -> T {
        let t = trace(sigma);
        T::from_f64(self.mu) * squares(sigma) + T::from_f64(0.5 * self.lambda) * t * t
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, sigma: &[T; D]) -> [T; D] {
        let pressure = T::from_f64(self.lambda) * trace(sigma);
        vector(|i| T::from_f64(2.0 * self.mu) * (sigma[i] - T::one()) + pressure)
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, _sigma: &[T; D]) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(2.0 * self.mu), T::from_f64(self.lambda));
        Mat::from_fn(|i, j| if i == j { mu + lambda } else { lambda })
    }
    #[inline(always)]
    fn difference_quotient<T: Real>(&self, _sigma: &[T; D], _i: usize, _j: usize) -> T {
        T::from_f64(2.0 * self.mu)
    }
    #[inline(always)]
    fn sum_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T {
        let pressure = T::from_f64(2.0 * self.lambda) * trace(sigma);
        T::from_f64(self.mu) * turning(sigma, i, j) + pressure / positive_sum(sigma, i, j)
    }
}

/// The product of the stretches other than i and j (1 in 2D for a pair).
#[inline(always)]
fn others<T: Real, const D: usize>(sigma: &[T; D], i: usize, j: usize) -> T {
    let mut product = T::one();
    for k in 0..D {
        if k != i && k != j {
            product *= sigma[k];
        }
    }
    product
}

/// Π σᵢ − 1 from the σᵢ − 1, so that no digits are lost near rest.
#[inline(always)]
fn volume_change<T: Real, const D: usize>(sigma: &[T; D]) -> T {
    let mut change = T::zero();
    for s in sigma {
        // (1 + c) s − 1 = c s + (s − 1)
        change = change * *s + (*s - T::one());
    }
    change
}

impl<const D: usize> StretchEnergy<D> for FixedCorotated {
    #[inline(always)]
    fn energy_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> T {
        let j = RestMeasures::new(F).J_minus_1;
        let shape = T::from_f64(self.mu) * strained(F, svd).1.norm_squared();
        shape + T::from_f64(0.5 * self.lambda) * j * j
    }
    /// 2μ (F − R) + λ (J − 1) cof F.
    #[inline(always)]
    fn stress_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> Mat<T, D> {
        let pressure = T::from_f64(self.lambda) * RestMeasures::new(F).J_minus_1;
        let shape = strained(F, svd).1.scale(T::from_f64(2.0 * self.mu));
        shape + F.cofactor().scale(pressure)
    }
    #[inline(always)]
    fn energy<T: Real>(&self, sigma: &[T; D]) -> T {
        let j = volume_change(sigma);
        T::from_f64(self.mu) * squares(sigma) + T::from_f64(0.5 * self.lambda) * j * j
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, sigma: &[T; D]) -> [T; D] {
        let pressure = T::from_f64(self.lambda) * volume_change(sigma);
        vector(|i| {
            T::from_f64(2.0 * self.mu) * (sigma[i] - T::one()) + pressure * others(sigma, i, i)
        })
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, sigma: &[T; D]) -> Mat<T, D> {
        let (mu, lambda) = (T::from_f64(2.0 * self.mu), T::from_f64(self.lambda));
        let pressure = lambda * volume_change(sigma);
        let mut H = Mat::zeros();
        for i in 0..D {
            for j in 0..D {
                let outer = lambda * others(sigma, i, i) * others(sigma, j, j);
                H.0[i][j] = if i == j {
                    mu + outer
                } else {
                    outer + pressure * others(sigma, i, j)
                };
            }
        }
        H
    }
    #[inline(always)]
    fn difference_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T {
        let pressure = T::from_f64(self.lambda) * volume_change(sigma);
        T::from_f64(2.0 * self.mu) - pressure * others(sigma, i, j)
    }
    #[inline(always)]
    fn sum_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T {
        let pressure = T::from_f64(self.lambda) * volume_change(sigma);
        T::from_f64(self.mu) * turning(sigma, i, j) + pressure * others(sigma, i, j)
    }
}

impl<const D: usize> StretchEnergy<D> for Arap {
    #[inline(always)]
    fn energy_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> T {
        T::from_f64(self.mu) * strained(F, svd).1.norm_squared()
    }
    /// 2μ (F − R).
    #[inline(always)]
    fn stress_at<T: Real>(&self, F: &Mat<T, D>, svd: &Svd<T, D>) -> Mat<T, D> {
        strained(F, svd).1.scale(T::from_f64(2.0 * self.mu))
    }
    #[inline(always)]
    fn energy<T: Real>(&self, sigma: &[T; D]) -> T {
        T::from_f64(self.mu) * squares(sigma)
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, sigma: &[T; D]) -> [T; D] {
        vector(|i| T::from_f64(2.0 * self.mu) * (sigma[i] - T::one()))
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, _sigma: &[T; D]) -> Mat<T, D> {
        Mat::from_diagonal([T::from_f64(2.0 * self.mu); D])
    }
    #[inline(always)]
    fn difference_quotient<T: Real>(&self, _sigma: &[T; D], _i: usize, _j: usize) -> T {
        T::from_f64(2.0 * self.mu)
    }
    #[inline(always)]
    fn sum_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T {
        T::from_f64(self.mu) * turning(sigma, i, j)
    }
}
