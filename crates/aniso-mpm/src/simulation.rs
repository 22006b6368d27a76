//! The host: bodies, particles, obstacles and the settings of a run.

use crate::binning::Binning;
use crate::body::{Body, Fiber};
use crate::damage::{Augmentation, DamageUpdate};
use crate::error::{MpmError, positive};
use crate::float::{Float, worse};
use crate::implicit::ImplicitStep;
use crate::obstacle::Obstacle;
use crate::particles::Particles;
use crate::transfer::Scheme;
use crate::wave_speed::wave_speed;
use crate::window::{CHUNK, Node};
use fem_kinematics::Mat;
use fem_materials::DamageField;
use fem_solvers::parallel;

/// Numbers that steer a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<const D: usize> {
    /// Cell size Δx, m.
    pub cell_size: f64,
    /// Gravity, m/s².
    pub gravity: [f64; D],
    /// No particle moves farther than this many cells in one step.
    pub cfl: f64,
    /// No elastic wave runs farther than this many cells in one step.
    pub stiffness: f64,
    /// Longest step, s.
    pub max_step: f64,
    /// A frame that needs more steps than this is an error.
    pub max_substeps: usize,
    /// How damage moves in time, for bodies that have it.
    pub damage_update: DamageUpdate,
    /// How velocities move in time.
    pub integrator: Integrator,
}

/// Where the internal force of a step is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Integrator {
    /// At the start: symplectic Euler, with steps shorter than an elastic wave needs per cell.
    Symplectic,
    /// At the end: backward Euler, stable for long steps; only motion limits them.
    Implicit(ImplicitStep),
}

impl<const D: usize> Settings<D> {
    /// Earth's gravity along the last axis and conservative step limits.
    pub fn new(cell_size: f64) -> Self {
        let mut gravity = [0.0; D];
        gravity[D - 1] = -9.81;
        Self {
            cell_size,
            gravity,
            cfl: 0.4,
            stiffness: 0.4,
            max_step: f64::INFINITY,
            max_substeps: 1_000_000,
            damage_update: DamageUpdate::Explicit,
            integrator: Integrator::Symplectic,
        }
    }

    fn check(&self) -> Result<(), MpmError> {
        positive("cell_size", self.cell_size)?;
        positive("cfl", self.cfl)?;
        positive("stiffness", self.stiffness)?;
        if !(self.max_step > 0.0) {
            positive("max_step", self.max_step)?;
        }
        match self.gravity.iter().find(|g| !g.is_finite()) {
            Some(&value) => Err(MpmError::Parameter {
                what: "gravity",
                value,
                need: "finite",
            }),
            None => Ok(()),
        }
    }
}

/// A material-point simulation in `D` dimensions: state in `T` (`f64` or `f32`), transfers by `S`.
#[derive(Clone, Debug)]
pub struct Simulation<T, S: Scheme, M, const D: usize> {
    pub(crate) settings: Settings<D>,
    pub(crate) bodies: Vec<Body<M, D>>,
    pub(crate) obstacles: Vec<Obstacle<D>>,
    pub(crate) particles: Particles<T, D>,
    /// The next state is written here and swapped in when it is found good.
    pub(crate) next: Particles<T, D>,
    pub(crate) time: f64,
    pub(crate) steps: usize,
    pub(crate) wave_speed: f64,
    pub(crate) binning: Binning<S::Kernel, D>,
    pub(crate) windows: Vec<Node<T>>,
    pub(crate) field: Vec<Node<T>>,
    pub(crate) augmentation: Augmentation<D>,
    /// Kirchhoff stresses, workspace; the damage update makes Cauchy stresses of them.
    pub(crate) tau: Vec<Mat<T, D>>,
    /// Current volumes, workspace of the damage update.
    pub(crate) current_volume: Vec<T>,
}

/// Energies of the whole body, J (J/m in 2D).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// ½ Σ m |v|² of the particles and of their affine motion.
    pub kinetic: f64,
    /// Σ V₀ ψ(F, d).
    pub elastic: f64,
    /// −Σ m g·x.
    pub gravitational: f64,
    /// Σ V₀ d: the volume that is broken, m³ (m²).
    pub damaged_volume: f64,
}

impl<T: Float, S: Scheme, M: DamageField<D>, const D: usize> Simulation<T, S, M, D> {
    /// A simulation at time 0.
    ///
    /// # Errors
    /// Settings, obstacles, bodies or particles that make no sense; for a particle, which one and
    /// which field.
    pub fn new(
        settings: Settings<D>,
        bodies: Vec<Body<M, D>>,
        obstacles: Vec<Obstacle<D>>,
        particles: Particles<T, D>,
    ) -> Result<Self, MpmError> {
        settings.check()?;
        obstacles.iter().try_for_each(Obstacle::check)?;
        for body in &bodies {
            if let Some(damage) = &body.damage {
                damage.parameters.check()?;
                damage.directors.check()?;
            }
        }
        particles.check(bodies.len())?;
        let mut simulation = Self {
            settings,
            bodies,
            obstacles,
            next: Particles::new(),
            particles,
            time: 0.0,
            steps: 0,
            wave_speed: 0.0,
            binning: Binning::new(settings.cell_size),
            windows: Vec::new(),
            field: Vec::new(),
            augmentation: Augmentation::new(settings.cell_size, settings.damage_update),
            tau: Vec::new(),
            current_volume: Vec::new(),
        };
        simulation.wave_speed = simulation.fastest_wave();
        Ok(simulation)
    }

