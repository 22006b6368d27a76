//! B and Bᵀ by loops over particles, and the coefficients of alg. 11 that need no matrix.

use crate::binning::Binning;
use crate::error::{MpmError, same_length};
use crate::float::Float;
use crate::kernels::{Linear, Quadratic, Spline, Stencil};
use crate::window::{Gather, Node, Scatter, rows, window_start};
use fem_kinematics::{Mat, Quad, dot};

/// Particles with a fiber direction, sorted on a grid.
///
/// Node and cell vectors have one entry per node of the grid's blocks; cell z has its center at
/// h (z + ½) and shares the number of node z.
#[derive(Clone, Debug)]
pub struct FiberGrid<const D: usize> {
    pub(crate) binning: Binning<Quadratic, D>,
    pub(crate) x: Vec<[f64; D]>,
    /// V_p, m³.
    pub(crate) volume: Vec<f64>,
    /// Unit fiber directions in the world.
    pub(crate) a: Vec<[f64; D]>,
}

impl<const D: usize> FiberGrid<D> {
    /// Sorts the particles at `x` (m) with current volumes `volume` (m³) and fibers `a` (alg. 11
    /// line 6). A fiber is a direction: `a` is normalized here, and 0 (a collapsed fiber) takes
    /// the particle out of the constraint.
    ///
    /// # Errors
    /// Lengths that differ, or a particle that no grid can hold.
    pub fn new<T: Float>(
        h: f64,
        x: &[[T; D]],
        volume: &[T],
        a: &[[T; D]],
    ) -> Result<Self, MpmError> {
        same_length("volume", volume.len(), x.len())?;
        same_length("fiber direction", a.len(), x.len())?;
        let x: Vec<[f64; D]> = x.iter().map(|x| x.map(Float::to_f64)).collect();
        let mut binning = Binning::new(h);
        binning.rebuild(&x)?;
        let unit = |a: &[T; D]| {
            let a = a.map(Float::to_f64);
            let length = dot(a, a).sqrt();
            let scale = if length > 0.0 && length.is_finite() {
                1.0 / length
            } else {
                0.0
            };
            a.map(|a| a * scale)
        };
        Ok(Self {
            binning,
            volume: volume.iter().map(|v| v.to_f64()).collect(),
            a: a.iter().map(unit).collect(),
            x,
        })
    }

    /// The blocks that node and cell vectors are laid out on.
    pub fn node_blocks(&self) -> &crate::blocks::BlockSet<D> {
        self.binning.node_blocks()
    }

    /// Entries of a node or cell vector.
    pub fn len(&self) -> usize {
        self.binning.field_len()
    }
    /// No particle at all?
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// m_i = Σ_p w_ip m_p, kg.
    ///
    /// # Errors
    /// Lengths that differ.
    pub fn node_mass(&self, mass: &[f64]) -> Result<Vec<f64>, MpmError> {
        same_length("mass", mass.len(), self.x.len())?;
        let (mut windows, mut field) = (Vec::new(), Vec::new());
        let task = SpreadMass { grid: self, mass };
        self.binning.scatter(&task, &mut windows, &mut field);
        Ok(field.iter().map(|node| node[0]).collect())
    }

    /// b_iα = (m_i/Δt) v_iα − Σ_p V_p σ_αβ N_i,β (alg. 11, line 7), N.
    ///
    /// # Errors
    /// Lengths that differ.
    pub fn right_hand_side(
        &self,
        mass: &[f64],
        v: &[[f64; D]],
        sigma: &[Mat<f64, D>],
        dt: f64,
    ) -> Result<Vec<[f64; D]>, MpmError> {
        // ERRATUM: printed m_ii is m_i.
        same_length("stress", sigma.len(), self.x.len())?;
        let (mut windows, mut field) = (Vec::new(), Vec::new());
        let task = SpreadStress { grid: self, sigma };
        self.binning.scatter(&task, &mut windows, &mut field);
        Ok((0..field.len())
            .map(|i| core::array::from_fn(|a| mass[i] / dt * v[i][a] - field[i][a]))
            .collect())
    }

    /// B v on the cells: Σ_p V_p Γ_z (a·∇v a), by particles.
    pub fn apply(&self, v: &[[f64; D]]) -> Vec<f64> {
        let field: Vec<Node<f64>> = v
            .iter()
            .map(|v| core::array::from_fn(|c| if c < D { v[c] } else { 0.0 }))
            .collect();
        let rates = self.binning.gather(&field, &ReadStretchRate { grid: self });
        let (mut windows, mut cells) = (Vec::new(), Vec::new());
        let task = SpreadToCells {
            grid: self,
            value: &rates,
        };
        self.binning.scatter(&task, &mut windows, &mut cells);
        cells.iter().map(|cell| cell[0]).collect()
    }

    /// Bᵀ λ on the nodes: Σ_p V_p λ(x_p) a (a·∇N_i), by particles.
    pub fn apply_transpose(&self, lambda: &[f64]) -> Vec<[f64; D]> {
        let field: Vec<Node<f64>> = lambda.iter().map(|&l| [l, 0.0, 0.0, 0.0]).collect();
        let tension = self.binning.gather(&field, &ReadCells { grid: self });
        let (mut windows, mut nodes) = (Vec::new(), Vec::new());
        let task = SpreadTension {
            grid: self,
            tension: &tension,
        };
        self.binning.scatter(&task, &mut windows, &mut nodes);
        nodes
            .iter()
            .map(|node| core::array::from_fn(|a| node[a]))
            .collect()
    }

