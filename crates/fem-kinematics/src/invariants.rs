//! Determinants without cancellation, and the invariants of C = FᵀF with their gradients.

use crate::mat::Mat;
use crate::scalar::Real;

/// The right Cauchy-Green tensor C = FᵀF.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn right_cauchy_green<T: Real, const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
    F.tr_mul(F)
}

/// The left Cauchy-Green tensor b = FFᵀ.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn left_cauchy_green<T: Real, const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
    F.mul_tr(F)
}

/// J − 1 = det F − 1, to full relative accuracy near rest, where det F − 1 cancels.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn determinant_minus_one<T: Real, const D: usize>(F: &Mat<T, D>) -> T {
    let G = *F - Mat::identity();
    // Far from rest the expansion in F − I is the one that cancels.
    T::select(
        G.norm_squared().lt(T::from_f64(0.25)),
        G.determinant_of_identity_plus_minus_one(),
        F.determinant() - T::one(),
    )
}

/// ln J, to full relative accuracy near rest; NaN where J < 0, −∞ where J = 0.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn log_determinant<T: Real, const D: usize>(F: &Mat<T, D>) -> T {
    let j = determinant_minus_one(F);
    let near = j.abs().lt(T::from_f64(0.5));
    let outside = T::select(near, T::one(), F.determinant());
    T::select(near, T::select(near, j, T::zero()).ln_1p(), outside.ln())
}

/// The invariants of C = FᵀF, with their gradients by F.
///
/// Two quantities are called "II" in the documents; they have two names here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariants<T> {
    /// I = tr C = Σσᵢ².
    pub first: T,
    /// II = tr C² = Σσᵢ⁴ (documents 000 and 004).
    pub second: T,
    /// (I² − II)/2, the second principal invariant: Σ σᵢ²σⱼ² over the pairs (equal to III in 2D).
    pub second_principal: T,
    /// III = det C = J².
    pub third: T,
}

impl<T: Real> Invariants<T> {
    /// The invariants of C = FᵀF.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new<const D: usize>(F: &Mat<T, D>) -> Self {
        let C = right_cauchy_green(F);
        // |cof F|² is a sum of squares: (I² − II)/2 would cancel for flat elements.
        let cofactor = F.cofactor();
        let J = F.determinant();
        Self {
            first: F.norm_squared(),
            second: C.norm_squared(),
            second_principal: if D == 2 {
                J * J
            } else {
                cofactor.norm_squared()
            },
            third: J * J,
        }
    }
    /// ∂I/∂F = 2 F.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn first_gradient<const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
        F.scale(T::from_f64(2.0))
    }
    /// ∂II/∂F = 4 F C.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn second_gradient<const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
        (*F * right_cauchy_green(F)).scale(T::from_f64(4.0))
    }
    /// Gradient of (I² − II)/2: 2 (I F − F C).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn second_principal_gradient<const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
        (F.scale(F.norm_squared()) - *F * right_cauchy_green(F)).scale(T::from_f64(2.0))
    }
    /// ∂III/∂F = 2 J cof F.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn third_gradient<const D: usize>(F: &Mat<T, D>) -> Mat<T, D> {
        F.cofactor().scale(F.determinant() * T::from_f64(2.0))
    }
    /// I − D, II − D and III − 1, with no cancellation near rest; (I² − II)/2 less its value at
    /// rest, D (D − 1)/2.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn minus_rest<const D: usize>(F: &Mat<T, D>) -> Self {
        // C = I + A, and tr A² in (I² − II)/2 is what the G-form of Green's strain gives.
        let A = crate::strain::green_strain(F).scale(T::from_f64(2.0));
        let (trace, square) = (A.trace(), A.norm_squared());
        let (two, half) = (T::from_f64(2.0), T::from_f64(0.5));
        let j = determinant_minus_one(F);
        let (first, second) = (trace, two * trace + square);
        Self {
            first,
            second,
            // ((D + a)² − D − b)/2 with b = 2a + |A|²
            second_principal: T::from_f64(D as f64 - 1.0) * trace + half * (trace * trace - square),
            third: j * (j + two),
        }
    }
}

/// The isochoric invariants I₁ = J^(−2/D) I and I₂ = J^(−4/D) (I² − II)/2 for J > 0, which do not
/// change with volume (document 000, section 4.2; D = 3 there).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsochoricInvariants<T, const D: usize> {
    /// I₁.
    pub first: T,
    /// I₂.
    pub second: T,
    /// ∂I₁/∂F = 2 J^(−2/D) (F − I/D F⁻ᵀ).
    pub first_gradient: Mat<T, D>,
    /// ∂I₂/∂F = J^(−4/D) (2 (I F − F C) − 2 (I² − II)/D F⁻ᵀ).
    pub second_gradient: Mat<T, D>,
}

impl<T: Real, const D: usize> IsochoricInvariants<T, D> {
    /// The isochoric invariants and their gradients; not finite for J ≤ 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(F: &Mat<T, D>) -> Self {
        let J = F.determinant();
        let scale = J.powf(-2.0 / D as f64);
        let square = scale * scale;
        let plain = Invariants::new(F);
        let inverse_transpose = F.cofactor().scale(J.recip());
        let n = D as f64;
        Self {
            first: scale * plain.first,
            second: square * plain.second_principal,
            first_gradient: (F.scale(T::from_f64(2.0))
                - inverse_transpose.scale(plain.first * T::from_f64(2.0 / n)))
            .scale(scale),
            second_gradient: (Invariants::second_principal_gradient(F)
                - inverse_transpose.scale(plain.second_principal * T::from_f64(4.0 / n)))
            .scale(square),
        }
    }
}
