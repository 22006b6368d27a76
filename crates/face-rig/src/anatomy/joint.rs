//! The jaw's joint: a hinge whose condyles glide.

use super::{AffineMap, JawHinge};
use fem_kinematics::Mat;

/// The numbers of a joint: opening (radians), protrusion and lateral shift (meters), yaw (radians).
pub const JOINT_NUMBERS: usize = 4;

/// Their names, in this order.
pub const JOINT_NAMES: [&str; JOINT_NUMBERS] = ["opening", "protrusion", "lateral shift", "yaw"];

/// The way that the condyles glide while the jaw opens, and along which a protruded jaw moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CondylarPath {
    /// How far the condyles have come when the jaw is open, meters; 0 for a pure rotation.
    pub length: f64,
    /// How much the way descends from straight forward, radians.
    pub inclination: f64,
    /// The opening at which it ends, radians, above 0 where the length is not 0.
    pub full_at: f64,
}

impl CondylarPath {
    /// Of an adult joint: 12 mm down and forward, 33° below the horizontal, over 35° of opening
    /// (`docs/sources.md`, "jaw joint").
    pub const ADULT: Self = Self {
        length: 0.012,
        inclination: 33.0 * DEGREE,
        full_at: 35.0 * DEGREE,
    };

    /// g(φ) = L s(φ/φ_end) and g′(φ), meters and meters per radian: s(u) = u³ (10 − 15 u + 6 u²)
    /// between 0 and 1, constant outside, with continuous curvature.
    fn glide(&self, angle: f64) -> (f64, f64) {
        if self.length == 0.0 {
            return (0.0, 0.0);
        }
        let u = (angle / self.full_at).clamp(0.0, 1.0);
        let rise = u * u * u * (10.0 + u * (6.0 * u - 15.0));
        let slope = 30.0 * u * u * (1.0 - u) * (1.0 - u);
        (self.length * rise, self.length * slope / self.full_at)
    }
}

/// How far each number of a joint may go: `[lower, upper]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Radians; positive opens.
    pub opening: [f64; 2],
    /// Meters along the path, beyond what the opening brings with it.
    pub protrusion: [f64; 2],
    /// Meters along the axis.
    pub lateral: [f64; 2],
    /// Radians; positive turns the chin to the side that the axis points to.
    pub yaw: [f64; 2],
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

impl JointLimits {
    /// Of an adult joint (`docs/sources.md`, "jaw joint").
    pub const ADULT: Self = Self {
        opening: [-2.0 * DEGREE, 40.0 * DEGREE],
        protrusion: [-0.002, 0.010],
        lateral: [-0.005, 0.005],
        yaw: [-5.0 * DEGREE, 5.0 * DEGREE],
    };

    /// In the order of the joint's numbers.
    pub fn to_array(&self) -> [[f64; 2]; JOINT_NUMBERS] {
        [self.opening, self.protrusion, self.lateral, self.yaw]
    }
}

/// Why a joint cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JointError {
    /// The axis has no forward direction across it.
    #[error("the hinge axis {0:?} points up; give one that points to the subject's left")]
    Upright([f64; 3]),
    /// A length, an angle or a condyle makes no sense.
    #[error("{name} is {value}, which is not {wanted}")]
    Number {
        /// What it is.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is wanted.
        wanted: &'static str,
    },
    /// Limits that leave out the rest pose, or are no numbers.
    #[error("the limits of the {name}, {lower} to {upper}, do not hold 0 between them")]
    Limits {
        /// Of which number.
        name: &'static str,
        /// The lower one.
        lower: f64,
        /// The upper one.
        upper: f64,
    },
}

/// The joint of the jaw: x = R_u(ψ) R_a(φ) (X − p) + p + (g(φ) + s) d + l a.
///
/// p and a are the hinge's point and axis, u the direction nearest to up (+y) across the axis,
/// d = cos β (a × u) − sin β u the way of the condyles, g the glide of [`CondylarPath`]. The numbers
/// are the opening φ (radians, positive opens), the protrusion s and the lateral shift l (meters), and
/// the yaw ψ (radians).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JawJoint {
    hinge: JawHinge,
    up: [f64; 3],
    way: [f64; 3],
    path: CondylarPath,
    limits: JointLimits,
    condyles: [[f64; 3]; 2],
}

