//! Implicit damage: the linear system (𝒜 + ℬ) d = c on the grid (document 001, alg. 9 and 10).

use super::grid::{DamageGrid, add_weighted, row_product};
use super::parameters::DamageParameters;
use crate::error::{MpmError, SolveError, same_length};
use crate::float::{Float, worse};
use crate::kernels::{Cubic, Spline, Stencil};
use crate::window::{Gather, Node, Scatter, rows, window_start};
use fem_kinematics::Quad;
use fem_solvers::{Identity, LinearOperator, PcgParams, Structure, pcg};

/// Which damage stands inside the particle sum of c_i (alg. 9, line 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightHandSide {
    /// The node's d_i, as printed: (Σ_p V_p w_ip) d_i. Consistent with the lumped left side.
    GridDamage,
    /// The particle's d_p: Σ_p V_p w_ip d_p. Less diffusion by the transfer.
    ParticleDamage,
}

/// What ∇Θ_i is (alg. 9, line 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradient {
    /// w_ip (3/h²)(x_i − x_p), the moving-least-squares gradient: the reading of the text.
    MlsMpm,
    /// ∇N_i of the cubic B-spline.
    BSpline,
}

/// The readings of alg. 9 and the accuracy of its solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitOptions {
    /// Right-hand side.
    pub right_hand_side: RightHandSide,
    /// Gradient.
    pub gradient: Gradient,
    /// Largest |residual_i| / (𝒜 + ℬ)_ii accepted: an error in d.
    pub tolerance: f64,
}

impl Default for ImplicitOptions {
    fn default() -> Self {
        Self {
            right_hand_side: RightHandSide::GridDamage,
            gradient: Gradient::MlsMpm,
            tolerance: 1e-10,
        }
    }
}

/// 𝒜, ℬ and c for one step, on the nodes of a [`DamageGrid`].
///
/// Vectors have one entry per node of the grid's blocks; nodes under no particle have a unit row.
#[derive(Debug)]
pub struct ImplicitSystem<'a, const D: usize> {
    grid: &'a DamageGrid<D>,
    gradient: Gradient,
    /// V_p Δt/η l₀² of every particle.
    diffusion: Vec<f64>,
    lumped: Vec<f64>,
    diagonal: Vec<f64>,
    right_hand_side: Vec<f64>,
    /// d_p before the step.
    old: Vec<f64>,
}

impl<'a, const D: usize> ImplicitSystem<'a, D> {
    /// Builds the system from a grid that holds d_i (alg. 7).
    ///
    /// `volume`: current volumes V_p (m³); `driving_force`: D̃_p; `d`: d_p; `dt` in seconds;
    /// `parameters(p)`: the constants of particle p.
    ///
    /// # Errors
    /// Lengths that differ from the number of particles on the grid.
    pub fn new<T: Float>(
        grid: &'a DamageGrid<D>,
        volume: &[T],
        driving_force: &[T],
        d: &[T],
        dt: f64,
        parameters: &(dyn Fn(usize) -> DamageParameters + Sync),
        options: &ImplicitOptions,
    ) -> Result<Self, MpmError> {
        let count = grid.x.len();
        same_length("volume", volume.len(), count)?;
        same_length("driving force", driving_force.len(), count)?;
        same_length("damage", d.len(), count)?;
        let mut payload = Vec::with_capacity(count);
        let mut diffusion = Vec::with_capacity(count);
        for p in 0..count {
            let constants = parameters(p);
            let (V, D_tilde) = (volume[p].to_f64(), driving_force[p].to_f64());
            let rate = dt / constants.eta;
            payload.push([
                V * (1.0 + rate * (D_tilde + 1.0)),
                V * rate * D_tilde,
                V,
                V * d[p].to_f64(),
            ]);
            diffusion.push(V * rate * constants.length_scale.powi(2));
        }
        let (mut windows, mut field) = (Vec::new(), Vec::new());
        let sums = WeightedSums {
            x: &grid.x,
            h: grid.binning.h,
            payload: &payload,
        };
        grid.binning.scatter(&sums, &mut windows, &mut field);
        let mut system = Self {
            grid,
            gradient: options.gradient,
            diffusion,
            lumped: vec![0.0; field.len()],
            diagonal: vec![1.0; field.len()],
            right_hand_side: vec![0.0; field.len()],
            old: d.iter().map(|d| d.to_f64()).collect(),
        };
        for (i, [lumped, source, V, Vd]) in field.iter().copied().enumerate() {
            system.lumped[i] = lumped;
            system.right_hand_side[i] = source
                + match options.right_hand_side {
                    // ERRATUM: d_i stands inside the sum over particles and comes out of it.
                    RightHandSide::GridDamage => V * grid.field[i][0],
                    RightHandSide::ParticleDamage => Vd,
                };
        }
        let squares = FluxDiagonal { system: &system };
        grid.binning.scatter(&squares, &mut windows, &mut field);
        for (i, node) in field.iter().enumerate() {
            if system.lumped[i] > 0.0 {
                system.diagonal[i] = system.lumped[i] + node[0];
            }
        }
        Ok(system)
    }

