//! Energies of the invariants of C (document 004).

use super::blocks::AlphaBetaGamma;
use crate::material::{Material, Symmetry};
use crate::near_rest::infinite_unless_positive;
use crate::tensor_terms::Terms;
use fem_kinematics::{Mat, Real, Tensor4, vector};

/// ψ(I, II, III) with I = tr C, II = tr C², III = det C, C = FᵀF.
///
/// II is tr C², not the second principal invariant (I² − tr C²)/2 that other texts call II.
pub trait InvariantEnergy: Copy + Send + Sync {
    /// Where ψ is defined.
    const DOMAIN: Domain;
    /// ψ, Pa.
    fn energy<T: Real>(&self, invariants: [T; 3]) -> T;
    /// (ψ_I, ψ_II, ψ_III), Pa.
    fn gradient<T: Real>(&self, invariants: [T; 3]) -> [T; 3];
    /// The second derivatives 11, 12, 13, 22, 23, 33 (document 004's order), Pa.
    fn hessian<T: Real>(&self, invariants: [T; 3]) -> [T; 6];
}

/// Where an energy of the invariants is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// For every F.
    Everywhere,
    /// For det F > 0; +∞ elsewhere. (III alone does not see an inversion.)
    PositiveDeterminant,
}

/// The material of an energy given by invariants.
///
/// P = 2ψ_I F + 4ψ_II F C + 2ψ_III J cof F, straight from F: no decomposition and no division.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByInvariants<M>(pub M);

/// I, II and III.
#[inline(always)]
fn invariants<T: Real>(C: &Mat<T, 3>, J: T) -> [T; 3] {
    [C.trace(), C.norm_squared(), J * J]
}

/// I, II, III of diag(σ).
#[inline(always)]
fn diagonal_invariants<T: Real>(sigma: [T; 3]) -> [T; 3] {
    let [a, b, c] = vector(|i| sigma[i] * sigma[i]);
    [a + b + c, a * a + b * b + c * c, a * b * c]
}

