//! The signed singular value decomposition and its derivatives.

use crate::frame::{orthogonalize, polish, safe_scale};
use crate::jacobi::{cyclic_jacobi, descending, negligible_square};
use crate::mat::Mat;
use crate::scalar::Real;

/// F = U diag(σ) Vᵀ with U and V rotations (det +1) and σ₁ ≥ … ≥ |σ_D|; the last value carries
/// the sign of det F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Svd<T, const D: usize> {
    /// U, a rotation.
    pub U: Mat<T, D>,
    /// The signed singular values.
    pub sigma: [T; D],
    /// V, a rotation.
    pub V: Mat<T, D>,
}

impl<T: Real, const D: usize> Svd<T, D> {
    /// U diag(d) Vᵀ: with `self.sigma` this is F itself.
    #[inline(always)]
    pub fn compose(&self, d: [T; D]) -> Mat<T, D> {
        Mat::from_fn(|i, j| self.U.0[i][j] * d[j]).mul_tr(&self.V)
    }
    /// U X Vᵀ, from principal axes to the world.
    #[inline(always)]
    pub fn to_world(&self, X: &Mat<T, D>) -> Mat<T, D> {
        (self.U * *X).mul_tr(&self.V)
    }
    /// Uᵀ X V, from the world to principal axes.
    #[inline(always)]
    pub fn to_principal(&self, X: &Mat<T, D>) -> Mat<T, D> {
        self.U.tr_mul(X) * self.V
    }
}

/// The signed singular value decomposition of any finite F, of any rank and scale.
///
/// No branches and a fixed number of sweeps, so lanes and dual numbers run the same code. The
/// error is a few ε|F| (backward stable, also with small singular values). Where values repeat,
/// U and V are one of the many valid choices.
///
/// Derivatives by dual numbers are those of σ, U and V where these exist, and finite elsewhere.
///
/// ```
/// use fem_kinematics::{Mat, signed_svd};
/// let svd = signed_svd(&Mat([[0.0, -2.0], [-3.0, 0.0_f64]]));
/// assert_eq!(svd.sigma, [3.0, -2.0]);
/// ```
#[inline(always)]
pub fn signed_svd<T: Real, const D: usize>(F: &Mat<T, D>) -> Svd<T, D> {
    let (scale, inverse) = safe_scale(F);
    let A = F.scale(scale);
    let mut svd = if D == 2 {
        let (U, sigma, V) = svd2(A.0[0][0], A.0[0][1], A.0[1][0], A.0[1][1]);
        Svd {
            U: Mat::from_fn(|i, j| U.0[i][j]),
            sigma: core::array::from_fn(|i| sigma[i]),
            V: Mat::from_fn(|i, j| V.0[i][j]),
        }
    } else {
        svd3(&A)
    };
    sort_magnitudes(&mut svd.sigma);
    svd.sigma = svd.sigma.map(|x| x * inverse);
    svd
}

/// Puts values in order that rounding left equal but for an ulp. It exchanges and does not
/// clamp: the derivative of a symmetric function of them stays right.
#[inline(always)]
fn sort_magnitudes<T: Real, const D: usize>(sigma: &mut [T; D]) {
    let zero = T::zero();
    let mut exchange = |i: usize| {
        let (a, b) = (sigma[i], sigma[i + 1]);
        let magnitude = T::select(b.lt(zero), -b, b);
        let swap = a.lt(magnitude);
        sigma[i] = T::select(swap, magnitude, a);
        sigma[i + 1] = T::select(swap, T::select(b.lt(zero), -a, a), b);
    };
    if D == 3 {
        exchange(0);
        exchange(1);
        exchange(0);
    } else {
        exchange(0);
    }
}

/// 2×2: F = p·rotation(α) + q·reflection(β), and U, V turn by (β ± α)/2.
#[inline(always)]
fn svd2<T: Real>(a: T, b: T, c: T, d: T) -> (Mat<T, 2>, [T; 2], Mat<T, 2>) {
    let (zero, one) = (T::zero(), T::one());
    let (e, h, f, g) = (a + d, c - b, a - d, b + c);
    // The direction of twice V's angle.
    let (x, y) = (e * f + h * g, e * g - h * f);
    let square = x * x + y * y;
    let needed = negligible_square::<T>().lt(square);
    let r = T::select(needed, square, one).sqrt();
    let right = zero.le(x);
    let cosine = T::select(right, r + x, y);
    let sine = T::select(right, y, r - x);
    let length = T::select(needed, cosine * cosine + sine * sine, one)
        .sqrt()
        .recip();
    let cosine = T::select(needed, cosine * length, one);
    let sine = T::select(needed, sine * length, zero);
    let V = Mat([[cosine, -sine], [sine, cosine]]);
    let frame = orthogonalize(&(Mat([[a, b], [c, d]]) * V));
    (frame.Q, [frame.R.0[0][0], frame.R.0[1][1]], V)
}

/// V from the eigenvectors of FᵀF, then U R = F V, whose trailing 2×2 block is diagonalised once
/// more: FᵀF has squared away what it knew of the small singular values.
#[inline(always)]
fn svd3<T: Real, const D: usize>(A: &Mat<T, D>) -> Svd<T, D> {
    let (values, V) = cyclic_jacobi(A.tr_mul(A).0, 4 + T::DERIVATIVES);
    let (_, V) = descending(values, V);
    let V = orthogonalize(&Mat(V)).Q;
    let frame = orthogonalize(&(*A * V));
    let R = &frame.R.0;
    let (u, small, v) = svd2(R[1][1], R[1][2], R[2][1], R[2][2]);
    let turn = |M: &Mat<T, D>, r: &Mat<T, 2>| {
        Mat::from_fn(|i, j| {
            if j == 0 {
                M.0[i][0]
            } else {
                M.0[i][1] * r.0[0][j - 1] + M.0[i][2] * r.0[1][j - 1]
            }
        })
    };
    let mut sigma = [R[0][0]; D];
    sigma[1] = small[0];
    sigma[2] = small[1];
    Svd {
        U: polish(&turn(&frame.Q, &u)),
        sigma,
        V: polish(&turn(&V, &v)),
    }
}
