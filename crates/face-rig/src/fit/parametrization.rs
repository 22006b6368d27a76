//! Which numbers a fit may change, and how θ follows from them.

use super::rotation::rotation_with_derivative;
use crate::anatomy::{JOINT_NUMBERS, JawHinge, JawJoint};
use crate::rig::{AffineMap, Direction, Parameters};

/// How the head may move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum CraniumModel {
    /// Not at all.
    #[default]
    Fixed,
    /// A turn (rotation vector, radians) and a shift (meters): six numbers.
    Rigid,
    /// The document's twelve numbers.
    Affine,
}

/// How the jaw may move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum JawModel {
    /// Not at all.
    #[default]
    Fixed,
    /// The joint: opening (radians), protrusion and lateral shift (meters), yaw (radians). Each stays
    /// within the joint's limits.
    Joint(JawJoint),
    /// A turn about the hinge (radians, positive opens): one number.
    Hinge(JawHinge),
    /// A turn about a point (rotation vector, radians) and a shift (meters): six numbers.
    Rigid {
        /// The point, meters.
        point: [f64; 3],
    },
    /// The document's twelve numbers.
    Affine,
}

/// The numbers q of a fit: activations of some muscles, then the head, then the jaw.
#[derive(Clone, Debug, PartialEq)]
pub struct Parametrization {
    /// Muscles of the rig.
    pub muscles: usize,
    /// The muscles that vary; the others stay relaxed.
    pub active: Vec<usize>,
    /// How the head may move.
    pub cranium: CraniumModel,
    /// How the jaw may move.
    pub jaw: JawModel,
}

impl Parametrization {
    /// θ itself: all activations and both affine frames, 24 numbers more than muscles.
    pub fn affine(muscles: usize) -> Self {
        Self::of_all(muscles, CraniumModel::Affine, JawModel::Affine)
    }

    /// All activations, with a head and a jaw that move as said.
    pub fn of_all(muscles: usize, cranium: CraniumModel, jaw: JawModel) -> Self {
        Self {
            muscles,
            active: (0..muscles).collect(),
            cranium,
            jaw,
        }
    }

    /// Numbers that describe the head.
    pub fn cranium_numbers(&self) -> usize {
        match self.cranium {
            CraniumModel::Fixed => 0,
            CraniumModel::Rigid => 6,
            CraniumModel::Affine => 12,
        }
    }

    /// Numbers that describe the jaw.
    pub fn jaw_numbers(&self) -> usize {
        match self.jaw {
            JawModel::Fixed => 0,
            JawModel::Joint(_) => JOINT_NUMBERS,
            JawModel::Hinge(_) => 1,
            JawModel::Rigid { .. } => 6,
            JawModel::Affine => 12,
        }
    }

    /// Length of q.
    pub fn len(&self) -> usize {
        self.active.len() + self.cranium_numbers() + self.jaw_numbers()
    }

    /// Is there nothing to fit?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// q of the relaxed rest pose.
    pub fn rest(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.active.len()];
        let unit = AffineMap::IDENTITY.to_array();
        let pad = |n: usize| if n == 12 { unit.to_vec() } else { vec![0.0; n] };
        q.extend(pad(self.cranium_numbers()));
        q.extend(pad(self.jaw_numbers()));
        q
    }

    /// θ(q).
    pub fn parameters(&self, q: &[f64]) -> Parameters {
        let (activations, cranium, jaw) = self.split(q);
        let mut parameters = Parameters::rest(self.muscles);
        for (&muscle, &value) in self.active.iter().zip(activations) {
            parameters.activations[muscle] = value;
        }
        parameters.cranium = self.cranium_frame(cranium).0;
        parameters.jaw = self.jaw_frame(jaw).0;
        parameters
    }

    /// dθ for each number of q.
    pub fn directions(&self, q: &[f64]) -> Vec<Direction> {
        let (_, cranium, jaw) = self.split(q);
        let activations = self.active.iter().map(|&m| Direction::Activation(m));
        let cranium = self
            .cranium_frame(cranium)
            .1
            .into_iter()
            .map(Direction::Cranium);
        let jaw = self.jaw_frame(jaw).1.into_iter().map(Direction::Jaw);
        activations.chain(cranium).chain(jaw).collect()
    }

    /// Where the jaw's numbers begin in q.
    pub fn jaw_start(&self) -> usize {
        self.active.len() + self.cranium_numbers()
    }

    fn split<'q>(&self, q: &'q [f64]) -> (&'q [f64], &'q [f64], &'q [f64]) {
        let (activations, rest) = q.split_at(self.active.len());
        let (cranium, jaw) = rest.split_at(self.cranium_numbers());
        (activations, cranium, jaw)
    }

    fn cranium_frame(&self, numbers: &[f64]) -> (AffineMap, Vec<AffineMap>) {
        match self.cranium {
            CraniumModel::Fixed => (AffineMap::IDENTITY, vec![]),
            CraniumModel::Rigid => rigid([0.0; 3], vector(numbers), vector(&numbers[3..])),
            CraniumModel::Affine => affine(numbers),
        }
    }

    fn jaw_frame(&self, numbers: &[f64]) -> (AffineMap, Vec<AffineMap>) {
        match self.jaw {
            JawModel::Fixed => (AffineMap::IDENTITY, vec![]),
            JawModel::Joint(joint) => {
                let (frame, by) = joint.motion(std::array::from_fn(|k| numbers[k]));
                (frame, by.to_vec())
            }
            JawModel::Hinge(hinge) => {
                let frame = hinge.motion(numbers[0], [0.0; 3]);
                (frame, vec![hinge.motion_by_angle(numbers[0])])
            }
            JawModel::Rigid { point } => rigid(point, vector(numbers), vector(&numbers[3..])),
            JawModel::Affine => affine(numbers),
        }
    }
}