    /// L λ = B M⁻¹ Bᵀ λ without a matrix; `inverse_mass` is Δt/m_i, 0 where there is no mass.
    pub fn apply_schur(&self, inverse_mass: &[f64], lambda: &[f64]) -> Vec<f64> {
        let mut v = self.apply_transpose(lambda);
        for (v, &m) in v.iter_mut().zip(inverse_mass) {
            *v = v.map(|v| v * m);
        }
        self.apply(&v)
    }

    #[inline(always)]
    pub(crate) fn nodes_of(&self, p: usize) -> Stencil<f64, D> {
        Stencil::new::<Quadratic>(&self.x[p], self.binning.h)
    }

    /// The cells under a particle; their first one has the number of the first node.
    #[inline(always)]
    pub(crate) fn cells_of(&self, p: usize) -> Stencil<f64, D> {
        let h = self.binning.h;
        let y = self.x[p].map(|x| x / h - 0.5);
        Stencil::new::<Linear>(&y, 1.0)
    }
}

struct SpreadMass<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
    mass: &'a [f64],
}
impl<const D: usize> Scatter<f64, D> for SpreadMass<'_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let stencil = self.grid.nodes_of(p);
        each_node(&stencil, origin, |at, n| {
            window[at][0] += stencil.weight(n) * self.mass[p];
        });
    }
}

struct SpreadStress<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
    sigma: &'a [Mat<f64, D>],
}
impl<const D: usize> Scatter<f64, D> for SpreadStress<'_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let stencil = self.grid.nodes_of(p);
        let stress = self.sigma[p].scale(self.grid.volume[p]);
        each_node(&stencil, origin, |at, n| {
            let force = stress.mul_vec(stencil.gradient(n));
            for a in 0..D {
                window[at][a] += force[a];
            }
        });
    }
}

struct SpreadTension<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
    tension: &'a [f64],
}
impl<const D: usize> Scatter<f64, D> for SpreadTension<'_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let stencil = self.grid.nodes_of(p);
        let a = self.grid.a[p];
        let tension = self.tension[p] * self.grid.volume[p];
        each_node(&stencil, origin, |at, n| {
            let pull = tension * dot(a, stencil.gradient(n));
            for c in 0..D {
                window[at][c] += pull * a[c];
            }
        });
    }
}

struct ReadStretchRate<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
}
impl<const D: usize> Gather<f64, D> for ReadStretchRate<'_, D> {
    type Output = f64;
    #[inline(always)]
    fn gather<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &[Node<f64>]) -> f64 {
        let stencil = self.grid.nodes_of(p);
        let a = self.grid.a[p];
        let mut rate = 0.0;
        each_node(&stencil, origin, |at, n| {
            let along: f64 = (0..D).map(|c| a[c] * window[at][c]).sum();
            rate += along * dot(a, stencil.gradient(n));
        });
        rate
    }
}

struct SpreadToCells<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
    value: &'a [f64],
}
impl<const D: usize> Scatter<f64, D> for SpreadToCells<'_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let stencil = self.grid.cells_of(p);
        let value = self.value[p] * self.grid.volume[p];
        each_cell(&stencil, origin, |at, n| {
            window[at][0] += stencil.weight(n) * value;
        });
    }
}

struct ReadCells<'a, const D: usize> {
    grid: &'a FiberGrid<D>,
}
impl<const D: usize> Gather<f64, D> for ReadCells<'_, D> {
    type Output = f64;
    #[inline(always)]
    fn gather<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &[Node<f64>]) -> f64 {
        let stencil = self.grid.cells_of(p);
        let mut sum = 0.0;
        each_cell(&stencil, origin, |at, n| {
            sum += stencil.weight(n) * window[at][0];
        });
        sum
    }
}

/// Every node of a quadratic stencil: its place in the window and in the stencil.
#[inline(always)]
fn each_node<const D: usize>(
    stencil: &Stencil<f64, D>,
    origin: [i32; D],
    mut visit: impl FnMut(usize, [usize; D]),
) {
    let start = window_start::<Quadratic, D>(stencil.base, origin);
    for (first, i, j) in rows::<Quadratic, D>(start) {
        for k in 0..Quadratic::WIDTH {
            visit(first + k, place(i, j, k));
        }
    }
}

/// Every cell of a linear stencil, in the window of the quadratic one.
#[inline(always)]
fn each_cell<const D: usize>(
    stencil: &Stencil<f64, D>,
    origin: [i32; D],
    mut visit: impl FnMut(usize, [usize; D]),
) {
    let start = window_start::<Quadratic, D>(stencil.base, origin);
    for (first, i, j) in rows::<Quadratic, D>(start) {
        if i < 2 && j < 2 {
            for k in 0..2 {
                visit(first + k, place(i, j, k));
            }
        }
    }
}

#[inline(always)]
fn place<const D: usize>(i: usize, j: usize, k: usize) -> [usize; D] {
    if D == 2 {
        core::array::from_fn(|a| [i, k][a])
    } else {
        core::array::from_fn(|a| [i, j, k][a])
    }
}