/// Row i: the derivatives of I, II, III by σᵢ: 2σᵢ, 4σᵢ³, 2 III/σᵢ = 2σᵢσⱼ²σₖ².
#[inline(always)]
fn invariant_slopes<T: Real>(sigma: [T; 3]) -> [[T; 3]; 3] {
    let two = T::from_f64(2.0);
    let mut slopes = [[T::zero(); 3]; 3];
    for i in 0..3 {
        let (s, a, b) = (sigma[i], sigma[(i + 1) % 3], sigma[(i + 2) % 3]);
        slopes[i] = [two * s, two * two * s * s * s, two * s * a * a * b * b];
    }
    slopes
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn sum<T: Real>(slopes: &[Mat<T, 3>; 3], [a, b, c]: [T; 3]) -> Mat<T, 3> {
    slopes[0].scale(a) + slopes[1].scale(b) + slopes[2].scale(c)
}

impl<M: InvariantEnergy> ByInvariants<M> {
    /// P̂, the diagonal of P at F̂ = diag(σ): (∂(I, II, III)/∂σ)ᵀ ∂ψ/∂(I, II, III) (document 004).
    #[inline(always)]
    pub fn diagonal_stress<T: Real>(&self, sigma: [T; 3]) -> [T; 3] {
        let g = self.0.gradient(diagonal_invariants(sigma));
        let rows = invariant_slopes(sigma);
        vector(|i| rows[i][0] * g[0] + rows[i][1] * g[1] + rows[i][2] * g[2])
    }

    /// α, β and γ of document 004 at F̂ = diag(σ).
    ///
    /// αᵢⱼ = 2ψ_I + 4(σᵢ² + σⱼ²)ψ_II, βᵢⱼ = 4σᵢσⱼψ_II − 2 III ψ_III/(σᵢσⱼ),
    /// γᵢⱼ = gᵢᵀ H gⱼ + 4 III ψ_III/(σᵢσⱼ).
    // ERRATUM: document 004 divides by σᵢσⱼ, 0/0 for a flat element; III/(σᵢσⱼ) is σᵢσⱼσₖ² for
    // i ≠ j and σⱼ²σₖ² for i = j.
    #[inline(always)]
    pub fn alpha_beta_gamma<T: Real>(&self, sigma: [T; 3]) -> AlphaBetaGamma<T> {
        let (two, four) = (T::from_f64(2.0), T::from_f64(4.0));
        let at = diagonal_invariants(sigma);
        let [g1, g2, g3] = self.0.gradient(at);
        let h = self.0.hessian(at);
        let H = [[h[0], h[1], h[2]], [h[1], h[3], h[4]], [h[2], h[4], h[5]]];
        let square: [T; 3] = vector(|i| sigma[i] * sigma[i]);
        let slopes = invariant_slopes(sigma);
        let quotient = |i: usize, j: usize| {
            if i == j {
                square[(i + 1) % 3] * square[(i + 2) % 3]
            } else {
                sigma[i] * sigma[j] * square[3 - i - j]
            }
        };
        AlphaBetaGamma {
            alpha: Mat::from_fn(|i, j| two * g1 + four * (square[i] + square[j]) * g2),
            beta: Mat::from_fn(|i, j| four * sigma[i] * sigma[j] * g2 - two * g3 * quotient(i, j)),
            gamma: Mat::from_fn(|i, j| {
                let mut sum = four * g3 * quotient(i, j);
                for a in 0..3 {
                    for b in 0..3 {
                        sum += slopes[i][a] * H[a][b] * slopes[j][b];
                    }
                }
                sum
            }),
        }
    }
}

impl<M: InvariantEnergy> Material<3> for ByInvariants<M> {
    const SYMMETRY: Symmetry = Symmetry::Isotropic;

    #[inline(always)]
    fn energy<T: Real>(&self, F: &Mat<T, 3>) -> T {
        let J = F.determinant();
        let psi = self.0.energy(invariants(&F.tr_mul(F), J));
        match M::DOMAIN {
            Domain::Everywhere => psi,
            Domain::PositiveDeterminant => infinite_unless_positive(J, psi),
        }
    }

    #[inline(always)]
    fn stress<T: Real>(&self, F: &Mat<T, 3>) -> Mat<T, 3> {
        let (C, J) = (F.tr_mul(F), F.determinant());
        let [g1, g2, g3] = self.0.gradient(invariants(&C, J));
        let two = T::from_f64(2.0);
        F.scale(two * g1) + (*F * C).scale(two * two * g2) + F.cofactor().scale(two * g3 * J)
    }

    #[inline(always)]
    fn stress_differential<T: Real>(&self, F: &Mat<T, 3>, dF: &Mat<T, 3>) -> Mat<T, 3> {
        let (C, J, cof) = (F.tr_mul(F), F.determinant(), F.cofactor());
        let at = invariants(&C, J);
        let [g1, g2, g3] = self.0.gradient(at);
        let [h11, h12, h13, h22, h23, h33] = self.0.hessian(at);
        let (two, four) = (T::from_f64(2.0), T::from_f64(4.0));
        let slopes = [F.scale(two), (*F * C).scale(four), cof.scale(two * J)];
        let [a, b, c] = [slopes[0].dot(dF), slopes[1].dot(dF), slopes[2].dot(dF)];
        let dC = dF.tr_mul(F) + F.tr_mul(dF);
        slopes[0].scale(h11 * a + h12 * b + h13 * c)
            + slopes[1].scale(h12 * a + h22 * b + h23 * c)
            + slopes[2].scale(h13 * a + h23 * b + h33 * c)
            + dF.scale(two * g1)
            + (*dF * C + *F * dC).scale(four * g2)
            + (cof.scale(cof.dot(dF)) + F.cofactor_differential(dF).scale(J)).scale(two * g3)
    }

    #[inline(always)]
    fn stress_derivative<T: Real>(&self, F: &Mat<T, 3>) -> Tensor4<T, 3> {
        let (C, J, cof) = (F.tr_mul(F), F.determinant(), F.cofactor());
        let at = invariants(&C, J);
        let [g1, g2, g3] = self.0.gradient(at);
        let [h11, h12, h13, h22, h23, h33] = self.0.hessian(at);
        let (two, four) = (T::from_f64(2.0), T::from_f64(4.0));
        let s = [F.scale(two), (*F * C).scale(four), cof.scale(two * J)];
        Terms::new()
            .identity(two * g1)
            .right(&C.scale(four * g2))
            .left(&F.mul_tr(F).scale(four * g2))
            .transposed(four * g2, F, F)
            .outer(two * g3, &cof, &cof)
            .cofactor(two * g3 * J, F)
            .outer(T::one(), &s[0], &sum(&s, [h11, h12, h13]))
            .outer(T::one(), &s[1], &sum(&s, [h12, h22, h23]))
            .outer(T::one(), &s[2], &sum(&s, [h13, h23, h33]))
            .0
    }
}
