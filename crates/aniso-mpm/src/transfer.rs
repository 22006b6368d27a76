//! Particles to grid and back: APIC (Jiang et al. 2015) and MLS-MPM (Hu et al. 2018, document 001 \[1\]).
//!
//! Both move `m (v + C (x_i − x_p))` to the nodes. They differ in the gradient: APIC takes the
//! kernel's own ∇N for forces and for the update of F; MLS-MPM takes `N D⁻¹ (x_i − x_p)`, which it
//! shares with the affine velocity, so that one product does for both.

use crate::float::Float;
use crate::kernels::{Cubic, Linear, Quadratic, Spline, locate};
use crate::particles::Particles;
use crate::window::{Node, Scatter, Visit, row_start, window_start};
use fem_kinematics::{Mat, Quad};
use std::marker::PhantomData;

/// A kernel and a way to take gradients.
pub trait Scheme: Copy + Send + Sync + 'static {
    /// The B-spline.
    type Kernel: Spline;
    /// Gradients by ∇N (APIC) rather than by moving least squares.
    const KERNEL_GRADIENT: bool;
}

/// Kernels whose inertia tensor is the same everywhere, as MLS-MPM needs.
pub trait ConstantInertia: Spline {}
impl ConstantInertia for Quadratic {}
impl ConstantInertia for Cubic {}

/// APIC with the kernel's own gradients.
#[derive(Clone, Copy, Debug)]
pub struct Apic<K>(PhantomData<K>);
/// MLS-MPM; does not exist for the linear kernel, whose inertia vanishes on the nodes.
#[derive(Clone, Copy, Debug)]
pub struct MlsMpm<K>(PhantomData<K>);

impl<K: Spline> Scheme for Apic<K> {
    type Kernel = K;
    const KERNEL_GRADIENT: bool = true;
}
impl<K: ConstantInertia> Scheme for MlsMpm<K> {
    type Kernel = K;
    const KERNEL_GRADIENT: bool = false;
}
const _: fn() = || {
    fn exists<S: Scheme>() {}
    exists::<Apic<Linear>>();
};

/// Where a particle lies in its stencil, and the one-dimensional factors of its weights.
#[derive(Clone, Copy)]
struct Factors<T, const D: usize> {
    base: [i32; D],
    /// Distance from the first node, cells.
    f: [T; D],
    /// N.
    w: [[T; 4]; D],
    /// dN/dx, 1/m; used by schemes with the kernel's gradient.
    dw: [[T; 4]; D],
}

impl<T: Float, const D: usize> Factors<T, D> {
    #[inline(always)]
    fn new<S: Scheme>(x: &[T; D], h: T) -> Self {
        let (base, f) = locate::<S::Kernel, T, D>(x, h);
        let per_h = T::one() / h;
        let [mut w, mut dw] = [[[T::zero(); 4]; D]; 2];
        for a in 0..D {
            w[a] = S::Kernel::values(f[a]);
            if S::KERNEL_GRADIENT {
                dw[a] = S::Kernel::first(f[a]);
                for dw in &mut dw[a] {
                    *dw *= per_h;
                }
            }
        }
        Self { base, f, w, dw }
    }

    /// Product of the weights on all axes but the last.
    #[inline(always)]
    fn of_row(&self, i: usize, j: usize) -> T {
        if D == 2 {
            self.w[0][i]
        } else {
            self.w[0][i] * self.w[1][j]
        }
    }
}

/// What goes with the factors N, N i_a and ∂N/∂x_a of the node with the place i in the stencil:
/// for a node the value `N (constant + Σ_a i_a slope[a]) + Σ_a ∂N/∂x_a by_dw[a]`, or the sums of the
/// nodes' values times these factors.
///
/// Places are small whole numbers: counting them takes additions where distances from the
/// particle take products.
struct StencilTerms<Q, const D: usize> {
    constant: Q,
    slope: [Q; D],
    by_dw: [Q; D],
}

