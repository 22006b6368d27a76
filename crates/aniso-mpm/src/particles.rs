//! The state that particles carry, one array per quantity.

use crate::error::{MpmError, positive, same_length};
use crate::float::{Float, all_finite};
use fem_kinematics::Mat;

/// Particles as a structure of arrays. A simulation keeps them roughly in grid order, so a
/// particle is recognized by its [`id`](Particles::id), not by its place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles<T, const D: usize> {
    /// Positions, m.
    pub x: Vec<[T; D]>,
    /// Velocities, m/s.
    pub v: Vec<[T; D]>,
    /// Affine velocity (APIC), 1/s.
    pub C: Vec<Mat<T, D>>,
    /// Deformation gradients, from the fiber frame to the world.
    pub F: Vec<Mat<T, D>>,
    /// Masses, kg.
    pub mass: Vec<T>,
    /// Rest volumes, m³ (m² in 2D).
    pub volume: Vec<T>,
    /// Damage d ∈ [0, 1].
    pub damage: Vec<T>,
    /// History D̃^H of the crack driving force.
    pub history: Vec<T>,
    /// Which of the simulation's bodies it belongs to.
    pub body: Vec<u16>,
    /// A name that sorting does not change.
    pub id: Vec<u32>,
}

/// One new particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle<const D: usize> {
    /// Position, m.
    pub x: [f64; D],
    /// Velocity, m/s.
    pub v: [f64; D],
    /// Deformation gradient: the rotation of the fiber frame for a particle at rest.
    pub F: Mat<f64, D>,
    /// Mass, kg.
    pub mass: f64,
    /// Rest volume, m³ (m² in 2D).
    pub volume: f64,
    /// Damage d ∈ [0, 1].
    pub damage: f64,
    /// Which of the simulation's bodies it belongs to.
    pub body: u16,
}

impl<T: Float, const D: usize> Particles<T, D> {
    /// No particles.
    pub fn new() -> Self {
        Self {
            x: Vec::new(),
            v: Vec::new(),
            C: Vec::new(),
            F: Vec::new(),
            mass: Vec::new(),
            volume: Vec::new(),
            damage: Vec::new(),
            history: Vec::new(),
            body: Vec::new(),
            id: Vec::new(),
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.x.len()
    }
    /// No particle at all?
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Adds a particle; its id is the number of particles before it.
    ///
    /// # Errors
    /// Mass or volume not positive, damage outside [0, 1], or a number that is not finite.
    pub fn push(&mut self, p: &Particle<D>) -> Result<(), MpmError> {
        positive("particle mass", p.mass)?;
        positive("particle volume", p.volume)?;
        if !(0.0..=1.0).contains(&p.damage) {
            return Err(MpmError::Parameter {
                what: "particle damage",
                value: p.damage,
                need: "between 0 and 1",
            });
        }
        if !(all_finite(&p.x) && all_finite(&p.v) && p.F.0.iter().all(all_finite)) {
            return Err(MpmError::Parameter {
                what: "position, velocity or F of a particle",
                value: f64::NAN,
                need: "finite",
            });
        }
        self.id.push(self.len() as u32);
        self.x.push(p.x.map(T::from_f64));
        self.v.push(p.v.map(T::from_f64));
        self.C.push(Mat::zeros());
        self.F.push(Mat::from_fn(|i, j| T::from_f64(p.F.0[i][j])));
        self.mass.push(T::from_f64(p.mass));
        self.volume.push(T::from_f64(p.volume));
        self.damage.push(T::from_f64(p.damage));
        self.history.push(T::zero());
        self.body.push(p.body);
        Ok(())
    }

    /// # Errors
    /// An array whose length is not that of `x`, or the first number that makes no sense, with its
    /// particle: mass and volume finite and positive, damage in [0, 1], history finite and not
    /// negative, body below `bodies`, all else finite.
    pub(crate) fn check(&self, bodies: usize) -> Result<(), MpmError> {
        let n = self.len();
        same_length("v", self.v.len(), n)?;
        same_length("C", self.C.len(), n)?;
        same_length("F", self.F.len(), n)?;
        same_length("mass", self.mass.len(), n)?;
        same_length("volume", self.volume.len(), n)?;
        same_length("damage", self.damage.len(), n)?;
        same_length("history", self.history.len(), n)?;
        same_length("body", self.body.len(), n)?;
        same_length("id", self.id.len(), n)?;
        for p in 0..n {
            self.check_one(p, bodies)?;
        }
        Ok(())
    }

    fn check_one(&self, particle: usize, bodies: usize) -> Result<(), MpmError> {
        let require = |field, value: f64, good: bool, need| {
            if good {
                Ok(())
            } else {
                Err(MpmError::Particle {
                    particle,
                    field,
                    value,
                    need,
                })
            }
        };
        let finite = |field, values: &[T]| {
            values.iter().try_for_each(|v| {
                let value = v.to_f64();
                require(field, value, value.is_finite(), "finite")
            })
        };
        finite("x", &self.x[particle])?;
        finite("v", &self.v[particle])?;
        finite("C", self.C[particle].0.as_flattened())?;
        finite("F", self.F[particle].0.as_flattened())?;
        for (field, value) in [
            ("mass", self.mass[particle]),
            ("volume", self.volume[particle]),
        ] {
            let value = value.to_f64();
            let good = value > 0.0 && value.is_finite();
            require(field, value, good, "finite and positive")?;
        }
        let d = self.damage[particle].to_f64();
        require("damage", d, (0.0..=1.0).contains(&d), "between 0 and 1")?;
        let history = self.history[particle].to_f64();
        let good = history >= 0.0 && history.is_finite();
        require("history", history, good, "finite and not negative")?;
        let body = self.body[particle];
        let known = usize::from(body) < bodies;
        require("body", f64::from(body), known, "below the number of bodies")
    }

    pub(crate) fn resize_like(&mut self, other: &Self) {
        let n = other.len();
        self.x.resize(n, [T::zero(); D]);
        self.v.resize(n, [T::zero(); D]);
        self.C.resize(n, Mat::zeros());
        self.F.resize(n, Mat::zeros());
        self.mass.resize(n, T::zero());
        self.volume.resize(n, T::zero());
        self.damage.resize(n, T::zero());
        self.history.resize(n, T::zero());
        self.body.resize(n, 0);
        self.id.resize(n, 0);
    }
}
