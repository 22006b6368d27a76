//! Linear, quadratic and cubic B-splines with first and second derivatives
//! (document 001, alg. 4: the Laplacian needs the cubic one).
//!
//! Nodes sit at `h (i, j, k)`. A particle at `x` sees, on every axis, the `WIDTH` nodes that start
//! at `base`; `f = x/h − base` is its distance from the first of them in cells.

use crate::float::Float;
use core::marker::PhantomData;
use core::ops::{Add, Mul, Sub};
use fem_kinematics::Quad;

/// What the polynomials of a kernel are computed with: a number, or one for each axis.
pub trait Number: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The nearest number.
    fn nearest(value: f64) -> Self;
}
impl<T: Float> Number for T {
    #[inline(always)]
    fn nearest(value: f64) -> Self {
        T::from_f64(value)
    }
}

/// A number for each axis, side by side.
#[derive(Clone, Copy)]
pub(crate) struct Axes<Q, T>(pub Q, PhantomData<T>);
impl<Q, T> Axes<Q, T> {
    #[inline(always)]
    pub(crate) const fn new(axes: Q) -> Self {
        Self(axes, PhantomData)
    }
}
impl<Q: Add<Output = Q>, T> Add for Axes<Q, T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.0 + o.0)
    }
}
impl<Q: Sub<Output = Q>, T> Sub for Axes<Q, T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.0 - o.0)
    }
}
impl<Q: Mul<Output = Q>, T> Mul for Axes<Q, T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self::new(self.0 * o.0)
    }
}
impl<Q: Quad<T>, T: Float> Number for Axes<Q, T> {
    #[inline(always)]
    fn nearest(value: f64) -> Self {
        Self::new(Q::splat(T::from_f64(value)))
    }
}

/// One of the three B-splines, on one axis and in units of the cell size.
///
/// All arrays have four entries so that one type serves the three widths; entries from `WIDTH`
/// on are zero.
pub trait Spline: Copy + Send + Sync + 'static {
    /// Nodes per axis under the kernel.
    const WIDTH: usize;
    /// `base = ⌊x/h − SHIFT⌋`.
    const SHIFT: f64;
    /// `Σ w (x_i − x_p)² / h²`, which does not depend on the particle for the quadratic and the
    /// cubic kernel; `None` for the linear one, where it does.
    const INERTIA: Option<f64>;
    /// N at the `WIDTH` nodes.
    fn values<N: Number>(f: N) -> [N; 4];
    /// dN/d(x/h) at the `WIDTH` nodes.
    fn first<N: Number>(f: N) -> [N; 4];
    /// d²N/d(x/h)² at the `WIDTH` nodes.
    fn second<N: Number>(f: N) -> [N; 4];
}

/// Hat functions, two nodes per axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linear;
/// Three nodes per axis, continuous gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quadratic;
/// Four nodes per axis, continuous second derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cubic;

impl Spline for Linear {
    const WIDTH: usize = 2;
    const SHIFT: f64 = 0.0;
    const INERTIA: Option<f64> = None;
    #[inline(always)]
    fn values<N: Number>(f: N) -> [N; 4] {
        [N::nearest(1.0) - f, f, N::nearest(0.0), N::nearest(0.0)]
    }
    #[inline(always)]
    fn first<N: Number>(_: N) -> [N; 4] {
        [-1.0, 1.0, 0.0, 0.0].map(N::nearest)
    }
    #[inline(always)]
    fn second<N: Number>(_: N) -> [N; 4] {
        [N::nearest(0.0); 4]
    }
}

impl Spline for Quadratic {
    const WIDTH: usize = 3;
    const SHIFT: f64 = 0.5;
    const INERTIA: Option<f64> = Some(0.25);
    #[inline(always)]
    fn values<N: Number>(f: N) -> [N; 4] {
        let c = N::nearest;
        let (a, b, e) = (c(1.5) - f, f - c(1.0), f - c(0.5));
        [c(0.5) * a * a, c(0.75) - b * b, c(0.5) * e * e, c(0.0)]
    }
    #[inline(always)]
    fn first<N: Number>(f: N) -> [N; 4] {
        let c = N::nearest;
        [f - c(1.5), c(-2.0) * (f - c(1.0)), f - c(0.5), c(0.0)]
    }
    #[inline(always)]
    fn second<N: Number>(_: N) -> [N; 4] {
        [1.0, -2.0, 1.0, 0.0].map(N::nearest)
    }
}

