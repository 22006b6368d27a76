//! Particles to grid and back: APIC (Jiang et al. 2015) and MLS-MPM (Hu et al. 2018, doc 001 \[1\]).
//!
//! Both move `m (v + C (x_i − x_p))` to the nodes. They differ in the gradient: APIC takes the
//! kernel's own ∇N for forces and for the update of F; MLS-MPM takes `N D⁻¹ (x_i − x_p)`, which it
//! shares with the affine velocity, so that one product does for both.

use crate::body::Body;
use crate::float::Float;
use crate::kernels::{Cubic, Linear, Quadratic, Spline, locate};
use crate::law::Law;
use crate::particles::Particles;
use crate::window::{Node, Scatter, Visit, for_each_row, window_start};
use fem_kinematics::Mat;
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

/// The one-dimensional factors of a transfer.
#[derive(Clone, Copy)]
struct Factors<T, const D: usize> {
    base: [i32; D],
    /// N.
    w: [[T; 4]; D],
    /// N (x_i − x_p), m.
    moment: [[T; 4]; D],
    /// dN/dx, 1/m; used by schemes with the kernel's gradient.
    dw: [[T; 4]; D],
}

impl<T: Float, const D: usize> Factors<T, D> {
    #[inline(always)]
    fn new<S: Scheme>(x: &[T; D], h: T) -> Self {
        let (base, f) = locate::<S::Kernel, T, D>(x, h);
        let w: [[T; 4]; D] = core::array::from_fn(|a| S::Kernel::values(f[a]));
        let moment = core::array::from_fn(|a| {
            core::array::from_fn(|k| w[a][k] * ((T::from_f64(k as f64) - f[a]) * h))
        });
        let dw = if S::KERNEL_GRADIENT {
            let per_h = T::one() / h;
            core::array::from_fn(|a| S::Kernel::first(f[a]).map(|v| v * per_h))
        } else {
            [[T::zero(); 4]; D]
        };
        Self {
            base,
            w,
            moment,
            dw,
        }
    }

    /// Products over all axes but the last: of `w` alone, and with `by` in place of `w` on axis 0
    /// and on axis 1 (unused in 2D).
    #[inline(always)]
    fn row(&self, by: &[[T; 4]; D], i: usize, j: usize) -> (T, [T; 2]) {
        if D == 2 {
            (self.w[0][i], [by[0][i], T::zero()])
        } else {
            (
                self.w[0][i] * self.w[1][j],
                [by[0][i] * self.w[1][j], self.w[0][i] * by[1][j]],
            )
        }
    }
}

#[inline(always)]
fn add_scaled<T: Float>(sum: &mut [T; 4], s: T, v: &[T; 4]) {
    sum[0] += s * v[0];
    sum[1] += s * v[1];
    sum[2] += s * v[2];
    sum[3] += s * v[3];
}

/// Column a of a matrix as a node vector, times a number.
#[inline(always)]
fn column<T: Float, const D: usize>(m: &Mat<T, D>, a: usize) -> [T; 4] {
    core::array::from_fn(|c| if c < D { m.0[c][a] } else { T::zero() })
}

/// Mass and momentum, with Δt times the internal force: node = (momentum, …, mass at entry 3).
pub(crate) struct ParticlesToGrid<'a, T, L, S, const D: usize> {
    pub particles: &'a Particles<T, D>,
    /// Damage that degrades the stress.
    pub damage: &'a [T],
    pub bodies: &'a [Body<L, D>],
    pub h: T,
    /// Time step for the internal force; 0 moves mass and momentum only.
    pub dt: T,
    pub scheme: PhantomData<S>,
}

impl<T: Float, L: Law<D>, S: Scheme, const D: usize> Scatter<T, D>
    for ParticlesToGrid<'_, T, L, S, D>
{
    #[inline(always)]
    fn scatter(&self, p: usize, origin: [i32; D], window: &mut [Node<T>]) {
        let particles = self.particles;
        let (m, F) = (particles.mass[p], &particles.F[p]);
        let factors = Factors::<T, D>::new::<S>(&particles.x[p], self.h);
        let law = &self.bodies[particles.body[p] as usize].law;
        // Δt V₀ P Fᵀ: the impulse on node i is minus this times ∇N_i.
        let impulse = law
            .stress(F, self.damage[p])
            .mul_tr(F)
            .scale(-self.dt * particles.volume[p]);
        let mut affine = particles.C[p].scale(m);
        if let (false, Some(inertia)) = (S::KERNEL_GRADIENT, S::Kernel::INERTIA) {
            affine += impulse.scale(T::from_f64(1.0 / inertia) / (self.h * self.h));
        }
        let mut rigid = [T::zero(); 4];
        for c in 0..D {
            rigid[c] = m * particles.v[p][c];
        }
        rigid[3] = m;
        let A: [[T; 4]; D] = core::array::from_fn(|a| column(&affine, a));
        let G: [[T; 4]; D] = core::array::from_fn(|a| column(&impulse, a));
        let last = D - 1;
        let start = window_start::<S::Kernel, D>(factors.base, origin);
        for_each_row::<S::Kernel, D>(start, |first, i, j| {
            let (w, moment) = factors.row(&factors.moment, i, j);
            let mut by_w = rigid.map(|r| w * r);
            let by_moment = A[last].map(|a| w * a);
            let mut by_dw = [T::zero(); 4];
            for a in 0..last {
                add_scaled(&mut by_w, moment[a], &A[a]);
            }
            if S::KERNEL_GRADIENT {
                let (_, dw) = factors.row(&factors.dw, i, j);
                for a in 0..last {
                    add_scaled(&mut by_w, dw[a], &G[a]);
                }
                by_dw = G[last].map(|g| w * g);
            }
            let row = &mut window[first..first + S::Kernel::WIDTH];
            for (k, node) in row.iter_mut().enumerate() {
                let mut sum = *node;
                add_scaled(&mut sum, factors.w[last][k], &by_w);
                add_scaled(&mut sum, factors.moment[last][k], &by_moment);
                if S::KERNEL_GRADIENT {
                    add_scaled(&mut sum, factors.dw[last][k], &by_dw);
                }
                *node = sum;
            }
        });
    }
}