impl<Q: Copy, const D: usize> StencilTerms<Q, D> {
    /// `N (rigid + Σ_a (x_i − x_p)_a affine_a) + Σ_a ∂N/∂x_a by_dw_a`, matrices by columns.
    #[inline(always)]
    fn new<T: Float>(
        f: &[T; D],
        h: T,
        rigid: Node<T>,
        affine: &Mat<T, D>,
        by_dw: &Mat<T, D>,
    ) -> Self
    where
        Q: Quad<T>,
    {
        let mut constant = Q::load(&rigid);
        let mut slope = [constant; D];
        for a in 0..D {
            slope[a] = Q::splat(h) * column(affine, a);
            constant = constant.plus_scaled(-f[a], slope[a]);
        }
        let mut columns = [constant; D];
        for a in 0..D {
            columns[a] = column(by_dw, a);
        }
        Self {
            constant,
            slope,
            by_dw: columns,
        }
    }
}

/// Column a of a matrix as the values of a node.
#[inline(always)]
fn column<Q: Quad<T>, T: Float, const D: usize>(m: &Mat<T, D>, a: usize) -> Q {
    let mut column = [T::zero(); 4];
    for c in 0..D {
        column[c] = m.0[c][a];
    }
    Q::load(&column)
}

/// Adds values to the nodes under a particle, `by_dw` only with the kernel's gradient.
///
/// Plain loops, no closures, see [`Quad`]. What depends on the row alone is multiplied once for
/// it; one multiply-add and one addition are left for each node (another multiply-add with the
/// kernel's gradient).
#[inline(always)]
fn add_to_nodes<Q: Quad<T>, S: Scheme, T: Float, const D: usize>(
    factors: &Factors<T, D>,
    values: &StencilTerms<Q, D>,
    origin: [i32; D],
    window: &mut [Node<T>],
) {
    let Factors { w, dw, .. } = factors;
    let (last, width) = (D - 1, S::Kernel::WIDTH);
    let start = window_start::<S::Kernel, D>(factors.base, origin);
    let mut plane = values.constant;
    for i in 0..width {
        let mut line = plane;
        for j in 0..(if D == 2 { 1 } else { width }) {
            let weight = Q::splat(factors.of_row(i, j));
            let (mut row, step) = (weight * line, weight * values.slope[last]);
            let by_dw = weight * values.by_dw[last];
            if S::KERNEL_GRADIENT {
                let across = if D == 2 { T::one() } else { w[1][j] };
                row = row.plus_scaled(dw[0][i] * across, values.by_dw[0]);
                if D == 3 {
                    row = row.plus_scaled(w[0][i] * dw[1][j], values.by_dw[1]);
                }
            }
            let first = row_start::<S::Kernel, D>(start, i, j);
            for (k, node) in window[first..first + width].iter_mut().enumerate() {
                let mut sum = Q::load(node).plus_scaled(w[last][k], row);
                if S::KERNEL_GRADIENT {
                    sum = sum.plus_scaled(dw[last][k], by_dw);
                }
                sum.store(node);
                row = row + step;
            }
            line = line + values.slope[1];
        }
        plane = plane + values.slope[0];
    }
}

/// The transpose of [`add_to_nodes`]: sums of the nodes' values times N, N i_a and, with the
/// kernel's gradient, ∂N/∂x_a.
///
/// From the last node to the first: a running sum added once per step counts the places.
#[inline(always)]
fn sum_over_nodes<Q: Quad<T>, S: Scheme, T: Float, const D: usize>(
    factors: &Factors<T, D>,
    origin: [i32; D],
    window: &[Node<T>],
) -> StencilTerms<Q, D> {
    let Factors { w, dw, .. } = factors;
    let (last, width) = (D - 1, S::Kernel::WIDTH);
    let start = window_start::<S::Kernel, D>(factors.base, origin);
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
        for j in (0..(if D == 2 { 1 } else { width })).rev() {
            let (mut row, mut places, mut by_dw) = (zero, zero, zero);
            let first = row_start::<S::Kernel, D>(start, i, j);
            for (k, node) in window[first..first + width].iter().enumerate().rev() {
                let node = Q::load(node);
                row = row.plus_scaled(w[last][k], node);
                if k > 0 {
                    places = places + row;
                }
                if S::KERNEL_GRADIENT {
                    by_dw = by_dw.plus_scaled(dw[last][k], node);
                }
            }
            if D == 2 {
                plane.constant = row;
                plane.slope[last] = places;
                plane.by_dw[last] = by_dw;
            } else {
                plane.constant = plane.constant.plus_scaled(w[1][j], row);
                plane.slope[last] = plane.slope[last].plus_scaled(w[1][j], places);
                if j > 0 {
                    plane.slope[1] = plane.slope[1] + plane.constant;
                }
                if S::KERNEL_GRADIENT {
                    plane.by_dw[1] = plane.by_dw[1].plus_scaled(dw[1][j], row);
                    plane.by_dw[last] = plane.by_dw[last].plus_scaled(w[1][j], by_dw);
                }
            }
        }
        total.constant = total.constant.plus_scaled(w[0][i], plane.constant);
        if i > 0 {
            total.slope[0] = total.slope[0] + total.constant;
        }
        for a in 1..D {
            total.slope[a] = total.slope[a].plus_scaled(w[0][i], plane.slope[a]);
        }
        if S::KERNEL_GRADIENT {
            total.by_dw[0] = total.by_dw[0].plus_scaled(dw[0][i], plane.constant);
            for a in 1..D {
                total.by_dw[a] = total.by_dw[a].plus_scaled(w[0][i], plane.by_dw[a]);
            }
        }
    }
    total
}

