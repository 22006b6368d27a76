//! The muscle of document 000 in the frame of the singular vectors, formula by formula.
//!
//! [`MooneyRivlin`](crate::MooneyRivlin) itself works on F directly; these are the document's
//! summaries, corrected, for those who follow it (and to prove both).

use super::blocks::AlphaBetaGamma;
use fem_kinematics::{Mat, Real, vector};

/// What the summaries share: J, J_cc = J^(−2/3), σᵢ², tr C and tr C².
struct Shared<T> {
    J: T,
    J_cc: T,
    C: [T; 3],
    trace: T,
    trace_square: T,
}

impl<T: Real> Shared<T> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new(sigma: [T; 3]) -> Self {
        let J = sigma[0] * sigma[1] * sigma[2];
        let C: [T; 3] = vector(|i| sigma[i] * sigma[i]);
        Self {
            J,
            J_cc: J.powf(-2.0 / 3.0),
            C,
            trace: C[0] + C[1] + C[2],
            trace_square: C[0] * C[0] + C[1] * C[1] + C[2] * C[2],
        }
    }
}

/// P̂ of the whole muscle at F̂ = diag(σ) (document 000, eq. 15):
/// P = w₁₂ F̂ − w₂ F̂³ + (p − p_f) F̂⁻¹ + J_cc T F̂ f fᵀ, f = Vᵀ a₀ the fiber seen from there.
///
/// `coefficients` are A, B, K in Pa; `tension` is the document's T of section 4.3.3, which is
/// F₂′(λ)/λ with the isochoric stretch λ.
// ERRATUM: with C redefined as F̂², I₁ = tr C stands for tr F̂², not for J_cc tr F̂² as in 4.2.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn combined_stress<T: Real>(
    coefficients: [T; 3],
    sigma: [T; 3],
    fiber: [T; 3],
    tension: T,
) -> Mat<T, 3> {
    let [A, B, K] = coefficients;
    let Shared {
        J,
        J_cc,
        C,
        trace,
        trace_square,
    } = Shared::new(sigma);
    let f: [T; 3] = vector(|i| fiber[i] * fiber[i]);
    let lambda_square = J_cc * (C[0] * f[0] + C[1] * f[1] + C[2] * f[2]);
    let two = T::from_f64(2.0);
    let w1 = two * J_cc * A;
    let w2 = two * J_cc * J_cc * B;
    let w12 = w1 + trace * w2;
    let p = K * J.ln();
    let p_f = T::from_f64(1.0 / 3.0) * (w12 * trace - w2 * trace_square + tension * lambda_square);
    let mut P = Mat::from_fn(|i, j| J_cc * tension * sigma[i] * fiber[i] * fiber[j]);
    for i in 0..3 {
        P.0[i][i] += w12 * sigma[i] - w2 * sigma[i] * C[i] + (p - p_f) / sigma[i];
    }
    P
}

/// η of document 000, section 4.5.1.4.3: γ = F_base η F_baseᵀ with the rows (σᵢ, σᵢ³, σᵢ⁻¹) of
/// F_base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eta<T>(pub Mat<T, 3>);

impl<T: Real> Eta<T> {
    /// η of A I₁ + B I₂ + K/2 (ln J)²; `coefficients` are A, B, K in Pa.
    // ERRATUM: eq. 34 and the first line of η₁₃ print 8B/9 for 8B/3; eqs. 32 and 38 print = for
    // −=. The second line of η₁₃ and η₃₁ is right, and η is symmetric.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(coefficients: [T; 3], sigma: [T; 3]) -> Self {
        let f = T::from_f64;
        let [A, B, K] = coefficients;
        let Shared {
            J_cc,
            trace,
            trace_square,
            ..
        } = Shared::new(sigma);
        let b = B * J_cc * J_cc;
        let eta11 = f(4.0) * b;
        let eta13 = -f(1.0 / 3.0) * J_cc * (f(4.0) * A + f(8.0) * B * J_cc * trace);
        let eta23 = f(8.0 / 3.0) * b;
        let eta33 =
            K + f(4.0 / 9.0) * A * J_cc * trace + f(8.0 / 9.0) * b * (trace * trace - trace_square);
        let zero = T::zero();
        Self(Mat([
            [eta11, zero, eta13],
            [zero, zero, eta23],
            [eta13, eta23, eta33],
        ]))
    }

    /// γ = F_base η F_baseᵀ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn gamma(&self, sigma: [T; 3]) -> Mat<T, 3> {
        let [a, b, c] = sigma;
        let base = Mat([
            [a, a * a * a, a.recip()],
            [b, b * b * b, b.recip()],
            [c, c * c * c, c.recip()],
        ]);
        (base * self.0).mul_tr(&base)
    }
}

/// α, β and γ of A I₁ + B I₂ + K/2 (ln J)² at F̂ = diag(σ) (document 000, 4.5.1.4);
/// `coefficients` are A, B, K in Pa.
// ERRATUM: the second line of α prints J_cc² for J_cc and σᵢ² twice; eqs. 30 and 39 print σᵢσᵢ
// for σᵢσⱼ, eqs. 42-44 print = for −=.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn mooney_rivlin_alpha_beta_gamma<T: Real>(
    coefficients: [T; 3],
    sigma: [T; 3],
) -> AlphaBetaGamma<T> {
    let f = T::from_f64;
    let [A, B, K] = coefficients;
    let Shared {
        J,
        J_cc,
        C,
        trace,
        trace_square,
    } = Shared::new(sigma);
    let b = B * J_cc * J_cc;
    let over = f(2.0 / 3.0) * (A * J_cc * trace + b * (trace * trace - trace_square)) - K * J.ln();
    AlphaBetaGamma {
        alpha: Mat::from_fn(|i, j| f(2.0) * J_cc * (A + B * J_cc * (trace - C[i] - C[j]))),
        beta: Mat::from_fn(|i, j| over / (sigma[i] * sigma[j]) - f(2.0) * b * sigma[i] * sigma[j]),
        gamma: Eta::new(coefficients, sigma).gamma(sigma),
    }
}
