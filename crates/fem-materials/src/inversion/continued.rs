//! An energy that goes on smoothly below a threshold of the singular values.
//!
//! # Derivation
//! With τ = max(a − σ, 0)/a each singular value is replaced by s(σ) = max(σ, a) + a (h(τ) − 1),
//! which is σ above the threshold a and falls towards 0, never reaching it, below. A penalty q(σ)
//! pushes back: ψ_c(σ) = ψ(s(σ₁), s(σ₂), s(σ₃)) + Σ q(σᵢ). With g = ∂ψ/∂s and H = ∂²ψ/∂s²:
//! ∂ψ_c/∂σᵢ = gᵢ s′ᵢ + q′ᵢ and ∂²ψ_c/∂σᵢ∂σⱼ = s′ᵢ Hᵢⱼ s′ⱼ + δᵢⱼ (gᵢ s″ᵢ + q″ᵢ), where s′ = −h′.
//!
//! h = 1/(1 + τ) and q = k/2 (a − σ)² make ψ_c C¹ (h″(0) ≠ 0); h = 1/(1 + τ + τ²) and
//! q = k/(6a) (a − σ)³ make it C² (h″(0) = 0). Every difference quotient of these rational
//! functions is again one, so repeated singular values are no special case.

use crate::inversion::positive_threshold;
use crate::isotropic::{ByStretches, DiagonalBlocks, PAIRS, StretchEnergy, positive_sum};
use crate::material::{Material, Symmetry};
use crate::registry::ParameterError;
use fem_kinematics::{Mat, Real};

/// How smooth the energy is at the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothness {
    /// The stress is continuous, the stiffness jumps.
    C1,
    /// The stiffness is continuous too.
    C2,
}

/// Where and how an energy is continued.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuation {
    /// a > 0: the material itself is used where every singular value is at least this.
    pub threshold: f64,
    /// k ≥ 0, Pa: stiffness of the penalty below. The shear modulus is a good value.
    pub stiffness: f64,
    /// C¹ or C².
    pub smoothness: Smoothness,
}

/// An isotropic material with a continued energy, as a function of the singular values; a
/// [`Material`] inside [`ByStretches`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continued<M> {
    inner: M,
    continuation: Continuation,
}

/// `inner` with an energy that is finite and smooth for every F; see the
/// [module](crate::inversion).
///
/// The exception: on the set σ_{D−1} = −σ_D, deep in inversion, the signed singular values change
/// roles and the stress has a kink, as with every method that works on them.
///
/// `inner` must be isotropic, which is checked when compiling.
///
/// ```
/// use fem_materials::{Material, NeoHookean, inversion::{Continuation, Smoothness, continued}};
/// let soft = NeoHookean { mu: 1e5, lambda: 4e5 };
/// let how = Continuation { threshold: 0.3, stiffness: 1e5, smoothness: Smoothness::C2 };
/// let turned = fem_kinematics::Mat::<f64, 3>::from_diagonal([1.0, 1.0, -0.5]);
/// assert_eq!(soft.energy(&turned), f64::INFINITY);
/// assert!(continued::<_, 3>(soft, how)?.energy(&turned).is_finite());
/// # Ok::<(), fem_materials::registry::ParameterError>(())
/// ```
///
/// # Errors
/// If the threshold is not finite and greater than 0, or the stiffness not finite and 0 or greater.
pub fn continued<M: Material<D>, const D: usize>(
    inner: M,
    continuation: Continuation,
) -> Result<ByStretches<Continued<M>>, ParameterError> {
    const {
        assert!(
            matches!(M::SYMMETRY, Symmetry::Isotropic),
            "only an isotropic energy is a function of the singular values"
        );
    }
    positive_threshold(continuation.threshold)?;
    let stiffness = continuation.stiffness;
    if !(stiffness >= 0.0 && stiffness.is_finite()) {
        return Err(ParameterError::OutOfRange {
            name: "stiffness",
            value: stiffness,
            range: "finite and 0 or greater",
        });
    }
    Ok(ByStretches(Continued {
        inner,
        continuation,
    }))
}

