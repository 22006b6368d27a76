//! The signed singular value decomposition and its derivatives.

use crate::checked::Checked;
use crate::frame::{orthogonalize, polish, safe_scale};
use crate::jacobi::{cyclic_jacobi, descending, negligible_square};
use crate::mat::{Mat, vector};
use crate::scalar::Real;
use crate::tensor4::Tensor4;

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
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn compose(&self, d: [T; D]) -> Mat<T, D> {
        Mat::from_fn(|i, j| self.U.0[i][j] * d[j]).mul_tr(&self.V)
    }
    /// U X Vᵀ, from principal axes to the world.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn to_world(&self, X: &Mat<T, D>) -> Mat<T, D> {
        (self.U * *X).mul_tr(&self.V)
    }
    /// Uᵀ X V, from the world to principal axes.
    #[cfg_attr(not(debug_assertions), inline(always))]
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
    T::signed_svd(F)
}

/// [`signed_svd`] in place. Numbers and registers call it instead, compiled once for each kind of them: a
/// call is nothing beside a decomposition, and in place it would be most of the code of a material that
/// asks for one.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn in_place<T: Real, const D: usize>(F: &Mat<T, D>) -> Svd<T, D> {
    let (scale, inverse) = safe_scale(F);
    let A = F.scale(scale);
    let mut svd = if D == 2 {
        let (U, sigma, V) = svd2(A.0[0][0], A.0[0][1], A.0[1][0], A.0[1][1]);
        Svd {
            U: Mat::from_fn(|i, j| U.0[i][j]),
            sigma: vector(|i| sigma[i]),
            V: Mat::from_fn(|i, j| V.0[i][j]),
        }
    } else {
        svd3(&A)
    };
    sort_magnitudes(&mut svd.sigma);
    svd.sigma = vector(|i| svd.sigma[i] * inverse);
    svd
}

/// [`in_place`], as a function.
#[inline(never)]
pub(crate) fn called<T: Real, const D: usize>(F: &Mat<T, D>) -> Svd<T, D> {
    in_place(F)
}

/// Puts values in order that rounding left equal but for an ulp. It exchanges and does not
/// clamp: the derivative of a symmetric function of them stays right.
#[cfg_attr(not(debug_assertions), inline(always))]
fn sort_magnitudes<T: Real, const D: usize>(sigma: &mut [T; D]) {
    exchange_magnitudes(sigma, 0);
    if D == 3 {
        exchange_magnitudes(sigma, 1);
        exchange_magnitudes(sigma, 0);
    }
}

/// Makes σᵢ ≥ |σᵢ₊₁|; the sign stays behind.
#[inline(always)]
fn exchange_magnitudes<T: Real, const D: usize>(sigma: &mut [T; D], i: usize) {
    let (a, b) = (sigma[i], sigma[i + 1]);
    let negative = b.lt(T::zero());
    let magnitude = T::select(negative, -b, b);
    let swap = a.lt(magnitude);
    sigma[i] = T::select(swap, magnitude, a);
    sigma[i + 1] = T::select(swap, T::select(negative, -a, a), b);
}

/// 2×2: F = p·rotation(α) + q·reflection(β), and U, V turn by (β ± α)/2.
#[cfg_attr(not(debug_assertions), inline(always))]
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

/// V from the eigenvectors of FᵀF, then U R = F V, whose trailing 2×2 block is diagonalized once
/// more: FᵀF has squared away what it knew of the small singular values.
#[cfg_attr(not(debug_assertions), inline(always))]
fn svd3<T: Real, const D: usize>(A: &Mat<T, D>) -> Svd<T, D> {
    let (values, V) = cyclic_jacobi(A.tr_mul(A).0, 4 + T::DERIVATIVES);
    let (_, V) = descending(values, V);
    let V = orthogonalize(&Mat(V)).Q;
    let frame = orthogonalize(&(*A * V));
    let R = &frame.R.0;
    let (u, small, v) = svd2(R[1][1], R[1][2], R[2][1], R[2][2]);
    let mut sigma = [R[0][0]; D];
    sigma[1] = small[0];
    sigma[2] = small[1];
    Svd {
        U: polish(&turn(&frame.Q, &u)),
        sigma,
        V: polish(&turn(&V, &v)),
    }
}

