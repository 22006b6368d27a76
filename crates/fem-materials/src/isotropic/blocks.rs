//! dP/dF of an isotropic model at a diagonal F̂: one D×D block and one 2×2 block for each pair.

use crate::tensor_terms::Terms;
use fem_kinematics::HessianProjection;
use fem_kinematics::{Mat, Real, Svd, Tensor4, signed_svd, vector};

/// The pairs of axes, in the order of the blocks B₁₂, B₁₃, B₂₃; in 2D only the first.
pub const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// The non-zero entries of ∂P/∂F at F̂ = diag(σ), in the order 11, 22, 33, 12, 21, 13, 31, 23, 32:
/// A, then [[α, β], [β, α]] for each pair (document 000, 4.5; document 004).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalBlocks<T, const D: usize> {
    /// A: ∂P̂ᵢᵢ/∂F̂ⱼⱼ, symmetric.
    pub A: Mat<T, D>,
    /// ∂P̂ᵢⱼ/∂F̂ᵢⱼ for each of [`PAIRS`].
    pub alpha: [T; 3],
    /// ∂P̂ᵢⱼ/∂F̂ⱼᵢ for each of [`PAIRS`].
    pub beta: [T; 3],
}

/// The symmetric 3×3 matrices α, β, γ of documents 000 and 004.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaBetaGamma<T> {
    /// α.
    pub alpha: Mat<T, 3>,
    /// β.
    pub beta: Mat<T, 3>,
    /// γ.
    pub gamma: Mat<T, 3>,
}

impl<T: Real> AlphaBetaGamma<T> {
    /// Aᵢⱼ = γᵢⱼ + δᵢⱼ (αᵢᵢ + βᵢᵢ), B from αᵢⱼ and βᵢⱼ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn blocks(&self) -> DiagonalBlocks<T, 3> {
        let mut A = self.gamma;
        for i in 0..3 {
            A.0[i][i] += self.alpha.0[i][i] + self.beta.0[i][i];
        }
        DiagonalBlocks {
            A,
            alpha: vector(|n| self.alpha.0[PAIRS[n].0][PAIRS[n].1]),
            beta: vector(|n| self.beta.0[PAIRS[n].0][PAIRS[n].1]),
        }
    }
}

impl<T: Real, const D: usize> DiagonalBlocks<T, D> {
    /// Picks the blocks out of ∂P/∂F at a diagonal F̂.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_tensor(derivative: &Tensor4<T, D>) -> Self {
        let (mut alpha, mut beta) = ([T::zero(); 3], [T::zero(); 3]);
        for n in 0..pairs::<D>() {
            let (i, j) = PAIRS[n];
            alpha[n] = derivative.get(i, j, i, j);
            beta[n] = derivative.get(i, j, j, i);
        }
        Self {
            A: Mat::from_fn(|i, j| derivative.get(i, i, j, j)),
            alpha,
            beta,
        }
    }

    /// Negative eigenvalues of every block treated as `projection` says; the eigenvalues of the
    /// blocks are those of the whole tensor.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn projected(&self, projection: HessianProjection) -> Self {
        let mut out = Self {
            A: projection.matrix(&self.A),
            ..*self
        };
        for n in 0..pairs::<D>() {
            (out.alpha[n], out.beta[n]) = projection.twin(self.alpha[n], self.beta[n]);
        }
        out
    }

    /// dP̂ for dF̂, both in the frame of the singular vectors.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(&self, dF_hat: &Mat<T, D>) -> Mat<T, D> {
        let mut dP = Mat::zeros();
        for i in 0..D {
            for j in 0..D {
                dP.0[i][i] += self.A.0[i][j] * dF_hat.0[j][j];
            }
        }
        for n in 0..pairs::<D>() {
            let (i, j) = PAIRS[n];
            let (a, b) = (self.alpha[n], self.beta[n]);
            dP.0[i][j] = a * dF_hat.0[i][j] + b * dF_hat.0[j][i];
            dP.0[j][i] = b * dF_hat.0[i][j] + a * dF_hat.0[j][i];
        }
        dP
    }

    /// ∂P/∂F at F̂ itself.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn to_tensor(&self) -> Tensor4<T, D> {
        Tensor4::from_linear_map(|dF_hat| self.apply(dF_hat))
    }

    /// ∂P/∂F at F = U F̂ Vᵀ: dP = U {blocks : Uᵀ dF V} Vᵀ.
    // ERRATUM: documents 000 and 004 print the right-hand side as a tensor that is contracted
    // with dF once more.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rotated(&self, svd: &Svd<T, D>) -> Tensor4<T, D> {
        let mut terms = Terms::new();
        for i in 0..D {
            let mut row = Mat::zeros();
            for j in 0..D {
                row += axes(svd, j, j).scale(self.A.0[i][j]);
            }
            terms = terms.outer(T::one(), &axes(svd, i, i), &row);
        }
        for n in 0..pairs::<D>() {
            let (i, j) = PAIRS[n];
            let (X, Y) = (axes(svd, i, j), axes(svd, j, i));
            let (a, b) = (self.alpha[n], self.beta[n]);
            terms = terms.outer(T::one(), &X, &(X.scale(a) + Y.scale(b))).outer(
                T::one(),
                &Y,
                &(X.scale(b) + Y.scale(a)),
            );
        }
        terms.0
    }
}

