//! Walls and moving obstacles: conditions on the velocities of the nodes inside them.

use crate::error::MpmError;
use fem_kinematics::ImplicitSurface;

/// How far the length of a normal may be from 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// What a node inside an obstacle may do relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Contact {
    /// Nothing: it moves with the obstacle.
    Sticky,
    /// Slide along the surface, never leave it.
    Slip,
    /// Leave freely; when pressed in, slide with Coulomb friction.
    Separate {
        /// Coefficient of friction, ≥ 0.
        friction: f64,
    },
}

/// A solid that moves with a constant velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle<const D: usize> {
    /// Where it is at time 0.
    pub shape: ImplicitSurface<D>,
    /// What it does to the nodes inside.
    pub contact: Contact,
    /// Its velocity, m/s.
    pub velocity: [f64; D],
}

/// A plane that a node at a given time may not cross, or a point that it must follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactConstraint<const D: usize> {
    /// Outward unit normal of the surface.
    pub normal: [f64; D],
    /// Velocity of the obstacle, m/s.
    pub velocity: [f64; D],
    /// What is allowed.
    pub contact: Contact,
}

impl<const D: usize> Obstacle<D> {
    /// A fixed obstacle.
    pub fn fixed(shape: ImplicitSurface<D>, contact: Contact) -> Self {
        Self {
            shape,
            contact,
            velocity: [0.0; D],
        }
    }

    /// Six (in 2D four) walls that keep the material in the box from `min` to `max` (m).
    pub fn walls(min: [f64; D], max: [f64; D], contact: Contact) -> Vec<Self> {
        let mut walls = Vec::with_capacity(2 * D);
        for a in 0..D {
            for (point, sign) in [(min, 1.0), (max, -1.0)] {
                let mut normal = [0.0; D];
                normal[a] = sign;
                walls.push(Self::fixed(
                    ImplicitSurface::HalfSpace { point, normal },
                    contact,
                ));
            }
        }
        walls
    }

    /// # Errors
    /// A place or velocity that is not finite (it would hold nothing, silently), or a radius,
    /// normal, box or friction that makes no sense.
    pub(crate) fn check(&self) -> Result<(), MpmError> {
        finite("velocity of an obstacle", self.velocity)?;
        let usable = self.shape.check(UNIT_TOLERANCE);
        usable.map_err(|bad| MpmError::Parameter {
            what: bad.what,
            value: bad.value,
            need: bad.needed,
        })?;
        match self.contact {
            Contact::Separate { friction } if !(friction >= 0.0) => Err(MpmError::Parameter {
                what: "friction",
                value: friction,
                need: "not negative",
            }),
            _ => Ok(()),
        }
    }

    /// The condition on a node at `x` (m) at `time` (s), if it lies inside.
    #[inline]
    pub fn constraint(&self, x: [f64; D], time: f64) -> Option<ContactConstraint<D>> {
        let x: [f64; D] = core::array::from_fn(|a| x[a] - self.velocity[a] * time);
        // NaN touches nothing; the step is refused for it elsewhere.
        if !(self.shape.distance(&x) < 0.0) {
            return None;
        }
        Some(ContactConstraint {
            normal: self.shape.normal(&x),
            velocity: self.velocity,
            contact: self.contact,
        })
    }
}

fn finite<const D: usize>(what: &'static str, values: [f64; D]) -> Result<(), MpmError> {
    match values.into_iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(value) => Err(MpmError::Parameter {
            what,
            value,
            need: "finite",
        }),
    }
}

impl<const D: usize> ContactConstraint<D> {
    /// Unit directions that are prescribed of a node with the (admissible) velocity `v`.
    pub(crate) fn prescribed_directions(&self, v: &[f64; D]) -> Vec<[f64; D]> {
        let relative: f64 = (0..D)
            .map(|a| (v[a] - self.velocity[a]) * self.normal[a])
            .sum();
        match self.contact {
            Contact::Sticky => (0..D)
                .map(|axis| core::array::from_fn(|a| if a == axis { 1.0 } else { 0.0 }))
                .collect(),
            Contact::Slip => vec![self.normal],
            // The obstacle has already stopped what moved into it.
            Contact::Separate { .. } if relative <= 1e-12 => vec![self.normal],
            Contact::Separate { .. } => Vec::new(),
        }
    }

    /// The admissible velocity nearest to `v` (m/s), with friction taken from the normal impulse.
    #[inline]
    pub fn apply(&self, v: [f64; D]) -> [f64; D] {
        let relative: [f64; D] = core::array::from_fn(|a| v[a] - self.velocity[a]);
        let normal_speed: f64 = (0..D).map(|a| relative[a] * self.normal[a]).sum();
        match self.contact {
            Contact::Sticky => self.velocity,
            Contact::Slip => core::array::from_fn(|a| v[a] - normal_speed * self.normal[a]),
            Contact::Separate { .. } if normal_speed >= 0.0 => v,
            Contact::Separate { friction } => {
                let tangent: [f64; D] =
                    core::array::from_fn(|a| relative[a] - normal_speed * self.normal[a]);
                let speed = tangent.iter().map(|t| t * t).sum::<f64>().sqrt();
                // Coulomb: the tangential impulse is at most friction times the normal one.
                let keep = if speed > 0.0 {
                    (1.0 + friction * normal_speed / speed).max(0.0)
                } else {
                    0.0
                };
                core::array::from_fn(|a| self.velocity[a] + keep * tangent[a])
            }
        }
    }
}
