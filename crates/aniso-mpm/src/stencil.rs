//! The nodes under a particle in registers: one quadruple for the axes, one for each node.
//!
//! Plain loops, no closures, see [`Quad`]. What depends on a plane or a row alone is multiplied once
//! for it. Places in the stencil are small whole numbers: counting them takes additions where
//! distances from the particle take products.

use crate::float::Float;
use crate::kernels::{Axes, Spline};
use crate::transfer::Scheme;
use crate::window::{Node, row_start, window_start};
use fem_kinematics::{Mat, Quad};

/// Where a particle lies in its stencil, and the one-dimensional factors of its weights.
pub(crate) struct Factors<T> {
    /// Position in the window of the first node.
    start: usize,
    /// Distance from the first node on each axis, cells.
    f: [T; 4],
    /// N at place k on each axis.
    w: [[T; 4]; 4],
    /// dN/dx, 1/m; used by schemes with the kernel's gradient.
    dw: [[T; 4]; 4],
}

impl<T: Float> Factors<T> {
    /// Of the particle at x (m), in a window whose first node is `origin`, on a grid of cell size h (m).
    #[inline(always)]
    pub(crate) fn new<Q: Quad<T>, S: Scheme, const D: usize>(x: Q, h: T, origin: [i32; D]) -> Self {
        // As `kernels::locate`, which sorts the particles: a particle lies in the window of its block.
        let y = x / Q::splat(h);
        let base = (y - Q::splat(T::from_f64(S::Kernel::SHIFT))).floor();
        let f = y - base;
        let places = base.to_integers();
        let mut first = [0; D];
        first.copy_from_slice(&places[..D]);
        let mut factors = Self {
            start: window_start::<S::Kernel, D>(first, origin),
            f: [T::zero(); 4],
            w: [[T::zero(); 4]; 4],
            dw: [[T::zero(); 4]; 4],
        };
        f.store(&mut factors.f);
        let w = S::Kernel::values(Axes::new(f));
        for k in 0..S::Kernel::WIDTH {
            w[k].0.store(&mut factors.w[k]);
        }
        if S::KERNEL_GRADIENT {
            let per_h = Q::splat(T::one() / h);
            let dw = S::Kernel::first(Axes::new(f));
            for k in 0..S::Kernel::WIDTH {
                (dw[k].0 * per_h).store(&mut factors.dw[k]);
            }
        }
        factors
    }
}

/// The entries of a row, and zeros behind them.
#[inline(always)]
pub(crate) fn load_axes<Q: Quad<T>, T: Float, const D: usize>(from: &[T; D]) -> Q {
    if let (3, Some(three)) = (D, from.first_chunk::<3>()) {
        return Q::load_three(three);
    }
    let mut four = [T::zero(); 4];
    four[..D].copy_from_slice(from);
    Q::load(&four)
}

/// The first D numbers.
#[inline(always)]
pub(crate) fn store_axes<Q: Quad<T>, T: Float, const D: usize>(axes: Q, to: &mut [T; D]) {
    if D == 3
        && let Some(three) = to.first_chunk_mut::<3>()
    {
        return axes.store_three(three);
    }
    let mut four = [T::zero(); 4];
    axes.store(&mut four);
    to.copy_from_slice(&four[..D]);
}

/// The rows of a matrix, zeros behind them.
#[inline(always)]
pub(crate) fn rows<Q: Quad<T>, T: Float, const D: usize>(m: &Mat<T, D>) -> [Q; D] {
    let mut rows = [Q::splat(T::zero()); D];
    for c in 0..D {
        rows[c] = load_axes(&m.0[c]);
    }
    rows
}

/// Writes the matrix with these rows.
#[inline(always)]
pub(crate) fn store_rows<Q: Quad<T>, T: Float, const D: usize>(rows: &[Q; D], to: &mut Mat<T, D>) {
    // The fourth number of a row lies where the next row begins, and that is written after it.
    for c in 0..D {
        let flat = &mut to.0.as_flattened_mut()[c * D..];
        match flat.first_chunk_mut::<4>() {
            Some(four) if D == 3 => rows[c].store(four),
            _ => store_axes(rows[c], &mut to.0[c]),
        }
    }
}

