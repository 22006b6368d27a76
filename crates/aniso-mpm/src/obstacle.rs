//! Walls and moving obstacles: conditions on the velocities of the nodes inside them.

use crate::error::{MpmError, positive};

/// A solid in D dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<const D: usize> {
    /// All points closer than `radius` (m) to `center` (m).
    Sphere {
        /// Center, m.
        center: [f64; D],
        /// Radius, m.
        radius: f64,
    },
    /// All points x with `normal · (x − point) < 0`; the unit normal points out of the solid.
    HalfSpace {
        /// A point of the surface, m.
        point: [f64; D],
        /// Outward unit normal.
        normal: [f64; D],
    },
    /// An axis-aligned box.
    Box {
        /// Lowest corner, m.
        min: [f64; D],
        /// Highest corner, m.
        max: [f64; D],
    },
}

/// What a node inside an obstacle may do relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    pub shape: Shape<D>,
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
    pub fn fixed(shape: Shape<D>, contact: Contact) -> Self {
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
                walls.push(Self::fixed(Shape::HalfSpace { point, normal }, contact));
            }
        }
        walls
    }

    /// # Errors
    /// A place or velocity that is not finite (it would hold nothing, silently), or a radius,
    /// normal, box or friction that makes no sense.
    pub(crate) fn check(&self) -> Result<(), MpmError> {
        finite("velocity of an obstacle", self.velocity)?;
        match self.shape {
            Shape::Sphere { center, radius } => {
                finite("center of an obstacle", center)?;
                positive("obstacle radius", radius)?;
            }
            Shape::HalfSpace { point, normal } => {
                finite("point of an obstacle", point)?;
                let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
                if !((length - 1.0).abs() < 1e-6) {
                    return Err(MpmError::Parameter {
                        what: "length of an obstacle's normal",
                        value: length,
                        need: "1",
                    });
                }
            }
            Shape::Box { min, max } => {
                finite("lowest corner of an obstacle box", min)?;
                finite("highest corner of an obstacle box", max)?;
                for a in 0..D {
                    positive("side of an obstacle box", max[a] - min[a])?;
                }
            }
        }
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
    pub fn touch(&self, x: [f64; D], time: f64) -> Option<ContactConstraint<D>> {
        let x: [f64; D] = core::array::from_fn(|a| x[a] - self.velocity[a] * time);
        let normal = match self.shape {
            Shape::Sphere { center, radius } => {
                let r: [f64; D] = core::array::from_fn(|a| x[a] - center[a]);
                let distance = r.iter().map(|v| v * v).sum::<f64>().sqrt();
                if !(distance < radius) {
                    return None;
                }
                let mut up = [0.0; D];
                up[D - 1] = 1.0;
                if distance > 0.0 {
                    r.map(|v| v / distance)
                } else {
                    up
                }
            }
            Shape::HalfSpace { point, normal } => {
                let height: f64 = (0..D).map(|a| normal[a] * (x[a] - point[a])).sum();
                if !(height < 0.0) {
                    return None;
                }
                normal
            }
            Shape::Box { min, max } => {
                if !(0..D).all(|a| x[a] > min[a] && x[a] < max[a]) {
                    return None;
                }
                let mut nearest = (f64::INFINITY, 0, 0.0);
                for a in 0..D {
                    for (depth, sign) in [(x[a] - min[a], -1.0), (max[a] - x[a], 1.0)] {
                        if depth < nearest.0 {
                            nearest = (depth, a, sign);
                        }
                    }
                }
                let mut normal = [0.0; D];
                normal[nearest.1] = nearest.2;
                normal
            }
        };
        Some(ContactConstraint {
            normal,
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
    /// Unit directions in which a node with the (admissible) velocity `v` is held.
    pub(crate) fn held(&self, v: &[f64; D]) -> Vec<[f64; D]> {
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