    /// The particles, roughly in grid order.
    pub fn particles(&self) -> &Particles<T, D> {
        &self.particles
    }
    /// The bodies.
    pub fn bodies(&self) -> &[Body<M, D>] {
        &self.bodies
    }
    /// The obstacles.
    pub fn obstacles(&self) -> &[Obstacle<D>] {
        &self.obstacles
    }
    /// The settings.
    pub fn settings(&self) -> &Settings<D> {
        &self.settings
    }
    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }
    /// Steps taken so far.
    pub fn steps(&self) -> usize {
        self.steps
    }
    /// Node blocks that the last step touched, 64 nodes each.
    pub fn active_blocks(&self) -> usize {
        self.binning.nodes.len()
    }

    pub(crate) fn can_tear(&self) -> bool {
        self.bodies.iter().any(|body| body.damage.is_some())
    }
    pub(crate) fn has_inextensible_fibers(&self) -> bool {
        self.bodies
            .iter()
            .any(|body| body.fiber == Fiber::Inextensible)
    }

    /// Largest elastic wave speed over all particles, m/s.
    pub(crate) fn fastest_wave(&self) -> f64 {
        let p = &self.particles;
        let speed = |i: usize| {
            let F = Mat::from_fn(|a, b| p.F[i].0[a][b].to_f64());
            let density = p.mass[i].to_f64() / p.volume[i].to_f64();
            let material = &self.bodies[p.body[i] as usize].material;
            wave_speed(material, &F, p.damage[i].to_f64(), density)
        };
        let fastest: Vec<f64> = parallel::indexed(p.len().div_ceil(CHUNK), |chunk| {
            let range = chunk * CHUNK..p.len().min((chunk + 1) * CHUNK);
            range.map(speed).fold(0.0, worse)
        });
        fastest.into_iter().fold(0.0, worse)
    }

    /// The longest step that motion and elastic waves allow now, s.
    pub fn stable_step(&self) -> f64 {
        let h = self.settings.cell_size;
        let speed = self
            .particles
            .v
            .iter()
            .map(|v| v.iter().map(|c| c.to_f64() * c.to_f64()).sum::<f64>())
            .fold(0.0, worse)
            .sqrt();
        let obstacle_speed = self
            .obstacles
            .iter()
            .map(|o| o.velocity.iter().map(|v| v * v).sum::<f64>())
            .fold(0.0, worse)
            .sqrt();
        let motion = self.settings.cfl * h / (speed + obstacle_speed);
        let waves = match self.settings.integrator {
            Integrator::Symplectic => self.settings.stiffness * h / self.wave_speed,
            Integrator::Implicit(_) => f64::INFINITY,
        };
        // The smallest of the three; NaN if one is, which no number of substeps allows.
        -worse(-self.settings.max_step, worse(-motion, -waves))
    }

    /// Energies now.
    pub fn energies(&self) -> Energies {
        let (p, h) = (&self.particles, self.settings.cell_size);
        let inertia = <S::Kernel as crate::kernels::Spline>::INERTIA.unwrap_or(0.0) * h * h;
        let partial: Vec<Energies> = parallel::indexed(p.len().div_ceil(CHUNK), |chunk| {
            let mut e = Energies::default();
            for i in chunk * CHUNK..p.len().min((chunk + 1) * CHUNK) {
                let m = p.mass[i].to_f64();
                let volume = p.volume[i].to_f64();
                let F = Mat::from_fn(|a, b| p.F[i].0[a][b].to_f64());
                let d = p.damage[i].to_f64();
                for a in 0..D {
                    e.kinetic += 0.5 * m * p.v[i][a].to_f64().powi(2);
                    e.gravitational -= m * self.settings.gravity[a] * p.x[i][a].to_f64();
                    for b in 0..D {
                        e.kinetic += 0.5 * m * inertia * p.C[i].0[a][b].to_f64().powi(2);
                    }
                }
                let material = &self.bodies[p.body[i] as usize].material;
                e.elastic += volume * material.energy(&M::at_damage(d), &F);
                e.damaged_volume += volume * d;
            }
            e
        });
        partial.iter().fold(Energies::default(), |a, b| Energies {
            kinetic: a.kinetic + b.kinetic,
            elastic: a.elastic + b.elastic,
            gravitational: a.gravitational + b.gravitational,
            damaged_volume: a.damaged_volume + b.damaged_volume,
        })
    }
}
