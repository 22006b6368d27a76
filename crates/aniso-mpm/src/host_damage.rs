//! Where the host calls the damage augmentation.

use crate::body::Body;
use crate::damage::{DamageInput, DamageOutput, cauchy_from_kirchhoff};
use crate::error::MpmError;
use crate::float::Float;
use crate::simulation::Simulation;
use crate::stresses::kirchhoff_stresses;
use crate::transfer::Scheme;
use fem_materials::DamageField;
use rayon::prelude::*;

const CHUNK: usize = 256;

impl<T: Float, S: Scheme, M: DamageField<D>, const D: usize> Simulation<T, S, M, D> {
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
        let can_tear = |body: &Body<M, D>| body.damage.is_some();
        kirchhoff_stresses(particles, bodies, None, can_tear, &mut self.tau);
        self.current_volume.resize(particles.len(), T::zero());
        (
            &mut self.tau,
            &mut self.current_volume,
            &particles.F,
            &particles.volume,
        )
            .into_par_iter()
            .with_min_len(CHUNK)
            .for_each(|(tau, current_volume, F, &volume)| {
                let J = F.determinant();
                *tau = cauchy_from_kirchhoff(tau, J);
                *current_volume = volume * J;
            });
        let input = DamageInput {
            x: &particles.x,
            F: &particles.F,
            sigma: &self.tau,
            volume: &self.current_volume,
            d: &particles.damage,
            history: &particles.history,
        };
        let model = |p: usize| bodies[particles.body[p] as usize].damage;
        self.augmentation.step(&input, &model, dt)
    }
}