    /// The lumped diagonal 𝒜_ii (alg. 9, line 4).
    pub fn lumped(&self) -> &[f64] {
        &self.lumped
    }
    /// 𝒜_ii + ℬ_ii, the Jacobi preconditioner; 1 for nodes under no particle.
    pub fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }
    /// c (alg. 9, line 2).
    pub fn right_hand_side(&self) -> &[f64] {
        &self.right_hand_side
    }

    /// y = ℬ u: the discrete Laplace operator (alg. 9, line 3), matrix-free.
    pub fn apply_laplace(&self, u: &[f64], y: &mut [f64]) {
        let field: Vec<Node<f64>> = u.iter().map(|&u| [u, 0.0, 0.0, 0.0]).collect();
        let binning = &self.grid.binning;
        let flux = binning.gather(&field, &ReadFlux { system: self });
        let (mut windows, mut sum) = (Vec::new(), Vec::new());
        let spread = SpreadFlux {
            system: self,
            flux: &flux,
        };
        binning.scatter(&spread, &mut windows, &mut sum);
        for (y, node) in y.iter_mut().zip(&sum) {
            *y = node[0];
        }
    }

    /// Solves (𝒜 + ℬ) d = c by conjugate gradients with the Jacobi preconditioner (line 5).
    ///
    /// # Errors
    /// A solve that does not reach the tolerance, with what the solver said.
    pub fn solve(&self, tolerance: f64) -> Result<Vec<f64>, MpmError> {
        let n = self.diagonal.len();
        let failed = |source: SolveError| MpmError::Solve {
            system: "implicit damage",
            source,
        };
        let scale: Vec<f64> = self.diagonal.iter().map(|d| d.sqrt().recip()).collect();
        let scaled = Scaled {
            system: self,
            scale: &scale,
        };
        let mut d: Vec<f64> = self.grid.field.iter().map(|node| node[0]).collect();
        let mut product = vec![0.0; n];
        let mut worst = f64::INFINITY;
        // Node weights span 17 decades and d is wanted on all of them: refine until every row,
        // divided by its diagonal, is solved.
        for _ in 0..8 {
            self.apply_laplace(&d, &mut product);
            let mut residual = vec![0.0; n];
            worst = 0.0f64;
            for i in 0..n {
                // Not `> 0`: a weight that is NaN must not pass for a node under no particle.
                if self.lumped[i] != 0.0 {
                    residual[i] = self.right_hand_side[i] - self.lumped[i] * d[i] - product[i];
                    let error = (residual[i] / self.diagonal[i]).abs();
                    worst = worse(worst, error);
                    residual[i] *= scale[i];
                } else {
                    d[i] = 0.0;
                }
            }
            if worst <= tolerance {
                return Ok(d);
            }
            let params = PcgParams {
                relative_tolerance: 1e-8,
                max_iterations: 1000,
                ..PcgParams::default()
            };
            let mut correction = vec![0.0; n];
            pcg(&scaled, &Identity, &residual, &mut correction, &params)
                .map_err(|error| failed(error.into()))?;
            for i in 0..n {
                d[i] += scale[i] * correction[i];
            }
        }
        Err(failed(SolveError::Residual {
            residual: worst,
            tolerance,
        }))
    }

    /// max(d_p, min(1, Σ_i d_i w_ip)) (alg. 10), d_p being the damage before the step: a particle never
    /// heals.
    // ERRATUM: the history of D̃ does not keep the bracket of section 2.2 positive once there is
    // diffusion; without the old damage the solve heals cracks.
    pub fn grid_to_particles(&self, d_grid: &[f64]) -> Vec<f64> {
        let new = self.as_printed(d_grid).into_iter();
        new.zip(&self.old)
            .map(|(new, &old)| worse(new, old))
            .collect()
    }

    /// min(1, Σ_i d_i w_ip), as alg. 10 has it; NaN stays.
    pub(crate) fn as_printed(&self, d_grid: &[f64]) -> Vec<f64> {
        let mut grid = self.grid.clone();
        for (node, &d) in grid.field.iter_mut().zip(d_grid) {
            node[0] = d;
        }
        let mut d = grid.interpolate();
        d.iter_mut().for_each(|d| *d = d.clamp(0.0, 1.0));
        d
    }

    /// ∇Θ factors of particle p: the stencil and what replaces `w` on the differentiated axis.
    #[inline(always)]
    fn theta(&self, p: usize) -> (Stencil<f64, D>, [[f64; 4]; D]) {
        let h = self.grid.binning.h;
        let stencil = Stencil::new::<Cubic>(&self.grid.x[p], h);
        let gradient = match self.gradient {
            Gradient::BSpline => stencil.dw,
            Gradient::MlsMpm => core::array::from_fn(|a| {
                core::array::from_fn(|k| {
                    let node = h * f64::from(stencil.base[a] + k as i32);
                    stencil.w[a][k] * (3.0 / (h * h)) * (node - self.grid.x[p][a])
                })
            }),
        };
        (stencil, gradient)
    }
}