/// Adds S ∇N_i (or its moving-least-squares twin) to the nodes under a particle at x.
#[inline(always)]
pub(crate) fn spread_stress<T: Float, S: Scheme, const D: usize>(
    x: &[T; D],
    h: T,
    stress: &Mat<T, D>,
    origin: [i32; D],
    window: &mut [Node<T>],
) {
    let factors = Factors::<T, D>::new::<S>(x, h);
    let (by, scale) = match (S::KERNEL_GRADIENT, S::Kernel::INERTIA) {
        (false, Some(inertia)) => (&factors.moment, T::from_f64(1.0 / inertia) / (h * h)),
        _ => (&factors.dw, T::one()),
    };
    let columns: [[T; 4]; D] = core::array::from_fn(|a| column(&stress.scale(scale), a));
    let last = D - 1;
    let start = window_start::<S::Kernel, D>(factors.base, origin);
    for_each_row::<S::Kernel, D>(start, |first, i, j| {
        let (w, row_by) = factors.row(by, i, j);
        let mut by_w = [T::zero(); 4];
        for a in 0..last {
            add_scaled(&mut by_w, row_by[a], &columns[a]);
        }
        let by_last = columns[last].map(|c| w * c);
        let row = &mut window[first..first + S::Kernel::WIDTH];
        for (k, node) in row.iter_mut().enumerate() {
            add_scaled(node, factors.w[last][k], &by_w);
            add_scaled(node, by[last][k], &by_last);
        }
    });
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
pub(crate) fn read_motion<T: Float, S: Scheme, const D: usize>(
    x: &[T; D],
    h: T,
    origin: [i32; D],
    window: &[Node<T>],
) -> Motion<T, D> {
    let factors = Factors::<T, D>::new::<S>(x, h);
    let start = window_start::<S::Kernel, D>(factors.base, origin);
    let last = D - 1;
    let mut v = [T::zero(); 4];
    let mut B = [[T::zero(); 4]; D];
    let mut G = [[T::zero(); 4]; D];
    for_each_row::<S::Kernel, D>(start, |first, i, j| {
        let row = &window[first..first + S::Kernel::WIDTH];
        let (mut by_w, mut by_moment, mut by_dw) = ([T::zero(); 4], [T::zero(); 4], [T::zero(); 4]);
        for (k, node) in row.iter().enumerate() {
            add_scaled(&mut by_w, factors.w[last][k], node);
            add_scaled(&mut by_moment, factors.moment[last][k], node);
            if S::KERNEL_GRADIENT {
                add_scaled(&mut by_dw, factors.dw[last][k], node);
            }
        }
        let (w, moment) = factors.row(&factors.moment, i, j);
        add_scaled(&mut v, w, &by_w);
        for a in 0..last {
            add_scaled(&mut B[a], moment[a], &by_w);
        }
        add_scaled(&mut B[last], w, &by_moment);
        if S::KERNEL_GRADIENT {
            let (_, dw) = factors.row(&factors.dw, i, j);
            for a in 0..last {
                add_scaled(&mut G[a], dw[a], &by_w);
            }
            add_scaled(&mut G[last], w, &by_dw);
        }
    });
    let gradient = Mat::from_fn(|c, a| G[a][c]);
    let C = match S::Kernel::INERTIA {
        Some(inertia) => {
            let per_inertia = T::from_f64(1.0 / inertia) / (h * h);
            Mat::from_fn(|c, a| B[a][c] * per_inertia)
        }
        // The linear kernel has no constant inertia: its affine part is the gradient itself.
        None => gradient,
    };
    Motion {
        v: core::array::from_fn(|c| v[c]),
        C,
        gradient: if S::KERNEL_GRADIENT { gradient } else { C },
    }
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
    fn visit(&mut self, rank: usize, p: usize, origin: [i32; D], window: &[Node<T>]) {
        let (x, F) = (&self.particles.x[p], &self.particles.F[p]);
        let motion = read_motion::<T, S, D>(x, self.h, origin, window);
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