/// One singular value's place in the continuation.
#[derive(Clone, Copy)]
struct Place<T> {
    /// max(σ, a) − a.
    above: T,
    /// τ ≥ 0.
    tau: T,
    /// h(τ).
    h: T,
    /// s(σ) > 0.
    s: T,
    /// s′ = −h′.
    s1: T,
}

impl Continuation {
    #[inline(always)]
    fn place<T: Real>(&self, sigma: T) -> Place<T> {
        let (a, one, zero) = (T::from_f64(self.threshold), T::one(), T::zero());
        let difference = sigma - a;
        // NaN is "below", and stays NaN.
        let high = a.le(sigma);
        let above = T::select(high, difference, zero);
        let tau = T::select(high, zero, -difference) * T::from_f64(1.0 / self.threshold);
        let (h, s1) = match self.smoothness {
            Smoothness::C1 => {
                let h = (one + tau).recip();
                (h, h * h)
            }
            Smoothness::C2 => {
                let h = (one + tau + tau * tau).recip();
                (h, (one + tau + tau) * h * h)
            }
        };
        // σ itself above the threshold, bit for bit.
        Place {
            above,
            tau,
            h,
            s: T::select(high, sigma, a * h),
            s1,
        }
    }

    /// s″.
    #[inline(always)]
    fn second<T: Real>(&self, p: &Place<T>) -> T {
        let (two, six) = (T::from_f64(2.0), T::from_f64(6.0));
        let below = T::zero().lt(p.tau);
        // s″ = h″/a
        let h2 = match self.smoothness {
            Smoothness::C1 => two * p.h * p.h * p.h,
            Smoothness::C2 => six * p.tau * (T::one() + p.tau) * p.h * p.h * p.h,
        };
        T::select(below, h2 * T::from_f64(1.0 / self.threshold), T::zero())
    }

    /// (h(τᵢ) − h(τⱼ))/(τᵢ − τⱼ) and the same quotient of s′ = −h′.
    #[inline(always)]
    fn quotients<T: Real>(&self, p: &Place<T>, q: &Place<T>) -> (T, T) {
        let (one, two) = (T::one(), T::from_f64(2.0));
        match self.smoothness {
            Smoothness::C1 => {
                let h = -p.h * q.h;
                (h, (p.h + q.h) * h)
            }
            Smoothness::C2 => {
                let h = -(one + p.tau + q.tau) * p.h * q.h;
                (h, two * p.h * p.h + (one + two * q.tau) * (p.h + q.h) * h)
            }
        }
    }

    /// q, −q′ and q″ with t = a τ.
    #[inline(always)]
    fn penalty<T: Real>(&self, p: &Place<T>) -> [T; 3] {
        let (k, a) = (T::from_f64(self.stiffness), T::from_f64(self.threshold));
        let (half, t) = (T::from_f64(0.5), a * p.tau);
        match self.smoothness {
            Smoothness::C1 => {
                let second = T::select(T::zero().lt(t), k, T::zero());
                [half * k * t * t, k * t, second]
            }
            Smoothness::C2 => {
                let push = half * k * t * p.tau;
                [T::from_f64(1.0 / 3.0) * push * t, push, k * p.tau]
            }
        }
    }

    /// −(q′ᵢ − q′ⱼ)/(tᵢ − tⱼ).
    #[inline(always)]
    fn penalty_quotient<T: Real>(&self, p: &Place<T>, q: &Place<T>) -> T {
        let k = T::from_f64(self.stiffness);
        match self.smoothness {
            Smoothness::C1 => k,
            Smoothness::C2 => T::from_f64(0.5) * k * (p.tau + q.tau),
        }
    }
}

/// (max(σᵢ, a) − max(σⱼ, a))/(σᵢ − σⱼ): 1 for both above, 0 for both below.
#[inline(always)]
fn share_above<T: Real>(p: &Place<T>, q: &Place<T>, gap: T) -> T {
    let (zero, one) = (T::zero(), T::one());
    let (p_low, q_low) = (zero.lt(p.tau), zero.lt(q.tau));
    let both_low = p_low & q_low;
    let both_high = !p_low & !q_low;
    let mixed = !(both_low | both_high);
    let share = (p.above - q.above) / T::select(mixed, gap, one);
    T::select(mixed, share, T::select(both_high, one, zero))
}