impl JawJoint {
    /// Half of the distance of the condyles where nothing else is said, meters: Bonwill's triangle
    /// has sides of 10 cm (`docs/sources.md`, "jaw joint").
    pub const HALF_WIDTH: f64 = 0.05;

    /// How far the hinge's point may be beside the path before a jaw that is not bound to its joint
    /// counts as out of it, meters (`docs/sources.md`, "jaw joint").
    pub const PLAY: f64 = 0.002;

    /// A joint about `hinge`, its condyles [`JawJoint::HALF_WIDTH`] to both sides of the hinge's point.
    ///
    /// # Errors
    /// [`JointError`] for an axis that points up, and numbers that make no sense.
    pub fn new(
        hinge: JawHinge,
        path: CondylarPath,
        limits: JointLimits,
    ) -> Result<Self, JointError> {
        check(&path, &limits)?;
        let (p, a) = (hinge.point(), hinge.axis());
        let upward = std::array::from_fn(|i| f64::from(i == 1) - a[1] * a[i]);
        let across = dot(upward, upward);
        let up = JawHinge::new(p, upward).map_err(|_| JointError::Upright(a))?;
        if !(across > 0.01) {
            return Err(JointError::Upright(a));
        }
        let (u, (sin, cos)) = (up.axis(), path.inclination.sin_cos());
        let forward = cross(a, u);
        let beside = |by: f64| std::array::from_fn(|i| p[i] + by * a[i]);
        Ok(Self {
            hinge,
            up: up.axis(),
            way: std::array::from_fn(|i| cos * forward[i] - sin * u[i]),
            path,
            limits,
            condyles: [beside(Self::HALF_WIDTH), beside(-Self::HALF_WIDTH)],
        })
    }

    /// The same joint with its condyles at these places, meters; they serve comparisons only.
    ///
    /// # Errors
    /// [`JointError::Number`] for a coordinate that is not finite.
    pub fn with_condyles(mut self, condyles: [[f64; 3]; 2]) -> Result<Self, JointError> {
        let wrong = condyles.iter().flatten().find(|c| !c.is_finite());
        if let Some(&value) = wrong {
            return Err(number("a condyle's coordinate", value, "finite"));
        }
        self.condyles = condyles;
        Ok(self)
    }

    /// The line that the jaw turns about.
    pub fn hinge(&self) -> &JawHinge {
        &self.hinge
    }
    /// The way of the condyles.
    pub fn path(&self) -> &CondylarPath {
        &self.path
    }
    /// How far each number may go.
    pub fn limits(&self) -> &JointLimits {
        &self.limits
    }
    /// Where the condyles are at rest, meters.
    pub fn condyles(&self) -> [[f64; 3]; 2] {
        self.condyles
    }

    /// R_u(ψ) R_a(φ) or a derivative of it, and a shift.
    fn map(&self, turn: Mat<f64, 3>, center: [f64; 3], shift: [f64; 3]) -> AffineMap {
        let turned = turn.mul_vec(self.hinge.point());
        AffineMap {
            matrix: turn.0,
            translation: std::array::from_fn(|i| center[i] - turned[i] + shift[i]),
        }
    }

    /// M and t of the jaw at these numbers, and their derivatives by each.
    pub fn motion(&self, numbers: [f64; JOINT_NUMBERS]) -> (AffineMap, [AffineMap; JOINT_NUMBERS]) {
        let [opening, protrusion, lateral, yaw] = numbers;
        let (d, a) = (self.way, self.hinge.axis());
        let (glide, slope) = self.path.glide(opening);
        let open = |f: fn(&JawHinge, f64) -> AffineMap| Mat(f(&self.hinge, opening).matrix);
        let upright = self.hinge.with_axis(self.up);
        let turn = |f: fn(&JawHinge, f64) -> AffineMap| Mat(f(&upright, yaw).matrix);
        let (opened, opens) = (open(still), open(JawHinge::motion_by_angle));
        let (turned, turns) = (turn(still), turn(JawHinge::motion_by_angle));
        let shift = std::array::from_fn(|i| (glide + protrusion) * d[i] + lateral * a[i]);
        let moved = |by: [f64; 3]| AffineMap {
            translation: by,
            ..AffineMap::ZERO
        };
        let by_opening = self.map(turned * opens, [0.0; 3], d.map(|v| slope * v));
        let by_yaw = self.map(turns * opened, [0.0; 3], [0.0; 3]);
        (
            self.map(turned * opened, self.hinge.point(), shift),
            [by_opening, moved(d), moved(a), by_yaw],
        )
    }