/// The columns of the matrix with these rows, or the other way round.
#[inline(always)]
pub(crate) fn transposed<Q: Quad<T>, T: Float, const D: usize>(rows: &[Q; D]) -> [Q; D] {
    let mut four = [Q::splat(T::zero()); 4];
    four[..D].copy_from_slice(rows);
    let four = Q::transposed(four);
    let mut columns = *rows;
    columns.copy_from_slice(&four[..D]);
    columns
}

/// What goes with the factors N, N i_a and ∂N/∂x_a of the node with the place i in the stencil:
/// for a node the value `N (constant + Σ_a i_a slope[a]) + Σ_a ∂N/∂x_a by_dw[a]`, or the sums of the
/// nodes' values times these factors.
pub(crate) struct StencilTerms<Q, const D: usize> {
    pub constant: Q,
    pub slope: [Q; D],
    pub by_dw: [Q; D],
}

impl<Q: Copy, const D: usize> StencilTerms<Q, D> {
    /// `N (rigid + Σ_a (x_i − x_p)_a affine_a) + Σ_a ∂N/∂x_a by_dw_a`; the columns of `affine` are those
    /// of a step of one cell.
    #[inline(always)]
    pub(crate) fn new<T: Float>(
        factors: &Factors<T>,
        rigid: Q,
        affine: [Q; D],
        by_dw: [Q; D],
    ) -> Self
    where
        Q: Quad<T>,
    {
        let mut constant = rigid;
        for a in 0..D {
            constant = constant - Q::splat(factors.f[a]) * affine[a];
        }
        Self {
            constant,
            slope: affine,
            by_dw,
        }
    }

    /// Sums over the nodes as `Σ N value (x_i − x_p)_a`, cells.
    #[inline(always)]
    pub(crate) fn moments<T: Float>(&self, factors: &Factors<T>) -> [Q; D]
    where
        Q: Quad<T>,
    {
        let mut moments = self.slope;
        for a in 0..D {
            moments[a] = moments[a] - Q::splat(factors.f[a]) * self.constant;
        }
        moments
    }
}

/// The nodes of a window from the first to the last of a stencil: a length that the compiler knows, so
/// that it checks the bounds once.
#[inline(always)]
fn span<K: Spline, const D: usize>() -> usize {
    row_start::<K, D>(0, K::WIDTH - 1, K::WIDTH - 1) + K::WIDTH
}

/// Adds values to the nodes under a particle, `by_dw` only with the kernel's gradient.
///
/// One product and two additions for each node, and one product more with the kernel's gradient.
#[inline(always)]
pub(crate) fn add_to_nodes<Q: Quad<T>, S: Scheme, T: Float, const D: usize>(
    factors: &Factors<T>,
    values: &StencilTerms<Q, D>,
    window: &mut [Node<T>],
) {
    let Factors { start, w, dw, .. } = factors;
    let (last, width) = (D - 1, S::Kernel::WIDTH);
    let lines = if D == 2 { 1 } else { width };
    let nodes = &mut window[*start..][..span::<S::Kernel, D>()];
    let mut plane = values.constant;
    for i in 0..width {
        let w0 = Q::splat(w[i][0]);
        let (mut line, slope, step) = (w0 * plane, w0 * values.slope[1], w0 * values.slope[last]);
        for j in 0..lines {
            let (mut row, mut step) = (line, step);
            if D == 3 {
                let w1 = Q::splat(w[j][1]);
                (row, step) = (w1 * row, w1 * step);
            }
            if S::KERNEL_GRADIENT {
                let across = if D == 2 { T::one() } else { w[j][1] };
                row = row.plus_scaled(dw[i][0] * across, values.by_dw[0]);
                if D == 3 {
                    row = row.plus_scaled(w[i][0] * dw[j][1], values.by_dw[1]);
                }
            }
            let first = row_start::<S::Kernel, D>(0, i, j);
            for k in 0..width {
                let node = &mut nodes[first + k];
                let mut sum = Q::load(node).plus_scaled(w[k][last], row);
                if S::KERNEL_GRADIENT {
                    let across = if D == 2 { T::one() } else { w[j][1] };
                    sum = sum.plus_scaled(w[i][0] * across * dw[k][last], values.by_dw[last]);
                }
                sum.store(node);
                row = row + step;
            }
            line = line + slope;
        }
        plane = plane + values.slope[0];
    }
}

