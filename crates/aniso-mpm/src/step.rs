//! The symplectic step (document 001, alg. 3 and 6): particles to grid, grid velocity, grid to particles.

use crate::blocks::{BLOCK_NODES, BLOCKS};
use crate::damage::DamageOutput;
use crate::error::{MpmError, Rejection};
use crate::float::{Float, all_finite, worse};
use crate::obstacle::Obstacle;
use crate::simulation::{Integrator, Simulation};
use crate::stresses::kirchhoff_stresses;
use crate::transfer::{GridToParticles, NextChunk, ParticlesToGrid, Scheme, Worst};
use crate::window::{CHUNK, Node};
use fem_kinematics::{Quad, QuadKernel, dispatch_quads};
use fem_materials::DamageField;
use fem_solvers::parallel;
use std::marker::PhantomData;

/// How often a rejected step is halved before it becomes an error.
const MAX_HALVINGS: usize = 20;
/// Steps between two searches for the fastest elastic wave.
const WAVE_INTERVAL: usize = 16;

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameInfo {
    /// Steps taken.
    pub substeps: usize,
    /// Steps rejected and retried with half the length.
    pub rejected: usize,
    /// Shortest step, s.
    pub shortest: f64,
}

impl<T: Float, S: Scheme, M: DamageField<D>, const D: usize> Simulation<T, S, M, D> {
    /// Advances by `duration` seconds in as many steps as motion, waves and deformation ask for.
    ///
    /// # Errors
    /// A state that stays wrong however short the step; the state of the last good step is kept.
    pub fn advance(&mut self, duration: f64) -> Result<FrameInfo, MpmError> {
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(MpmError::Parameter {
                what: "duration",
                value: duration,
                need: "finite and not negative",
            });
        }
        let end = self.time + duration;
        let mut info = FrameInfo {
            shortest: f64::INFINITY,
            ..FrameInfo::default()
        };
        let mut left = duration;
        while left > 0.0 {
            if self.steps.is_multiple_of(WAVE_INTERVAL) {
                self.wave_speed = self.fastest_wave();
            }
            let stable = self.stable_step();
            // Equal steps to the end of the frame instead of a sliver at the end.
            let count = worse(1.0, (left / stable).ceil());
            if !(info.substeps as f64 + count <= self.settings.max_substeps as f64) {
                return Err(MpmError::TooManySubsteps {
                    time: self.time,
                    dt: stable,
                    limit: self.settings.max_substeps,
                });
            }
            let mut dt = left / count;
            for halving in 0.. {
                match self.step(dt) {
                    Ok(()) => break,
                    Err(MpmError::StepRejected { .. }) if halving < MAX_HALVINGS => {
                        info.rejected += 1;
                        dt *= 0.5;
                    }
                    Err(error) => return Err(error),
                }
            }
            info.substeps += 1;
            info.shortest = info.shortest.min(dt);
            left = end - self.time;
            if left < 1e-9 * dt {
                self.time = end;
                left = 0.0;
            }
        }
        Ok(info)
    }

    /// One step of exactly `dt` seconds.
    ///
    /// # Errors
    /// [`MpmError::StepRejected`] where a particle would become non-finite or deform by more than
    /// the step may deform it; the state is then unchanged and a shorter step may be tried.
    pub fn step(&mut self, dt: f64) -> Result<(), MpmError> {
        crate::error::positive("time step", dt)?;
        if self.particles.is_empty() {
            self.time += dt;
            self.steps += 1;
            return Ok(());
        }
        // "Begin MPM like usual": find the grid.
        self.binning.rebuild(&self.particles.x)?;
        // "... until just before computeGridVelocity": new damage from the old state.
        let new_damage = self.new_damage(dt)?;
        let damage = new_damage.as_ref();
        // "Continue MPM like usual using the new updated damage values".
        match self.settings.integrator {
            Integrator::Symplectic => {
                self.particles_to_grid(dt, damage);
                self.grid_velocity(dt);
            }
            Integrator::Implicit(options) => {
                self.particles_to_grid(0.0, damage);
                self.grid_velocity(dt);
                self.implicit_velocity(dt, damage, &options)?;
            }
        }
        if self.has_inextensible_fibers() {
            self.project_onto_inextensible(dt)?;
        }
        self.next.resize_like(&self.particles);
        let worst = self.grid_to_particles(dt, damage);
        self.accept(dt, worst, damage)
    }

    /// Without a `damage` of its own the step goes on with that of the particles.
    pub(crate) fn particles_to_grid(&mut self, dt: f64, damage: Option<&DamageOutput<T>>) {
        let forces = dt > 0.0;
        if forces {
            let d = damage.map_or(&self.particles.damage, |damage| &damage.d);
            let (bodies, d) = (&self.bodies[..], Some(&d[..]));
            kirchhoff_stresses(&self.particles, bodies, d, |_| true, &mut self.tau);
        }
        let task = ParticlesToGrid::<T, S, D> {
            particles: &self.particles,
            tau: forces.then_some(&self.tau[..]),
            h: T::from_f64(self.settings.cell_size),
            dt: T::from_f64(dt),
            scheme: PhantomData,
        };
        self.binning
            .scatter(&task, &mut self.windows, &mut self.field);
    }

    /// Momentum to velocity, gravity and obstacles.
    pub(crate) fn grid_velocity(&mut self, dt: f64) {
        let (h, time) = (self.settings.cell_size, self.time + dt);
        let mut gravity = [T::zero(); 4];
        for a in 0..D {
            gravity[a] = T::from_f64(self.settings.gravity[a] * dt);
        }
        let (nodes, obstacles) = (&self.binning.nodes, &self.obstacles[..]);
        let tasks = self.field.chunks_mut(BLOCKS * BLOCK_NODES).enumerate();
        parallel::each(tasks, |(task, blocks)| {
            dispatch_quads(Velocities {
                nodes: &mut *blocks,
                gravity,
            });
            if !obstacles.is_empty() {
                for (local, node) in blocks.iter_mut().enumerate() {
                    if node[3] > T::zero() {
                        let at = nodes.node(task * BLOCKS * BLOCK_NODES + local);
                        meet(node, at.map(|i| f64::from(i) * h), time, obstacles);
                    }
                }
            }
        });
    }

    fn grid_to_particles(&mut self, dt: f64, damage: Option<&DamageOutput<T>>) -> Worst {
        let (particles, binning, field) = (&self.particles, &self.binning, &self.field[..]);
        let next = &mut self.next;
        let motion = next.x.chunks_mut(CHUNK).zip(next.v.chunks_mut(CHUNK));
        let deformation = next.C.chunks_mut(CHUNK).zip(next.F.chunks_mut(CHUNK));
        let tasks: Vec<_> = motion.zip(deformation).enumerate().collect();
        let worst: Vec<Worst> = parallel::map(tasks, |(chunk, ((x, v), (C, F)))| {
            let first = chunk * CHUNK;
            let ranks = first..first + x.len();
            let mut visitor = GridToParticles::<T, S, D> {
                particles,
                h: T::from_f64(binning.h),
                dt: T::from_f64(dt),
                first,
                next: NextChunk { x, v, C, F },
                worst: Worst {
                    not_finite: None,
                    too_fast: None,
                },
                scheme: PhantomData,
            };
            binning.visit(field, ranks, &mut visitor);
            visitor.worst
        });
        self.carry_over(damage);
        worst.into_iter().fold(
            Worst {
                not_finite: None,
                too_fast: None,
            },
            |a, b| Worst {
                not_finite: a.not_finite.or(b.not_finite),
                too_fast: a.too_fast.or(b.too_fast),
            },
        )
    }

    /// What a particle keeps, in the new order.
    fn carry_over(&mut self, damage: Option<&DamageOutput<T>>) {
        let (old, next) = (&self.particles, &mut self.next);
        let order = &self.binning.order[..];
        let (d, history) = damage.map_or((&old.damage, &old.history), |new| (&new.d, &new.history));
        let tasks = next
            .mass
            .chunks_mut(CHUNK)
            .zip(next.volume.chunks_mut(CHUNK));
        let tasks = tasks.zip(next.damage.chunks_mut(CHUNK));
        let tasks = tasks.zip(next.history.chunks_mut(CHUNK));
        let tasks = tasks.zip(next.body.chunks_mut(CHUNK));
        let tasks = tasks.zip(next.id.chunks_mut(CHUNK));
        parallel::each(
            tasks.zip(order.chunks(CHUNK)),
            |((((((mass, volume), new_d), new_history), body), id), order)| {
                // Slices of one length, which the compiler knows: one check of a particle serves all.
                let (count, chunk) = (old.len(), order.len());
                let (old_mass, old_volume) = (&old.mass[..count], &old.volume[..count]);
                let (d, history) = (&d[..count], &history[..count]);
                let (old_body, old_id) = (&old.body[..count], &old.id[..count]);
                let (mass, volume) = (&mut mass[..chunk], &mut volume[..chunk]);
                let (new_d, new_history) = (&mut new_d[..chunk], &mut new_history[..chunk]);
                let (body, id) = (&mut body[..chunk], &mut id[..chunk]);
                for (k, &p) in order.iter().enumerate() {
                    let p = p as usize;
                    mass[k] = old_mass[p];
                    volume[k] = old_volume[p];
                    new_d[k] = d[p];
                    new_history[k] = history[p];
                    body[k] = old_body[p];
                    id[k] = old_id[p];
                }
            },
        );
    }

    /// Makes the next state the current one if it is good.
    fn accept(
        &mut self,
        dt: f64,
        worst: Worst,
        damage: Option<&DamageOutput<T>>,
    ) -> Result<(), MpmError> {
        let reject = |particle, reason| MpmError::StepRejected {
            time: self.time,
            dt,
            particle,
            reason,
        };
        if let Some(particle) = worst.not_finite {
            return Err(reject(particle, Rejection::NotFinite));
        }
        if let Some(particle) = worst.too_fast {
            return Err(reject(particle, Rejection::TooFast));
        }
        if let Some(particle) = damage.and_then(impossible_damage) {
            return Err(reject(particle, Rejection::Damage));
        }
        std::mem::swap(&mut self.particles, &mut self.next);
        self.time += dt;
        self.steps += 1;
        Ok(())
    }
}

