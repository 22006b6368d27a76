//! Where the host calls the damage augmentation.

use crate::body::Body;
use crate::damage::{DamageInput, DamageOutput, cauchy_from_kirchhoff};
use crate::error::MpmError;
use crate::float::Float;
use crate::simulation::Simulation;
use crate::stresses::kirchhoff_stresses;
use crate::transfer::Scheme;
use fem_materials::DamageField;
use fem_solvers::parallel;

const CHUNK: usize = 256;

impl<T: Float, S: Scheme, M: DamageField<D>, const D: usize> Simulation<T, S, M, D> {
    /// Damage and driving-force history at the end of the step, from the state at its start; nothing
    /// where no body can tear.
    pub(crate) fn new_damage(&mut self, dt: f64) -> Result<Option<DamageOutput<T>>, MpmError> {
        let particles = &self.particles;
        if !self.can_tear() {
            return Ok(None);
        }
        let bodies = &self.bodies[..];
        let can_tear = |body: &Body<M, D>| body.damage.is_some();
        kirchhoff_stresses(particles, bodies, None, can_tear, &mut self.tau);
        self.current_volume.resize(particles.len(), T::zero());
        let now = self.tau.chunks_mut(CHUNK);
        let now = now.zip(self.current_volume.chunks_mut(CHUNK));
        let rest = particles
            .F
            .chunks(CHUNK)
            .zip(particles.volume.chunks(CHUNK));
        parallel::each(now.zip(rest), |((tau, current_volume), (F, volume))| {
            let rest = F.iter().zip(volume);
            for ((tau, current), (F, &volume)) in tau.iter_mut().zip(current_volume).zip(rest) {
                let J = F.determinant();
                *tau = cauchy_from_kirchhoff(tau, J);
                *current = volume * J;
            }
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
        self.augmentation.step(&input, &model, dt).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damage::{
        Augmentation, DamageModel, DamageParameters, DamageUpdate, Directors, ImplicitOptions,
        cauchy_stress,
    };
    use crate::kernels::Quadratic;
    use crate::particles::{Particle, Particles};
    use crate::simulation::Settings;
    use crate::transfer::MlsMpm;
    use fem_kinematics::Mat;
    use fem_materials::{Material, NeoHookean};

    const H: f64 = 0.1;
    const FLESH: NeoHookean = NeoHookean {
        mu: 400.0,
        lambda: 1e3,
    };

    /// The implicit system weighs particles by their current volumes: only where these differ from
    /// each other by another factor than the rest volumes does it matter.
    #[test]
    fn the_host_gives_the_damage_current_volumes_and_stresses() {
        let mut particles = Particles::new();
        for k in 0..64 {
            let stretch = 1.0 + 0.4 * f64::from(k % 5);
            let particle = Particle {
                x: [f64::from(k % 8), f64::from(k / 8)].map(|i| 1.0 + 0.5 * H * i),
                v: [0.0; 2],
                F: Mat([[stretch, 0.1], [0.0, 1.1]]),
                mass: 1e-3,
                volume: 0.25 * H * H,
                damage: 0.1 * f64::from(k % 7),
                body: 0,
            };
            particles.push(&particle).unwrap();
        }
        let damage = DamageModel {
            parameters: DamageParameters::new(H, 1.0, 500.0),
            directors: Directors::Isotropic,
        };
        let body = Body {
            damage: Some(damage),
            ..Body::elastic(FLESH)
        };
        let update = DamageUpdate::Implicit(ImplicitOptions::default());
        let settings = Settings {
            damage_update: update,
            ..Settings::new(H)
        };
        type Host = Simulation<f64, MlsMpm<Quadratic>, NeoHookean, 2>;
        let mut host = Host::new(settings, vec![body], vec![], particles).unwrap();
        let found = host.new_damage(0.01).unwrap().expect("it can tear");

        let p = &host.particles;
        let of = |F: &Mat<f64, 2>| cauchy_stress(&FLESH.stress(F), F);
        let sigma: Vec<_> = p.F.iter().map(of).collect();
        let now = p.F.iter().zip(&p.volume);
        let volume: Vec<f64> = now.map(|(F, v)| v * F.determinant()).collect();
        let input = DamageInput {
            x: &p.x,
            F: &p.F,
            sigma: &sigma,
            volume: &volume,
            d: &p.damage,
            history: &p.history,
        };
        let mut direct = Augmentation::new(H, update);
        let expected = direct.step(&input, &|_| Some(damage), 0.01).unwrap();
        let mut moved = 0;
        for (k, (found, expected)) in found.d.iter().zip(&expected.d).enumerate() {
            assert!(
                (found - expected).abs() < 1e-9,
                "particle {k}: {found} {expected}"
            );
            moved += usize::from(*expected > p.damage[k] + 1e-3);
        }
        assert!(moved > 10, "{moved}");
    }
}