impl Spline for Cubic {
    const WIDTH: usize = 4;
    const SHIFT: f64 = 1.0;
    const INERTIA: Option<f64> = Some(1.0 / 3.0);
    #[inline(always)]
    fn values<N: Number>(f: N) -> [N; 4] {
        let c = N::nearest;
        let t = f - c(1.0);
        let s = c(1.0) - t;
        let sixth = c(1.0 / 6.0);
        [
            s * s * s * sixth,
            ((c(3.0) * t - c(6.0)) * t * t + c(4.0)) * sixth,
            ((c(3.0) * s - c(6.0)) * s * s + c(4.0)) * sixth,
            t * t * t * sixth,
        ]
    }
    #[inline(always)]
    fn first<N: Number>(f: N) -> [N; 4] {
        let c = N::nearest;
        let t = f - c(1.0);
        let s = c(1.0) - t;
        let half = c(0.5);
        [
            c(-0.5) * s * s,
            half * t * (c(3.0) * t - c(4.0)),
            c(-0.5) * s * (c(3.0) * s - c(4.0)),
            half * t * t,
        ]
    }
    #[inline(always)]
    fn second<N: Number>(f: N) -> [N; 4] {
        let c = N::nearest;
        let t = f - c(1.0);
        let s = c(1.0) - t;
        [s, c(3.0) * t - c(2.0), c(3.0) * s - c(2.0), t]
    }
}

/// First node of the stencil and distance from it in cells, on every axis.
#[inline(always)]
pub fn locate<K: Spline, T: Float, const D: usize>(x: &[T; D], h: T) -> ([i32; D], [T; D]) {
    let mut base = [0; D];
    let mut f = [T::zero(); D];
    for a in 0..D {
        let y = x[a] / h;
        base[a] = (y - T::from_f64(K::SHIFT)).floor_to_i32();
        f[a] = y - T::from_f64(f64::from(base[a]));
    }
    (base, f)
}

/// The nodes under one particle and the one-dimensional factors of their weights.
///
/// `N_i(x_p) = w[0][i] w[1][j] w[2][k]`; one factor of `dw` (1/m) or `ddw` (1/m²) in place of `w`
/// gives a first or second derivative. Derivatives are with respect to x, in meters.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<T, const D: usize> {
    /// First node on each axis.
    pub base: [i32; D],
    /// N.
    pub w: [[T; 4]; D],
    /// dN/dx, 1/m.
    pub dw: [[T; 4]; D],
    /// d²N/dx², 1/m².
    pub ddw: [[T; 4]; D],
}

impl<T: Float, const D: usize> Stencil<T, D> {
    /// The stencil of the particle at `x` (m) on a grid of cell size `h` (m).
    #[inline(always)]
    pub fn new<K: Spline>(x: &[T; D], h: T) -> Self {
        let (base, f) = locate::<K, T, D>(x, h);
        let per_h = T::one() / h;
        Self {
            base,
            w: core::array::from_fn(|a| K::values(f[a])),
            dw: core::array::from_fn(|a| K::first(f[a]).map(|v| v * per_h)),
            ddw: core::array::from_fn(|a| K::second(f[a]).map(|v| v * per_h * per_h)),
        }
    }

    /// N at stencil node `n` (its position in the stencil on each axis).
    #[inline(always)]
    pub fn weight(&self, n: [usize; D]) -> T {
        let mut product = self.w[0][n[0]];
        for a in 1..D {
            product *= self.w[a][n[a]];
        }
        product
    }

    /// ∇N at stencil node `n`, 1/m.
    #[inline(always)]
    pub fn gradient(&self, n: [usize; D]) -> [T; D] {
        core::array::from_fn(|axis| {
            let mut product = self.dw[axis][n[axis]];
            for a in 0..D {
                if a != axis {
                    product *= self.w[a][n[a]];
                }
            }
            product
        })
    }

    /// ΔN at stencil node `n`, 1/m² (document 001, alg. 4, line 5).
    #[inline(always)]
    pub fn laplacian(&self, n: [usize; D]) -> T {
        // ERRATUM: N'' is with respect to x and carries 1/h².
        let mut sum = T::zero();
        for axis in 0..D {
            let mut product = self.ddw[axis][n[axis]];
            for a in 0..D {
                if a != axis {
                    product *= self.w[a][n[a]];
                }
            }
            sum += product;
        }
        sum
    }
}

/// Calls `visit` with the position of every node in a stencil of `width` nodes per axis, the
/// last axis fastest.
#[inline(always)]
pub fn for_each_node<const D: usize>(width: usize, mut visit: impl FnMut([usize; D])) {
    let mut n = [0; D];
    let count = width.pow(D as u32);
    for _ in 0..count {
        visit(n);
        for a in (0..D).rev() {
            n[a] += 1;
            if n[a] < width {
                break;
            }
            n[a] = 0;
        }
    }
}