fn vector(numbers: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| numbers[i])
}

fn affine(numbers: &[f64]) -> (AffineMap, Vec<AffineMap>) {
    let frame = AffineMap::from_array(std::array::from_fn(|k| numbers[k]));
    (frame, (0..12).map(AffineMap::unit).collect())
}

/// X ↦ R(w)(X − p) + p + shift, and its derivatives by w and shift.
fn rigid(p: [f64; 3], w: [f64; 3], shift: [f64; 3]) -> (AffineMap, Vec<AffineMap>) {
    let (matrix, derivative) = rotation_with_derivative(w);
    let turned = |m: &[[f64; 3]; 3]| m.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
    let moved = turned(&matrix);
    let translation = std::array::from_fn(|i| p[i] - moved[i] + shift[i]);
    let by_turn = derivative.map(|d| AffineMap {
        matrix: d,
        translation: turned(&d).map(|v| -v),
    });
    let by_shift = (9..12).map(AffineMap::unit);
    (
        AffineMap {
            matrix,
            translation,
        },
        by_turn.into_iter().chain(by_shift).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::{CondylarPath, JointLimits};

    #[test]
    fn directions_agree_with_differences_of_theta() {
        let hinge = JawHinge::new([0.0, -0.01, 0.02], [0.8, 0.0, -0.6]).expect("a hinge");
        let (path, limits) = (CondylarPath::ADULT, JointLimits::ADULT);
        let joint = JawJoint::new(hinge, path, limits).expect("a joint");
        let (joint, hinge) = (JawModel::Joint(joint), JawModel::Hinge(hinge));
        let rigid = JawModel::Rigid {
            point: [0.1, 0.2, 0.3],
        };
        for cranium in [
            CraniumModel::Fixed,
            CraniumModel::Rigid,
            CraniumModel::Affine,
        ] {
            for jaw in [JawModel::Fixed, joint, hinge, rigid, JawModel::Affine] {
                let map = Parametrization {
                    muscles: 3,
                    active: vec![2, 0],
                    cranium,
                    jaw,
                };
                let q: Vec<f64> = (0..map.len())
                    .map(|k| map.rest()[k] + 0.3 * (k as f64).cos())
                    .collect();
                for (k, direction) in map.directions(&q).into_iter().enumerate() {
                    let h = 1e-6;
                    let at = |t: f64| {
                        let mut q = q.clone();
                        q[k] += t;
                        map.parameters(&q).to_vec()
                    };
                    let mut exact = vec![0.0; 3];
                    let (mut c, mut j) = (AffineMap::ZERO, AffineMap::ZERO);
                    match direction {
                        Direction::Activation(m) => exact[m] = 1.0,
                        Direction::Cranium(d) => c = d,
                        Direction::Jaw(d) => j = d,
                    }
                    exact.extend(c.to_array());
                    exact.extend(j.to_array());
                    for ((high, low), exact) in at(h).iter().zip(at(-h)).zip(exact) {
                        assert!(((high - low) / (2.0 * h) - exact).abs() < 1e-9);
                    }
                }
            }
        }
    }
}
