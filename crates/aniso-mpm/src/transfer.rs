//! Particles to grid and back: APIC (Jiang et al. 2015) and MLS-MPM (Hu et al. 2018, document 001 \[1\]).
//!
//! Both move `m (v + C (x_i − x_p))` to the nodes. They differ in the gradient: APIC takes the
//! kernel's own ∇N for forces and for the update of F; MLS-MPM takes `N D⁻¹ (x_i − x_p)`, which it
//! shares with the affine velocity, so that one product does for both.

use crate::float::Float;
use crate::kernels::{Cubic, Linear, Quadratic, Spline};
use crate::particles::Particles;
use crate::stencil::{
    Factors, StencilTerms, add_to_nodes, load_axes, rows, store_axes, store_rows, sum_over_nodes,
    transposed,
};
use crate::window::{Node, Scatter, Visit};
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
        self.scatter_all::<Q>(&[p as u32], origin, window);
    }

    #[inline(always)]
    fn scatter_all<Q: Quad<T>>(&self, order: &[u32], origin: [i32; D], window: &mut [Node<T>]) {
        let (all, h) = (self.particles, self.h);
        // Slices of one length, which the compiler knows: one check of a particle serves all.
        let count = all.len();
        let (x, v, C) = (&all.x[..count], &all.v[..count], &all.C[..count]);
        let (mass, volume) = (&all.mass[..count], &all.volume[..count]);
        let tau = self.tau.map(|tau| &tau[..count]);
        let last = Q::load(&[T::zero(), T::zero(), T::zero(), T::one()]);
        for &p in order {
            let p = p as usize;
            let factors = Factors::<T>::new::<Q, S, D>(load_axes(&x[p]), h, origin);
            let mut affine = rows(&C[p]);
            let to_cell = Q::splat(mass[p] * h);
            for row in &mut affine {
                *row = to_cell * *row;
            }
            let mut impulse = [Q::splat(T::zero()); D];
            if let Some(tau) = tau {
                // Δt V₀ P Fᵀ: the impulse on node i is minus this times ∇N_i.
                let scale = -self.dt * volume[p];
                add_stress::<Q, S, T, D>(&tau[p], h, scale, &mut affine, &mut impulse);
            }
            let rigid = Q::splat(mass[p]) * (load_axes::<Q, T, D>(&v[p]) + last);
            let values = StencilTerms::new(&factors, rigid, transposed(&affine), impulse);
            add_to_nodes::<Q, S, T, D>(&factors, &values, window);
        }
    }
}

