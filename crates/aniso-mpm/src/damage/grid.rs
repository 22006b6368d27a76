//! Damage on the grid and its Laplacian at the particles (document 001, alg. 4 and 7).

use crate::binning::Binning;
use crate::error::{MpmError, same_length};
use crate::float::Float;
use crate::kernels::{Cubic, Spline, Stencil};
use crate::window::{Gather, Node, Scatter, rows, window_start};
use fem_kinematics::Quad;

/// The grid of a damage update: cubic B-splines, and only where there are particles.
#[derive(Clone, Debug)]
pub struct DamageGrid<const D: usize> {
    pub(crate) binning: Binning<Cubic, D>,
    pub(crate) x: Vec<[f64; D]>,
    /// (d_i, Σ_p w_ip, 0, 0) of every node of the node blocks.
    pub(crate) field: Vec<Node<f64>>,
    pub(crate) windows: Vec<Node<f64>>,
}

impl<const D: usize> DamageGrid<D> {
    /// An empty grid of cell size `h` (m); node (i, j, k) is at h (i, j, k).
    pub fn new(h: f64) -> Self {
        Self {
            binning: Binning::new(h),
            x: Vec::new(),
            field: Vec::new(),
            windows: Vec::new(),
        }
    }

    /// Transfers the damage `d` of the particles at `x` (m) to the grid: d_i = Σ w d_p / Σ w.
    ///
    /// # Errors
    /// Lengths that differ, or a particle that no grid can hold.
    pub fn particles_to_grid<T: Float>(&mut self, x: &[[T; D]], d: &[T]) -> Result<(), MpmError> {
        same_length("damage", d.len(), x.len())?;
        self.x.clear();
        self.x.extend(x.iter().map(|x| x.map(Float::to_f64)));
        self.binning.rebuild(&self.x)?;
        let task = DamageToGrid {
            x: &self.x,
            d,
            h: self.binning.h,
        };
        self.binning
            .scatter(&task, &mut self.windows, &mut self.field);
        for node in &mut self.field {
            if node[1] > 0.0 {
                node[0] /= node[1];
            }
        }
        Ok(())
    }

    /// Every node under a particle: its place, d_i, and the sum of its weights.
    pub fn nodes(&self) -> impl Iterator<Item = ([i32; D], f64, f64)> + '_ {
        self.field
            .iter()
            .enumerate()
            .filter(|(_, node)| node[1] > 0.0)
            .map(|(at, node)| (self.binning.nodes.node(at), node[0], node[1]))
    }

    /// The blocks that node vectors are laid out on.
    pub fn node_blocks(&self) -> &crate::blocks::BlockSet<D> {
        &self.binning.nodes
    }

    /// d_i of every node of the node blocks; 0 for nodes under no particle.
    pub fn values(&self) -> Vec<f64> {
        self.field.iter().map(|node| node[0]).collect()
    }

    /// Δd_p = Σ_i d_i ΔN_i(x_p) at every particle, 1/m² (alg. 4, line 8).
    pub fn laplacians(&self) -> Vec<f64> {
        let read = ReadLaplacian {
            x: &self.x,
            h: self.binning.h,
        };
        self.binning.gather(&self.field, &read)
    }

    /// Σ_i d_i w_ip at every particle.
    pub fn interpolate(&self) -> Vec<f64> {
        let read = ReadValue {
            x: &self.x,
            h: self.binning.h,
        };
        self.binning.gather(&self.field, &read)
    }
}

struct DamageToGrid<'a, T, const D: usize> {
    x: &'a [[f64; D]],
    d: &'a [T],
    h: f64,
}
impl<T: Float, const D: usize> Scatter<f64, D> for DamageToGrid<'_, T, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let stencil = Stencil::new::<Cubic>(&self.x[p], self.h);
        let payload = [self.d[p].to_f64(), 1.0, 0.0, 0.0];
        add_weighted::<Q, D>(&stencil, payload, origin, window);
    }
}

/// Adds w_ip times four numbers to the nodes under a particle.
#[inline(always)]
pub(crate) fn add_weighted<Q: Quad<f64>, const D: usize>(
    stencil: &Stencil<f64, D>,
    payload: [f64; 4],
    origin: [i32; D],
    window: &mut [Node<f64>],
) {
    let start = window_start::<Cubic, D>(stencil.base, origin);
    let payload = Q::load(&payload);
    for (first, i, j) in rows::<Cubic, D>(start) {
        let w = row_product(&stencil.w, &stencil.w, i, j)[D - 1];
        for (k, node) in window[first..first + Cubic::WIDTH].iter_mut().enumerate() {
            let weight = w * stencil.w[D - 1][k];
            Q::load(node).plus_scaled(weight, payload).store(node);
        }
    }
}

/// For every axis the product over the axes but the last of `w`, with `by` in place of `w` on that
/// axis; entry D−1 is the product of `w` alone.
#[inline(always)]
pub(crate) fn row_product<const D: usize>(
    w: &[[f64; 4]; D],
    by: &[[f64; 4]; D],
    i: usize,
    j: usize,
) -> [f64; D] {
    let mut product = [1.0; D];
    if D == 2 {
        product[0] = by[0][i];
        product[1] = w[0][i];
    } else {
        product[0] = by[0][i] * w[1][j];
        product[1] = w[0][i] * by[1][j];
        product[2] = w[0][i] * w[1][j];
    }
    product
}

struct ReadLaplacian<'a, const D: usize> {
    x: &'a [[f64; D]],
    h: f64,
}
impl<const D: usize> Gather<f64, D> for ReadLaplacian<'_, D> {
    type Output = f64;
    #[inline(always)]
    fn gather<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &[Node<f64>]) -> f64 {
        let stencil = Stencil::new::<Cubic>(&self.x[p], self.h);
        let start = window_start::<Cubic, D>(stencil.base, origin);
        let last = D - 1;
        let mut sum = 0.0;
        // ERRATUM: N'' is with respect to x and carries 1/h² (alg. 4, line 5).
        for (first, i, j) in rows::<Cubic, D>(start) {
            let (mut by_w, mut by_ddw) = (0.0, 0.0);
            for (k, node) in window[first..first + Cubic::WIDTH].iter().enumerate() {
                by_w += stencil.w[last][k] * node[0];
                by_ddw += stencil.ddw[last][k] * node[0];
            }
            let factors = row_product(&stencil.w, &stencil.ddw, i, j);
            for factor in &factors[..last] {
                sum += factor * by_w;
            }
            sum += factors[last] * by_ddw;
        }
        sum
    }
}

struct ReadValue<'a, const D: usize> {
    x: &'a [[f64; D]],
    h: f64,
}
impl<const D: usize> Gather<f64, D> for ReadValue<'_, D> {
    type Output = f64;
    #[inline(always)]
    fn gather<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &[Node<f64>]) -> f64 {
        let stencil = Stencil::new::<Cubic>(&self.x[p], self.h);
        let start = window_start::<Cubic, D>(stencil.base, origin);
        let mut sum = 0.0;
        for (first, i, j) in rows::<Cubic, D>(start) {
            let w = row_product(&stencil.w, &stencil.w, i, j)[D - 1];
            for (k, node) in window[first..first + Cubic::WIDTH].iter().enumerate() {
                sum += w * stencil.w[D - 1][k] * node[0];
            }
        }
        sum
    }
}