/// A sum that begins with its first product: 0 + x is an instruction that no compiler may leave out.
#[inline(always)]
fn accumulate<Q: Quad<T>, T: Float>(is_first: bool, sum: Q, scale: T, value: Q) -> Q {
    if is_first {
        Q::splat(scale) * value
    } else {
        sum.plus_scaled(scale, value)
    }
}

/// The transpose of [`add_to_nodes`]: sums of the nodes' values times N, N i_a and, with the
/// kernel's gradient, ∂N/∂x_a.
///
/// From the last node to the first: a running sum added once per step counts the places.
#[inline(always)]
pub(crate) fn sum_over_nodes<Q: Quad<T>, S: Scheme, T: Float, const D: usize>(
    factors: &Factors<T>,
    window: &[Node<T>],
) -> StencilTerms<Q, D> {
    let Factors { start, w, dw, .. } = factors;
    let (last, width) = (D - 1, S::Kernel::WIDTH);
    let lines = if D == 2 { 1 } else { width };
    let nodes = &window[*start..][..span::<S::Kernel, D>()];
    let zero = Q::splat(T::zero());
    let mut total = StencilTerms {
        constant: zero,
        slope: [zero; D],
        by_dw: [zero; D],
    };
    for i in (0..width).rev() {
        let mut plane = StencilTerms {
            constant: zero,
            slope: [zero; D],
            by_dw: [zero; D],
        };
        for j in (0..lines).rev() {
            let first = row_start::<S::Kernel, D>(0, i, j);
            let (row, places, by_dw) =
                sum_over_row::<Q, S, T>(&nodes[first..first + width], w, dw, last);
            if D == 2 {
                plane.constant = row;
                plane.slope[last] = places;
                plane.by_dw[last] = by_dw;
                continue;
            }
            let begins = j + 1 == width;
            plane.constant = accumulate(begins, plane.constant, w[j][1], row);
            plane.slope[last] = accumulate(begins, plane.slope[last], w[j][1], places);
            if begins {
                plane.slope[1] = plane.constant;
            } else if j > 0 {
                plane.slope[1] = plane.slope[1] + plane.constant;
            }
            if S::KERNEL_GRADIENT {
                plane.by_dw[1] = accumulate(begins, plane.by_dw[1], dw[j][1], row);
                plane.by_dw[last] = accumulate(begins, plane.by_dw[last], w[j][1], by_dw);
            }
        }
        let begins = i + 1 == width;
        total.constant = accumulate(begins, total.constant, w[i][0], plane.constant);
        if begins {
            total.slope[0] = total.constant;
        } else if i > 0 {
            total.slope[0] = total.slope[0] + total.constant;
        }
        for a in 1..D {
            total.slope[a] = accumulate(begins, total.slope[a], w[i][0], plane.slope[a]);
        }
        if S::KERNEL_GRADIENT {
            total.by_dw[0] = accumulate(begins, total.by_dw[0], dw[i][0], plane.constant);
            for a in 1..D {
                total.by_dw[a] = accumulate(begins, total.by_dw[a], w[i][0], plane.by_dw[a]);
            }
        }
    }
    total
}

/// Sums over the nodes of a row times N, N k and ∂N/∂x of its own axis.
#[inline(always)]
fn sum_over_row<Q: Quad<T>, S: Scheme, T: Float>(
    nodes: &[Node<T>],
    w: &[[T; 4]; 4],
    dw: &[[T; 4]; 4],
    axis: usize,
) -> (Q, Q, Q) {
    let width = S::Kernel::WIDTH;
    let zero = Q::splat(T::zero());
    let (mut row, mut places, mut by_dw) = (zero, zero, zero);
    for k in (0..width).rev() {
        let begins = k + 1 == width;
        let node = Q::load(&nodes[k]);
        row = accumulate(begins, row, w[k][axis], node);
        if begins {
            places = row;
        } else if k > 0 {
            places = places + row;
        }
        if S::KERNEL_GRADIENT {
            by_dw = accumulate(begins, by_dw, dw[k][axis], node);
        }
    }
    (row, places, by_dw)
}