impl<const D: usize, M: Material<D>> StretchEnergy<D> for Continued<M> {
    #[inline(always)]
    fn energy<T: Real>(&self, sigma: &[T; D]) -> T {
        let places = sigma.map(|s| self.continuation.place(s));
        let mut psi = self.inner.energy(&Mat::from_diagonal(places.map(|p| p.s)));
        for p in &places {
            psi += self.continuation.penalty(p)[0];
        }
        psi
    }

    #[inline(always)]
    fn gradient<T: Real>(&self, sigma: &[T; D]) -> [T; D] {
        let places = sigma.map(|s| self.continuation.place(s));
        let P = self.inner.stress(&Mat::from_diagonal(places.map(|p| p.s)));
        core::array::from_fn(|i| {
            P.0[i][i] * places[i].s1 - self.continuation.penalty(&places[i])[1]
        })
    }

    #[inline(always)]
    fn hessian<T: Real>(&self, sigma: &[T; D]) -> Mat<T, D> {
        self.blocks(sigma).A
    }
    #[inline(always)]
    fn difference_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T {
        let (blocks, n) = (self.blocks(sigma), pair(i, j));
        blocks.alpha[n] + blocks.beta[n]
    }
    #[inline(always)]
    fn sum_quotient<T: Real>(&self, sigma: &[T; D], i: usize, j: usize) -> T {
        let (blocks, n) = (self.blocks(sigma), pair(i, j));
        blocks.alpha[n] - blocks.beta[n]
    }

    #[inline(always)]
    fn blocks<T: Real>(&self, sigma: &[T; D]) -> DiagonalBlocks<T, D> {
        let c = &self.continuation;
        let (one, half) = (T::one(), T::from_f64(0.5));
        let places = sigma.map(|s| c.place(s));
        let F = Mat::from_diagonal(places.map(|p| p.s));
        let P = self.inner.stress(&F);
        let mut out = DiagonalBlocks::from_tensor(&self.inner.stress_derivative(&F));
        for i in 0..D {
            for j in 0..D {
                out.A.0[i][j] *= places[i].s1 * places[j].s1;
            }
            out.A.0[i][i] += P.0[i][i] * c.second(&places[i]) + c.penalty(&places[i])[2];
        }
        for (n, &(i, j)) in PAIRS.iter().enumerate().take(D * (D - 1) / 2) {
            let (p, q) = (&places[i], &places[j]);
            let above = share_above(p, q, sigma[i] - sigma[j]);
            // τ = −(σ − max(σ, a))/a
            let tau_share = above - one;
            let (h_quotient, s1_quotient) = c.quotients(p, q);
            let s_share = above + h_quotient * tau_share;
            let s1_share = s1_quotient * tau_share * T::from_f64(1.0 / c.threshold);
            // gᵢ s′ᵢ − gⱼ s′ⱼ = (gᵢ − gⱼ)(s′ᵢ + s′ⱼ)/2 + (gᵢ + gⱼ)(s′ᵢ − s′ⱼ)/2
            let symmetric = (out.alpha[n] + out.beta[n]) * s_share * half * (p.s1 + q.s1)
                + half * (P.0[i][i] + P.0[j][j]) * s1_share
                - c.penalty_quotient(p, q) * tau_share;
            let g = |k: usize| P.0[k][k] * places[k].s1 - c.penalty(&places[k])[1];
            let turning = (g(i) + g(j)) / positive_sum(sigma, i, j);
            out.alpha[n] = half * (symmetric + turning);
            out.beta[n] = half * (symmetric - turning);
        }
        out
    }
}

/// The place of a pair in [`PAIRS`].
#[inline(always)]
fn pair(i: usize, j: usize) -> usize {
    i + j - 1
}