    /// The numbers whose motion is near `motion`, and what is left of the hinge point's shift across
    /// path and axis, meters. Exact for motions of this joint with less than a right angle of yaw.
    pub fn closest(&self, motion: &AffineMap) -> ([f64; JOINT_NUMBERS], f64) {
        let (p, a) = (self.hinge.point(), self.hinge.axis());
        // R_u(ψ) R_a(φ) a = cos ψ a + sin ψ u × a.
        let carried_axis = motion.rotate(a);
        let yaw = dot(carried_axis, cross(self.up, a)).atan2(dot(carried_axis, a));
        let turn = Mat(still(&self.hinge.with_axis(self.up), yaw).matrix);
        let opening = AffineMap {
            matrix: turn.tr_mul(&Mat(motion.matrix)).0,
            ..*motion
        };
        let opening = self.hinge.closest(&opening).0;
        let carried = motion.apply(p);
        let shift: [f64; 3] = std::array::from_fn(|i| carried[i] - p[i]);
        let (along, lateral) = (dot(shift, self.way), dot(shift, a));
        let beside: [f64; 3] =
            std::array::from_fn(|i| shift[i] - along * self.way[i] - lateral * a[i]);
        let protrusion = along - self.path.glide(opening).0;
        let numbers = [opening, protrusion, lateral, yaw];
        (numbers, dot(beside, beside).sqrt())
    }

    /// The hinge as the motion carries it: the line that the jaw turns about at a pose.
    pub fn hinge_at(&self, motion: &AffineMap) -> JawHinge {
        let carried = JawHinge::new(
            motion.apply(self.hinge.point()),
            motion.rotate(self.hinge.axis()),
        );
        carried.unwrap_or(self.hinge)
    }

    /// The largest distance of a condyle between two motions of the jaw, meters.
    pub fn condyles_apart(&self, one: &AffineMap, other: &AffineMap) -> f64 {
        let apart = |c: &[f64; 3]| {
            let (x, y) = (one.apply(*c), other.apply(*c));
            (0..3).map(|i| (x[i] - y[i]).powi(2)).sum::<f64>().sqrt()
        };
        self.condyles.iter().map(apart).fold(0.0, f64::max)
    }
}

fn still(hinge: &JawHinge, angle: f64) -> AffineMap {
    hinge.motion(angle, [0.0; 3])
}

fn number(name: &'static str, value: f64, wanted: &'static str) -> JointError {
    JointError::Number {
        name,
        value,
        wanted,
    }
}

fn check(path: &CondylarPath, limits: &JointLimits) -> Result<(), JointError> {
    if !(path.length >= 0.0 && path.length.is_finite()) {
        return Err(number("the path's length", path.length, "0 m or more"));
    }
    if !(path.inclination.abs() < std::f64::consts::FRAC_PI_2) {
        let wanted = "between −90° and 90°";
        return Err(number("the path's inclination", path.inclination, wanted));
    }
    if path.length > 0.0 && !(path.full_at > 0.0 && path.full_at.is_finite()) {
        let wanted = "an angle above 0";
        return Err(number(
            "the opening at the path's end",
            path.full_at,
            wanted,
        ));
    }
    for (name, [lower, upper]) in JOINT_NAMES.into_iter().zip(limits.to_array()) {
        if !(lower <= 0.0 && upper >= 0.0 && lower < upper && (upper - lower).is_finite()) {
            return Err(JointError::Limits { name, lower, upper });
        }
    }
    Ok(())
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

#[cfg(test)]
#[path = "joint_tests.rs"]
mod joint_tests;
