//! The damage of one substep, to be called just before the grid velocities are computed
//! (document 001, alg. 3 and alg. 6).

use super::DamageModel;
use super::driving_force::driving_force;
use super::explicit::explicit_update;
use super::grid::DamageGrid;
use super::implicit::{ImplicitOptions, ImplicitSystem};
use crate::blocks::{block_of, key};
use crate::dispatch::dispatch;
use crate::error::{MpmError, same_length};
use crate::float::Float;
use crate::kernels::{Cubic, locate};
use fem_kinematics::{Kernel, Mat};
use fem_solvers::parallel;
use std::collections::HashSet;

/// How damage moves in time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DamageUpdate {
    /// Alg. 3-5: one evaluation per particle, stable for small Δt/η.
    Explicit,
    /// Alg. 6-10: one linear solve per step, stable for any Δt.
    Implicit(ImplicitOptions),
}

/// What an augmentation reads; slices with one entry per particle.
#[derive(Clone, Copy, Debug)]
pub struct DamageInput<'a, T, const D: usize> {
    /// Positions, m.
    pub x: &'a [[T; D]],
    /// Deformation gradients.
    pub F: &'a [Mat<T, D>],
    /// Un-degraded Cauchy stresses, Pa.
    pub sigma: &'a [Mat<T, D>],
    /// Current volumes V_p, m³; read by the implicit update.
    pub volume: &'a [T],
    /// Damage d_p.
    pub d: &'a [T],
    /// History D̃^H of the driving force.
    pub history: &'a [T],
}

/// The result of an augmentation: what the host carries into its next step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DamageOutput<T> {
    /// d^{n+1}.
    pub d: Vec<T>,
    /// D̃^{H,n}.
    pub history: Vec<T>,
}

/// Damage as a plug-in: the grid it needs and the way it moves in time.
#[derive(Clone, Debug)]
pub struct Augmentation<const D: usize> {
    grid: DamageGrid<D>,
    update: DamageUpdate,
    active_blocks: usize,
}

/// The damage model of each particle, `None` for one that cannot tear.
pub type ModelOf<'a, const D: usize> = dyn Fn(usize) -> Option<DamageModel<D>> + Sync + 'a;

/// Particles per task where the driving force is computed.
const CHUNK: usize = 256;

impl<const D: usize> Augmentation<D> {
    /// Damage on a grid of cell size `h` (m).
    pub fn new(h: f64, update: DamageUpdate) -> Self {
        Self {
            grid: DamageGrid::new(h),
            update,
            active_blocks: 0,
        }
    }

    /// The way it moves in time.
    pub fn update(&self) -> DamageUpdate {
        self.update
    }

    /// Blocks of 64 nodes that the last step's damage grid had: 0 where nothing could happen.
    pub fn active_blocks(&self) -> usize {
        self.active_blocks
    }

    /// One substep of `dt` seconds. A particle that cannot tear keeps its damage and
    /// is left out of the grid.
    ///
    /// Where neither d nor D̃ is positive nothing can happen, and no grid is made there.
    ///
    /// # Errors
    /// Slices of different length, a particle that no grid holds, or an implicit solve that failed.
    pub fn step<T: Float>(
        &mut self,
        input: &DamageInput<'_, T, D>,
        model: &ModelOf<'_, D>,
        dt: f64,
    ) -> Result<DamageOutput<T>, MpmError> {
        let count = input.x.len();
        for (what, length) in [
            ("F", input.F.len()),
            ("stress", input.sigma.len()),
            ("volume", input.volume.len()),
            ("damage", input.d.len()),
            ("damage history", input.history.len()),
        ] {
            same_length(what, length, count)?;
        }
        // Alg. 5 lines 5-11, alg. 8: the driving force and its history.
        let mut history = input.history.to_vec();
        parallel::each(history.chunks_mut(CHUNK).enumerate(), |(chunk, history)| {
            dispatch(DrivingForces {
                input,
                model,
                first: chunk * CHUNK,
                history,
            });
        });
        let mut d = input.d.to_vec();
        let near = self.near_damage(input, &history, model);
        self.active_blocks = 0;
        if !near.is_empty() {
            let (x, old): (Vec<_>, Vec<_>) = near.iter().map(|&p| (input.x[p], input.d[p])).unzip();
            // Alg. 4 lines 1-4, alg. 7.
            self.grid.particles_to_grid(&x, &old)?;
            self.active_blocks = self.grid.node_blocks().len();
            let constants = |k: usize| model(near[k]).map(|m| m.parameters);
            let new = match self.update {
                DamageUpdate::Explicit => {
                    // Alg. 4 lines 6-8, alg. 5.
                    let laplacians = self.grid.laplacians();
                    (0..near.len())
                        .map(|k| {
                            let old = old[k].to_f64();
                            constants(k).map_or(old, |parameters| {
                                let force = history[near[k]].to_f64();
                                explicit_update(&parameters, old, force, laplacians[k], dt)
                            })
                        })
                        .collect()
                }
                DamageUpdate::Implicit(options) => {
                    self.implicit(input, &near, &old, &history, model, dt, &options)?
                }
            };
            for (&p, new) in near.iter().zip(new) {
                d[p] = T::from_f64(new);
            }
        }
        Ok(DamageOutput { d, history })
    }