/// uᵢ vⱼᵀ.
#[inline(always)]
fn axes<T: Real, const D: usize>(svd: &Svd<T, D>, i: usize, j: usize) -> Mat<T, D> {
    Mat::outer(svd.U.column(i), svd.V.column(j))
}

/// How many pairs of axes there are.
#[inline(always)]
const fn pairs<const D: usize>() -> usize {
    D * (D - 1) / 2
}

/// The projected ∂P/∂F of any isotropic model from its ∂P/∂F at diag(σ): exact, by one 3×3 and three 2×2
/// eigenvalue problems. Compiled once for each scalar, as [`rotated`], for the instructions of every
/// processor: projections are taken of one element at a time, not of packs.
#[inline(never)]
pub(crate) fn reassembled<T: Real, const D: usize>(
    derivative: &Tensor4<T, D>,
    svd: &Svd<T, D>,
    projection: HessianProjection,
) -> Tensor4<T, D> {
    rotated_in_place(&DiagonalBlocks::from_tensor(derivative), svd, projection)
}

/// [`rotated_in_place`], as a function.
#[inline(never)]
pub(crate) fn rotated<T: Real, const D: usize>(
    blocks: &DiagonalBlocks<T, D>,
    svd: &Svd<T, D>,
    projection: HessianProjection,
) -> Tensor4<T, D> {
    rotated_in_place(blocks, svd, projection)
}

/// The projected ∂P/∂F of these blocks at diag(σ).
#[inline(always)]
pub(crate) fn rotated_in_place<T: Real, const D: usize>(
    blocks: &DiagonalBlocks<T, D>,
    svd: &Svd<T, D>,
    projection: HessianProjection,
) -> Tensor4<T, D> {
    match projection {
        HessianProjection::None => blocks.rotated(svd),
        _ => blocks.projected(projection).rotated(svd),
    }
}

/// The projected ∂P/∂F of any isotropic model, given its ∂P/∂F at a diagonal F̂: one SVD, and what the
/// frame of its vectors needs.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn projected<T: Real, const D: usize>(
    F: &Mat<T, D>,
    projection: HessianProjection,
    derivative_at: impl FnOnce(&Mat<T, D>) -> Tensor4<T, D>,
) -> Tensor4<T, D> {
    let svd = signed_svd(F);
    let derivative = derivative_at(&Mat::from_diagonal(svd.sigma));
    reassembled(&derivative, &svd, projection)
}