/// The first particle with a damage outside [0, 1] or a history that is not finite.
fn impossible_damage<T: Float>(damage: &DamageOutput<T>) -> Option<usize> {
    let chunks = damage.d.chunks(CHUNK).zip(damage.history.chunks(CHUNK));
    let wrong: Vec<Option<usize>> = parallel::map(chunks.collect(), |(d, history)| {
        let mut all = d.iter().zip(history);
        all.position(|(d, h)| !(*d >= T::zero() && *d <= T::one() && h.is_finite()))
    });
    let mut wrong = wrong.into_iter().enumerate();
    wrong.find_map(|(chunk, at)| Some(chunk * CHUNK + at?))
}

/// Momentum to velocity, plus `gravity` (m/s, already times Δt).
struct Velocities<'a, T> {
    nodes: &'a mut [Node<T>],
    gravity: Node<T>,
}
impl<T: Float> QuadKernel<T> for Velocities<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<Q: Quad<T>>(self) {
        let gravity = Q::load(&self.gravity);
        for node in self.nodes {
            let mass = node[3];
            if mass > T::TINY {
                (Q::load(node) / Q::splat(mass) + gravity).store(node);
                node[3] = mass;
            } else {
                *node = [T::zero(); 4];
            }
        }
    }
}

/// Applies every obstacle that holds the node, in their order.
#[inline]
fn meet<T: Float, const D: usize>(
    node: &mut Node<T>,
    x: [f64; D],
    time: f64,
    obstacles: &[Obstacle<D>],
) {
    let mut v: [f64; D] = core::array::from_fn(|a| node[a].to_f64());
    let mut touched = false;
    for obstacle in obstacles {
        if let Some(constraint) = obstacle.constraint(x, time) {
            v = constraint.apply(v);
            touched = true;
        }
    }
    if touched && all_finite(&v) {
        for a in 0..D {
            node[a] = T::from_f64(v[a]);
        }
    }
}