    /// Alg. 9 and 10.
    fn implicit<T: Float>(
        &self,
        input: &DamageInput<'_, T, D>,
        near: &[usize],
        old: &[T],
        history: &[T],
        model: &ModelOf<'_, D>,
        dt: f64,
        options: &ImplicitOptions,
    ) -> Result<Vec<f64>, MpmError> {
        let parameters: Vec<_> = near
            .iter()
            .filter_map(|&p| model(p).map(|m| m.parameters))
            .collect();
        let volume: Vec<T> = near.iter().map(|&p| input.volume[p].abs()).collect();
        let force: Vec<T> = near.iter().map(|&p| history[p]).collect();
        let of = |k: usize| parameters[k];
        let system = ImplicitSystem::new(&self.grid, &volume, &force, old, dt, &of, options)?;
        let solution = system.solve(options.tolerance)?;
        Ok(system.grid_to_particles(&solution))
    }

    /// Particles that can tear and lie within reach of one with d > 0 or D̃ > 0.
    fn near_damage<T: Float>(
        &self,
        input: &DamageInput<'_, T, D>,
        history: &[T],
        model: &ModelOf<'_, D>,
    ) -> Vec<usize> {
        // Explicit: one block around the home block is all that a cubic stencil couples. Implicit:
        // the solution falls off like exp(−distance/l₀) with l₀ of half a cell: three blocks of
        // four cells leave less than 1e-10.
        let margin = match self.update {
            DamageUpdate::Explicit => 1,
            DamageUpdate::Implicit(_) => 3,
        };
        let h = T::from_f64(self.grid.binning.cell_size());
        let home = |p: usize| block_of(locate::<Cubic, T, D>(&input.x[p], h).0);
        let mut active: Vec<u64> = (0..input.x.len())
            .filter(|&p| input.d[p] > T::zero() || history[p] > T::zero())
            .filter(|&p| model(p).is_some())
            .filter_map(|p| key(home(p)))
            .collect();
        if active.is_empty() {
            return Vec::new();
        }
        active.sort_unstable();
        active.dedup();
        let mut reached = HashSet::new();
        let width = 2 * margin + 1;
        for &k in &active {
            let block: [i32; D] = crate::blocks::coordinates(k);
            for n in 0..(width as usize).pow(D as u32) {
                let mut rest = n as i32;
                let neighbor: [i32; D] = core::array::from_fn(|a| {
                    let shift = rest % width - margin;
                    rest /= width;
                    block[a] + shift
                });
                reached.extend(key(neighbor));
            }
        }
        (0..input.x.len())
            .filter(|&p| key(home(p)).is_some_and(|k| reached.contains(&k)))
            .filter(|&p| model(p).is_some())
            .collect()
    }
}

struct DrivingForces<'a, 'b, T, const D: usize> {
    input: &'a DamageInput<'b, T, D>,
    model: &'a ModelOf<'a, D>,
    first: usize,
    history: &'a mut [T],
}
impl<T: Float, const D: usize> Kernel for DrivingForces<'_, '_, T, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (k, history) in self.history.iter_mut().enumerate() {
            let p = self.first + k;
            if let Some(model) = (self.model)(p) {
                *history = driving_force(
                    &model.parameters,
                    &model.directors,
                    &self.input.F[p],
                    &self.input.sigma[p],
                    *history,
                );
            }
        }
    }
}