/// M with its last two columns turned by r.
#[inline(always)]
fn turn<T: Real, const D: usize>(M: &Mat<T, D>, r: &Mat<T, 2>) -> Mat<T, D> {
    let mut turned = *M;
    for i in 0..D {
        for j in 0..2 {
            turned.0[i][j + 1] = M.0[i][1] * r.0[0][j] + M.0[i][2] * r.0[1][j];
        }
    }
    turned
}

/// Differentials of a signed singular value decomposition; U and V turn by skew matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SvdDifferential<T, const D: usize> {
    /// dU.
    pub dU: Mat<T, D>,
    /// dσ.
    pub dsigma: [T; D],
    /// dV.
    pub dV: Mat<T, D>,
}

impl<T: Real, const D: usize> Svd<T, D> {
    /// ∂σₙ/∂F = uₙ vₙᵀ, n = 0 … D − 1. Of a repeated value it is one of the directional
    /// derivatives; the sum over equal values is always right.
    #[inline(always)]
    pub fn sigma_gradient(&self, n: usize) -> Mat<T, D> {
        Mat::outer(self.U.column(n), self.V.column(n))
    }
    /// dU, dσ and dV in direction dF.
    ///
    /// With M = Uᵀ dF V: dσᵢ = Mᵢᵢ; UᵀdU = A + B and VᵀdV = A − B with
    /// Aᵢⱼ = (Mᵢⱼ + Mⱼᵢ)/(2(σⱼ − σᵢ)) and Bᵢⱼ = (Mᵢⱼ − Mⱼᵢ)/(2(σⱼ + σᵢ)).
    /// The result exists where all |σ| differ; a rate whose denominator vanishes to rounding is
    /// set to zero.
    #[inline(always)]
    pub fn differential(&self, dF: &Mat<T, D>) -> Checked<SvdDifferential<T, D>, T::Mask> {
        let M = self.to_principal(dF);
        let rounding = self.sigma[0] * T::from_f64(8.0 * T::EPSILON);
        let (zero, one, half) = (T::zero(), T::one(), T::from_f64(0.5));
        let mut exists = rounding.lt(self.sigma[0]);
        let (mut u, mut v) = (Mat::<T, D>::zeros(), Mat::<T, D>::zeros());
        for i in 0..D {
            for j in i + 1..D {
                let (gap, sum) = (self.sigma[j] - self.sigma[i], self.sigma[j] + self.sigma[i]);
                // σᵢ ≥ |σⱼ|, so that the sum has no sign.
                let (apart, upright) = (rounding.lt(gap.abs()), rounding.lt(sum));
                exists = exists & apart & upright;
                let a = T::select(apart, (M.0[i][j] + M.0[j][i]) * half, zero)
                    / T::select(apart, gap, one);
                let b = T::select(upright, (M.0[i][j] - M.0[j][i]) * half, zero)
                    / T::select(upright, sum, one);
                u.0[i][j] = a + b;
                u.0[j][i] = -(a + b);
                v.0[i][j] = a - b;
                v.0[j][i] = -(a - b);
            }
        }
        Checked {
            value: SvdDifferential {
                dU: self.U * u,
                dsigma: vector(|i| M.0[i][i]),
                dV: self.V * v,
            },
            exists,
        }
    }
    /// ∂U/∂F; see [`Svd::differential`].
    #[inline(always)]
    pub fn u_derivative(&self) -> Checked<Tensor4<T, D>, T::Mask> {
        Checked {
            value: Tensor4::from_linear_map(|dF| self.differential(dF).value.dU),
            exists: self.differential(&Mat::zeros()).exists,
        }
    }
    /// ∂V/∂F; see [`Svd::differential`].
    #[inline(always)]
    pub fn v_derivative(&self) -> Checked<Tensor4<T, D>, T::Mask> {
        Checked {
            value: Tensor4::from_linear_map(|dF| self.differential(dF).value.dV),
            exists: self.differential(&Mat::zeros()).exists,
        }
    }
}
