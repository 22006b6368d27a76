//! Ogden's rubber elasticity (1972), isochoric, with a volume term.

use crate::isotropic::{ByStretches, StretchEnergy};
use crate::near_rest::infinite_unless_positive;
use crate::registry::{Entry, Parameter, Register};
use fem_kinematics::{Mat, Real, vector};

/// ψ = Σ_p μ_p/α_p (Σᵢ σ̄ᵢ^{α_p} − 3) + K/2 (ln J)², σ̄ = J^(−1/3) σ; finite only for J > 0.
///
/// Rubber at stretches where neo-Hookean is too soft or too stiff: N terms are fitted to
/// measurements. The shear modulus at rest is Σ μ_p α_p/2. One term with α = 2 is (isochoric)
/// neo-Hookean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ogden<const N: usize> {
    /// (μ_p in Pa, α_p without unit, not 0) of each term.
    pub terms: [(f64, f64); N],
    /// Bulk modulus K, Pa.
    pub K: f64,
}

const PARAMETERS: [Parameter; 3] = [
    Parameter::pascals(
        "mu",
        "6.3e5 1.2e3 -1e4",
        "μ of each of three terms; 0 for none",
    ),
    Parameter::plain(
        "alpha",
        "1.3 5.0 -2.0",
        "exponent of each of three terms, not 0",
    ),
    Parameter::pascals("K", "5e6", "bulk modulus"),
];

pub(crate) fn register(visitor: &mut impl Register) {
    visitor.solid(&Entry {
        name: "ogden",
        aliases: &[],
        elastic: None,
        about: "rubber with test data of several kinds, tissue at large stretch; fitted by exponents",
        domain: "J > 0",
        parameters: &PARAMETERS,
        from_parameters: |p| {
            let (mu, alpha) = (p.vector::<3>("mu")?, p.vector::<3>("alpha")?);
            for value in alpha {
                if value == 0.0 {
                    return Err(crate::registry::ParameterError::OutOfRange {
                        name: "alpha",
                        value,
                        range: "different from 0",
                    });
                }
            }
            let terms = core::array::from_fn(|i| (mu[i], alpha[i]));
            Ok(ByStretches(Ogden::<3> {
                terms,
                K: p.non_negative("K")?,
            }))
        },
    });
}

/// Logarithms of the stretches; a pack of NaN where one is negative.
struct Logs<T> {
    /// ln σ̄ᵢ.
    deviatoric: [T; 3],
    /// ln J.
    volume: T,
    /// 1/σᵢ.
    inverse: [T; 3],
}

impl<T: Real> Logs<T> {
    #[inline(always)]
    fn new(sigma: &[T; 3]) -> Self {
        // Calls written out, not closures: docs/kernels.md, finding 2.
        let t = [sigma[0].ln(), sigma[1].ln(), sigma[2].ln()];
        let volume = t[0] + t[1] + t[2];
        let mean = T::from_f64(1.0 / 3.0) * volume;
        Self {
            deviatoric: [t[0] - mean, t[1] - mean, t[2] - mean],
            volume,
            inverse: [sigma[0].recip(), sigma[1].recip(), sigma[2].recip()],
        }
    }
    /// σ̄ᵢ^α for each i, and a third of their sum.
    #[inline(always)]
    fn powers(&self, alpha: f64) -> ([T; 3], T) {
        let [a, b, c] = self.deviatoric;
        let alpha = T::from_f64(alpha);
        let p = [(alpha * a).exp(), (alpha * b).exp(), (alpha * c).exp()];
        (p, T::from_f64(1.0 / 3.0) * (p[0] + p[1] + p[2]))
    }
}

/// (eᵃᵗ − 1)/(eᵗ − 1) for t = ln(x/y), its limit a at t = 0; `ratio` is x/y − 1.
#[inline(always)]
fn power_quotient<T: Real>(exponent: f64, ratio: T) -> T {
    let a = T::from_f64(exponent);
    let near = ratio.abs().lt(T::from_f64(1e-9));
    let safe = T::select(near, T::one(), ratio);
    let quotient = (a * safe.ln_1p()).exp_m1() / safe;
    // a + a(a − 1)/2 r: the next term is below 1e-18
    let series = a + T::from_f64(0.5 * exponent * (exponent - 1.0)) * ratio;
    T::select(near, series, quotient)
}

