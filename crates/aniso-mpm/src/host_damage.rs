//! Where the host calls the damage augmentation.

use crate::body::Body;
use crate::damage::{DamageInput, DamageOutput, cauchy_stress};
use crate::dispatch::dispatch;
use crate::error::MpmError;
use crate::float::Float;
use crate::law::Law;
use crate::particles::Particles;
use crate::simulation::Simulation;
use crate::transfer::Scheme;
use fem_kinematics::{Kernel, Mat};
use rayon::prelude::*;

const CHUNK: usize = 256;

impl<T: Float, S: Scheme, L: Law<D>, const D: usize> Simulation<T, S, L, D> {
    /// Damage and driving-force history at the end of the step, from the state at its start.
    pub(crate) fn new_damage(&mut self, dt: f64) -> Result<DamageOutput<T>, MpmError> {
        let particles = &self.particles;
        if !self.can_tear() {
            return Ok(DamageOutput {
                d: particles.damage.clone(),
                history: particles.history.clone(),
            });
        }
        let bodies = &self.bodies[..];
        self.sigma.resize(particles.len(), Mat::zeros());
        self.current_volume.resize(particles.len(), T::zero());
        self.sigma
            .par_chunks_mut(CHUNK)
            .zip(self.current_volume.par_chunks_mut(CHUNK))
            .enumerate()
            .for_each(|(chunk, (sigma, volume))| {
                dispatch(Stresses {
                    particles,
                    bodies,
                    first: chunk * CHUNK,
                    sigma,
                    volume,
                });
            });
        let input = DamageInput {
            x: &particles.x,
            F: &particles.F,
            sigma: &self.sigma,
            volume: &self.current_volume,
            d: &particles.damage,
            history: &particles.history,
        };
        let model = |p: usize| bodies[particles.body[p] as usize].damage;
        self.augmentation.step(&input, &model, dt)
    }
}

/// Un-degraded Cauchy stresses and current volumes V = J V₀.
struct Stresses<'a, T, L, const D: usize> {
    particles: &'a Particles<T, D>,
    bodies: &'a [Body<L, D>],
    first: usize,
    sigma: &'a mut [Mat<T, D>],
    volume: &'a mut [T],
}
impl<T: Float, L: Law<D>, const D: usize> Kernel for Stresses<'_, T, L, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (k, (sigma, volume)) in self.sigma.iter_mut().zip(self.volume).enumerate() {
            let p = self.first + k;
            let F = &self.particles.F[p];
            let body = &self.bodies[self.particles.body[p] as usize];
            if body.damage.is_some() {
                *sigma = cauchy_stress(&body.law.stress(F, T::zero()), F);
                *volume = self.particles.volume[p] * F.determinant();
            }
        }
    }
}