/// D^{-1/2} (𝒜 + ℬ) D^{-1/2}: plain conjugate gradients on it are Jacobi-preconditioned ones.
struct Scaled<'a, 'g, const D: usize> {
    system: &'a ImplicitSystem<'g, D>,
    scale: &'a [f64],
}
impl<const D: usize> LinearOperator for Scaled<'_, '_, D> {
    fn dim(&self) -> usize {
        self.scale.len()
    }
    fn structure(&self) -> Structure {
        Structure::SymmetricPositiveDefinite
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let u: Vec<f64> = x.iter().zip(self.scale).map(|(x, s)| x * s).collect();
        self.system.apply_laplace(&u, y);
        for i in 0..y.len() {
            y[i] = if self.system.lumped[i] > 0.0 {
                (y[i] + self.system.lumped[i] * u[i]) * self.scale[i]
            } else {
                x[i]
            };
        }
    }
}

struct WeightedSums<'a, const D: usize> {
    x: &'a [[f64; D]],
    h: f64,
    payload: &'a [[f64; 4]],
}
impl<const D: usize> Scatter<f64, D> for WeightedSums<'_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let stencil = Stencil::new::<Cubic>(&self.x[p], self.h);
        add_weighted::<Q, D>(&stencil, self.payload[p], origin, window);
    }
}

struct ReadFlux<'a, 'g, const D: usize> {
    system: &'a ImplicitSystem<'g, D>,
}
impl<const D: usize> Gather<f64, D> for ReadFlux<'_, '_, D> {
    type Output = [f64; 4];
    #[inline(always)]
    fn gather<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &[Node<f64>]) -> [f64; 4] {
        let (stencil, gradient) = self.system.theta(p);
        let start = window_start::<Cubic, D>(stencil.base, origin);
        let last = D - 1;
        let mut flux = [0.0; 4];
        for (first, i, j) in rows::<Cubic, D>(start) {
            let (mut by_w, mut by_g) = (0.0, 0.0);
            for (k, node) in window[first..first + Cubic::WIDTH].iter().enumerate() {
                by_w += stencil.w[last][k] * node[0];
                by_g += gradient[last][k] * node[0];
            }
            let factors = row_product(&stencil.w, &gradient, i, j);
            for a in 0..last {
                flux[a] += factors[a] * by_w;
            }
            flux[last] += factors[last] * by_g;
        }
        flux.map(|f| f * self.system.diffusion[p])
    }
}

struct SpreadFlux<'a, 'g, const D: usize> {
    system: &'a ImplicitSystem<'g, D>,
    flux: &'a [[f64; 4]],
}
impl<const D: usize> Scatter<f64, D> for SpreadFlux<'_, '_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let (stencil, gradient) = self.system.theta(p);
        let start = window_start::<Cubic, D>(stencil.base, origin);
        let (last, flux) = (D - 1, self.flux[p]);
        for (first, i, j) in rows::<Cubic, D>(start) {
            let factors = row_product(&stencil.w, &gradient, i, j);
            let mut by_w = 0.0;
            for a in 0..last {
                by_w += factors[a] * flux[a];
            }
            let by_g = factors[last] * flux[last];
            for (k, node) in window[first..first + Cubic::WIDTH].iter_mut().enumerate() {
                node[0] += stencil.w[last][k] * by_w + gradient[last][k] * by_g;
            }
        }
    }
}

struct FluxDiagonal<'a, 'g, const D: usize> {
    system: &'a ImplicitSystem<'g, D>,
}
impl<const D: usize> Scatter<f64, D> for FluxDiagonal<'_, '_, D> {
    #[inline(always)]
    fn scatter<Q: Quad<f64>>(&self, p: usize, origin: [i32; D], window: &mut [Node<f64>]) {
        let (stencil, gradient) = self.system.theta(p);
        let start = window_start::<Cubic, D>(stencil.base, origin);
        let last = D - 1;
        for (first, i, j) in rows::<Cubic, D>(start) {
            let factors = row_product(&stencil.w, &gradient, i, j);
            for (k, node) in window[first..first + Cubic::WIDTH].iter_mut().enumerate() {
                let mut square = (factors[last] * gradient[last][k]).powi(2);
                for factor in &factors[..last] {
                    square += (factor * stencil.w[last][k]).powi(2);
                }
                node[0] += self.system.diffusion[p] * square;
            }
        }
    }
}