impl<const N: usize> StretchEnergy<3> for Ogden<N> {
    #[inline(always)]
    fn energy<T: Real>(&self, sigma: &[T; 3]) -> T {
        let logs = Logs::new(sigma);
        let mut psi = T::from_f64(0.5 * self.K) * logs.volume * logs.volume;
        for (mu, alpha) in self.terms {
            let [a, b, c] = logs.deviatoric;
            let factor = T::from_f64(mu / alpha);
            let alpha = T::from_f64(alpha);
            psi += factor * ((alpha * a).exp_m1() + (alpha * b).exp_m1() + (alpha * c).exp_m1());
        }
        infinite_unless_positive(sigma[0] * sigma[1] * sigma[2], psi)
    }
    #[inline(always)]
    fn gradient<T: Real>(&self, sigma: &[T; 3]) -> [T; 3] {
        let logs = Logs::new(sigma);
        // σᵢ gᵢ
        let mut kirchhoff = [T::from_f64(self.K) * logs.volume; 3];
        for (mu, alpha) in self.terms {
            let (p, mean) = logs.powers(alpha);
            for i in 0..3 {
                kirchhoff[i] += T::from_f64(mu) * (p[i] - mean);
            }
        }
        vector(|i| kirchhoff[i] * logs.inverse[i])
    }
    #[inline(always)]
    fn hessian<T: Real>(&self, sigma: &[T; 3]) -> Mat<T, 3> {
        let logs = Logs::new(sigma);
        let mut kirchhoff = [T::from_f64(self.K) * logs.volume; 3];
        // ∂²ψ/∂ln σᵢ ∂ln σⱼ
        let mut H = Mat([[T::from_f64(self.K); 3]; 3]);
        for (mu, alpha) in self.terms {
            let (p, mean) = logs.powers(alpha);
            let third = T::from_f64(1.0 / 3.0);
            for i in 0..3 {
                kirchhoff[i] += T::from_f64(mu) * (p[i] - mean);
                for j in 0..3 {
                    let own = if i == j { p[i] } else { T::zero() };
                    H.0[i][j] += T::from_f64(mu * alpha) * (own - third * (p[i] + p[j] - mean));
                }
            }
        }
        for i in 0..3 {
            H.0[i][i] -= kirchhoff[i];
            for j in 0..3 {
                H.0[i][j] = H.0[i][j] * logs.inverse[i] * logs.inverse[j];
            }
        }
        H
    }
    #[inline(always)]
    fn difference_quotient<T: Real>(&self, sigma: &[T; 3], i: usize, j: usize) -> T {
        // σᵢ gᵢ = μ σ̄ᵢ^α + c: the quotient of σ^(α−1) is σⱼ^(α−2) times that of r^(α−1), and
        // that of c/σ is −c/(σᵢσⱼ).
        let logs = Logs::new(sigma);
        let ratio = (sigma[i] - sigma[j]) * logs.inverse[j];
        let mut sum = T::zero();
        let mut common = T::from_f64(self.K) * logs.volume;
        for (mu, alpha) in self.terms {
            let (p, mean) = logs.powers(alpha);
            common += -T::from_f64(mu) * mean;
            sum += T::from_f64(mu)
                * p[j]
                * logs.inverse[j]
                * logs.inverse[j]
                * power_quotient(alpha - 1.0, ratio);
        }
        sum - common * logs.inverse[i] * logs.inverse[j]
    }
    #[inline(always)]
    fn sum_quotient<T: Real>(&self, sigma: &[T; 3], i: usize, j: usize) -> T {
        let g = self.gradient(sigma);
        (g[i] + g[j]) / (sigma[i] + sigma[j])
    }
}