/// What a stress times `scale` adds to the rows of the affine part of a step of one cell, or, with the
/// kernel's gradient, its columns.
#[inline(always)]
fn add_stress<Q: Quad<T>, S: Scheme, T: Float, const D: usize>(
    stress: &Mat<T, D>,
    h: T,
    scale: T,
    affine: &mut [Q; D],
    by_dw: &mut [Q; D],
) {
    let stress = rows::<Q, T, D>(stress);
    if S::KERNEL_GRADIENT {
        let columns = transposed(&stress);
        for a in 0..D {
            by_dw[a] = Q::splat(scale) * columns[a];
        }
    } else if let Some(inertia) = S::Kernel::INERTIA {
        let scale = scale * (T::from_f64(1.0 / inertia) / h);
        for c in 0..D {
            affine[c] = affine[c].plus_scaled(scale, stress[c]);
        }
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
    let factors = Factors::<T>::new::<Q, S, D>(load_axes(x), h, origin);
    let zero = Q::splat(T::zero());
    let (mut affine, mut by_dw) = ([zero; D], [zero; D]);
    add_stress::<Q, S, T, D>(stress, h, T::one(), &mut affine, &mut by_dw);
    let values = StencilTerms::new(&factors, zero, transposed(&affine), by_dw);
    add_to_nodes::<Q, S, T, D>(&factors, &values, window);
}

/// What a particle reads from the velocities on the grid; matrices by rows.
pub(crate) struct Motion<Q, const D: usize> {
    /// Behind the velocity, the weighted mean of the nodes' masses.
    v: Q,
    /// Affine velocity C.
    C: [Q; D],
    /// Velocity gradient that moves F.
    gradient: [Q; D],
}

/// Velocity, affine velocity and velocity gradient at a particle.
#[inline(always)]
fn read_motion<T: Float, Q: Quad<T>, S: Scheme, const D: usize>(
    x: Q,
    h: T,
    origin: [i32; D],
    window: &[Node<T>],
) -> Motion<Q, D> {
    let factors = Factors::<T>::new::<Q, S, D>(x, h, origin);
    let sums = sum_over_nodes::<Q, S, T, D>(&factors, window);
    let mut gradient = sums.by_dw;
    if S::KERNEL_GRADIENT {
        gradient = transposed(&gradient);
    }
    let C = match S::Kernel::INERTIA {
        Some(inertia) => {
            // Σ N v (x_i − x_p)_a = h (Σ N v i_a − f_a Σ N v), over the inertia.
            let scale = Q::splat(T::from_f64(1.0 / inertia)) / Q::splat(h);
            let mut columns = sums.moments(&factors);
            for column in &mut columns {
                *column = scale * *column;
            }
            transposed(&columns)
        }
        // The linear kernel has no constant inertia: its affine part is the gradient itself.
        None => gradient,
    };
    Motion {
        v: sums.constant,
        C,
        gradient: if S::KERNEL_GRADIENT { gradient } else { C },
    }
}

/// The velocity gradient at a particle.
#[inline(always)]
pub(crate) fn read_gradient<T: Float, Q: Quad<T>, S: Scheme, const D: usize>(
    x: &[T; D],
    h: T,
    origin: [i32; D],
    window: &[Node<T>],
) -> Mat<T, D> {
    let motion = read_motion::<T, Q, S, D>(load_axes(x), h, origin, window);
    let mut gradient = Mat::zeros();
    store_rows(&motion.gradient, &mut gradient);
    gradient
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
    fn visit<Q: Quad<T>>(
        &mut self,
        rank: usize,
        order: &[u32],
        origin: [i32; D],
        window: &[Node<T>],
    ) {
        let (h, dt, count) = (self.h, Q::splat(self.dt), self.particles.len());
        let (old_x, old_F) = (&self.particles.x[..count], &self.particles.F[..count]);
        let (from, to) = (rank - self.first, rank - self.first + order.len());
        let (to_x, to_v) = (&mut self.next.x[from..to], &mut self.next.v[from..to]);
        let (to_C, to_F) = (&mut self.next.C[from..to], &mut self.next.F[from..to]);
        let zero = Q::splat(T::zero());
        let limit = Q::splat(T::from_f64(MAX_STRAIN_STEP));
        for (at, &p) in order.iter().enumerate() {
            let p = p as usize;
            let x: Q = load_axes(&old_x[p]);
            let motion = read_motion::<T, Q, S, D>(x, h, origin, window);
            let new_x = x + dt * motion.v;
            let (new_F, strain) = moved::<Q, T, D>(&old_F[p], &motion.gradient, dt);
            let mut sum = new_x;
            for c in 0..D {
                sum = sum + motion.C[c] + new_F[c];
            }
            store_axes(new_x, &mut to_x[at]);
            store_axes(motion.v, &mut to_v[at]);
            store_rows(&motion.C, &mut to_C[at]);
            store_rows(&new_F, &mut to_F[at]);
            // 0 x is NaN for an x that is not finite, and a NaN fails the comparison.
            let not_finite = sum * zero;
            if !(strain + not_finite).all_at_most(limit) {
                let first = if not_finite.all_at_most(zero) {
                    &mut self.worst.too_fast
                } else {
                    &mut self.worst.not_finite
                };
                first.get_or_insert(p);
            }
        }
    }
}

/// The rows of F + Δt ∇v F, and the largest |Δt ∂v_i/∂x_j| of each column.
#[inline(always)]
fn moved<Q: Quad<T>, T: Float, const D: usize>(
    F: &Mat<T, D>,
    gradient: &[Q; D],
    dt: Q,
) -> ([Q; D], Q) {
    let F: [Q; D] = rows(F);
    let (mut new_F, mut strain) = (F, Q::splat(T::zero()));
    for c in 0..D {
        let step = dt * gradient[c];
        let mut entries = [T::zero(); 4];
        step.store(&mut entries);
        for a in 0..D {
            new_F[c] = new_F[c].plus_scaled(entries[a], F[a]);
        }
        strain = strain.max(step.abs());
    }
    (new_F, strain)
}