/// Mass and momentum, with Δt times the internal force: node = (momentum, …, mass at entry 3).
pub(crate) struct ParticlesToGrid<'a, T, S, const D: usize> {
    pub particles: &'a Particles<T, D>,
    /// Kirchhoff stresses P Fᵀ for the internal force; without them mass and momentum move alone.
    pub tau: Option<&'a [Mat<T, D>]>,
    pub h: T,
    pub dt: T,
    pub scheme: PhantomData<S>,
}

impl<T: Float, S: Scheme, const D: usize> Scatter<T, D> for ParticlesToGrid<'_, T, S, D> {
    #[inline(always)]
    fn scatter<Q: Quad<T>>(&self, p: usize, origin: [i32; D], window: &mut [Node<T>]) {
        let particles = self.particles;
        let m = particles.mass[p];
        let factors = Factors::<T, D>::new::<S>(&particles.x[p], self.h);
        let mut affine = particles.C[p].scale(m);
        let mut impulse = Mat::zeros();
        if let Some(tau) = self.tau {
            // Δt V₀ P Fᵀ: the impulse on node i is minus this times ∇N_i.
            impulse = tau[p].scale(-self.dt * particles.volume[p]);
            if let (false, Some(inertia)) = (S::KERNEL_GRADIENT, S::Kernel::INERTIA) {
                affine += impulse.scale(T::from_f64(1.0 / inertia) / (self.h * self.h));
            }
        }
        let mut rigid = [T::zero(); 4];
        for c in 0..D {
            rigid[c] = m * particles.v[p][c];
        }
        rigid[3] = m;
        let values = StencilTerms::<Q, D>::new(&factors.f, self.h, rigid, &affine, &impulse);
        add_to_nodes::<Q, S, T, D>(&factors, &values, origin, window);
    }
}

/// Adds S ∇N_i (or its moving-least-squares twin) to the nodes under a particle at x.
#[inline(always)]
pub(crate) fn spread_stress<T: Float, Q: Quad<T>, S: Scheme, const D: usize>(
    x: &[T; D],
    h: T,
    stress: &Mat<T, D>,
    origin: [i32; D],
    window: &mut [Node<T>],
) {
    let factors = Factors::<T, D>::new::<S>(x, h);
    let mut affine = Mat::zeros();
    if let (false, Some(inertia)) = (S::KERNEL_GRADIENT, S::Kernel::INERTIA) {
        affine = stress.scale(T::from_f64(1.0 / inertia) / (h * h));
    }
    let values = StencilTerms::<Q, D>::new(&factors.f, h, [T::zero(); 4], &affine, stress);
    add_to_nodes::<Q, S, T, D>(&factors, &values, origin, window);
}

/// What a particle reads from the velocities on the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<T, const D: usize> {
    pub v: [T; D],
    /// Affine velocity C.
    pub C: Mat<T, D>,
    /// Velocity gradient that moves F.
    pub gradient: Mat<T, D>,
}

/// Velocity, affine velocity and velocity gradient at a particle.
#[inline(always)]
pub(crate) fn read_motion<T: Float, Q: Quad<T>, S: Scheme, const D: usize>(
    x: &[T; D],
    h: T,
    origin: [i32; D],
    window: &[Node<T>],
) -> Motion<T, D> {
    let factors = Factors::<T, D>::new::<S>(x, h);
    let sums = sum_over_nodes::<Q, S, T, D>(&factors, origin, window);
    let mut v = [T::zero(); 4];
    sums.constant.store(&mut v);
    let mut gradient = Mat::zeros();
    if S::KERNEL_GRADIENT {
        gradient = from_columns(&sums.by_dw);
    }
    let C = match S::Kernel::INERTIA {
        Some(inertia) => {
            // Σ N v (x_i − x_p)_a = h (Σ N v i_a − f_a Σ N v), over the inertia.
            let scale = Q::splat(T::from_f64(1.0 / inertia) / h);
            let mut columns = sums.slope;
            for a in 0..D {
                columns[a] = scale * columns[a].plus_scaled(-factors.f[a], sums.constant);
            }
            from_columns(&columns)
        }
        // The linear kernel has no constant inertia: its affine part is the gradient itself.
        None => gradient,
    };
    let mut velocity = [T::zero(); D];
    velocity.copy_from_slice(&v[..D]);
    Motion {
        v: velocity,
        C,
        gradient: if S::KERNEL_GRADIENT { gradient } else { C },
    }
}

/// The matrix with these columns.
#[inline(always)]
fn from_columns<Q: Quad<T>, T: Float, const D: usize>(columns: &[Q; D]) -> Mat<T, D> {
    let mut m = Mat::zeros();
    for a in 0..D {
        let mut column = [T::zero(); 4];
        columns[a].store(&mut column);
        for c in 0..D {
            m.0[c][a] = column[c];
        }
    }
    m
}

/// One chunk of the particles' next state, in sorted order.
pub(crate) struct NextChunk<'a, T, const D: usize> {
    pub x: &'a mut [[T; D]],
    pub v: &'a mut [[T; D]],
    pub C: &'a mut [Mat<T, D>],
    pub F: &'a mut [Mat<T, D>],
}

/// The worst that happened in a chunk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Worst {
    /// Largest |v|², m²/s².
    pub speed_squared: f64,
    /// First particle (by its old place) whose new state is not finite.
    pub not_finite: Option<usize>,
    /// First particle that the step would deform by more than [`MAX_STRAIN_STEP`].
    pub too_fast: Option<usize>,
}

/// Largest Δt |∂v_i/∂x_j| that a step may have. Below 1/D no element can invert in one step.
pub(crate) const MAX_STRAIN_STEP: f64 = 0.3;

pub(crate) struct GridToParticles<'a, 'b, T, S, const D: usize> {
    pub particles: &'a Particles<T, D>,
    pub h: T,
    pub dt: T,
    pub first: usize,
    pub next: NextChunk<'b, T, D>,
    pub worst: Worst,
    pub scheme: PhantomData<S>,
}

impl<T: Float, S: Scheme, const D: usize> Visit<T, D> for GridToParticles<'_, '_, T, S, D> {
    #[inline(always)]
    fn visit<Q: Quad<T>>(&mut self, rank: usize, p: usize, origin: [i32; D], window: &[Node<T>]) {
        let (x, F) = (&self.particles.x[p], &self.particles.F[p]);
        let motion = read_motion::<T, Q, S, D>(x, self.h, origin, window);
        let step = motion.gradient.scale(self.dt);
        let at = rank - self.first;
        let new_x: [T; D] = core::array::from_fn(|a| x[a] + self.dt * motion.v[a]);
        let new_F = *F + step * *F;
        let mut speed = T::zero();
        let mut strain = T::zero();
        let mut check = T::zero();
        for a in 0..D {
            speed += motion.v[a] * motion.v[a];
            check += new_x[a];
            for b in 0..D {
                strain = strain.max(step.0[a][b].abs());
                check += new_F.0[a][b] + motion.C.0[a][b];
            }
        }
        check += speed;
        // Written so that a NaN counts as a failure.
        if !(check * T::zero() == T::zero()) && self.worst.not_finite.is_none() {
            self.worst.not_finite = Some(p);
        }
        if !(strain <= T::from_f64(MAX_STRAIN_STEP)) && self.worst.too_fast.is_none() {
            self.worst.too_fast = Some(p);
        }
        let speed = speed.to_f64();
        if speed > self.worst.speed_squared {
            self.worst.speed_squared = speed;
        }
        self.next.x[at] = new_x;
        self.next.v[at] = motion.v;
        self.next.C[at] = motion.C;
        self.next.F[at] = new_F;
    }
}
