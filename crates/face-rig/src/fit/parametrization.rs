//! Which numbers a fit may change, and how θ follows from them.

use super::rotation::rotation_with_derivative;
use crate::anatomy::{JOINT_NUMBERS, JawHinge, JawJoint};
use crate::rig::{AffineMap, Direction, Parameters, RigError};

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

/// What a fit does with a control of the rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlModel {
    /// Its value where a fit starts, toward which it is weighed, and where it stays if it may not vary;
    /// in its own unit.
    pub neutral: f64,
    /// The least and greatest value, if it may vary.
    pub bounds: Option<[f64; 2]>,
}

impl ControlModel {
    /// What q counts in: the value of the greatest magnitude among the bounds, so that q is about 1 as
    /// an activation is, and one weight suits both.
    fn unit(bounds: [f64; 2]) -> f64 {
        bounds[0].abs().max(bounds[1].abs())
    }
}

/// The numbers q of a fit: activations of some muscles, then the head, then the jaw, then the controls
/// that vary.
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
    /// One for each control of the rig.
    pub controls: Vec<ControlModel>,
}

impl Parametrization {
    /// The same with controls.
    #[must_use]
    pub fn with_controls(self, controls: Vec<ControlModel>) -> Self {
        Self { controls, ..self }
    }

    /// (control, bounds, unit of q) of those that vary.
    pub(super) fn varying(&self) -> impl Iterator<Item = (usize, [f64; 2], f64)> + '_ {
        let bounds = self.controls.iter().enumerate();
        let bounds = bounds.filter_map(|(k, c)| c.bounds.map(|b| (k, b)));
        bounds.map(|(k, b)| (k, b, ControlModel::unit(b)))
    }

    /// How many controls vary.
    pub fn control_numbers(&self) -> usize {
        self.varying().count()
    }

    /// θ itself: all activations and both affine maps, 24 numbers more than muscles.
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
            controls: Vec::new(),
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
        self.active.len() + self.cranium_numbers() + self.jaw_numbers() + self.control_numbers()
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
        let neutral = |(k, _, unit): (usize, [f64; 2], f64)| self.controls[k].neutral / unit;
        q.extend(self.varying().map(neutral));
        q
    }

    /// θ(q).
    ///
    /// # Errors
    /// When q has another length than [`Parametrization::len`].
    pub fn parameters(&self, q: &[f64]) -> Result<Parameters, RigError> {
        self.check(q)?;
        Ok(self.trusted_parameters(q))
    }

    fn check(&self, q: &[f64]) -> Result<(), RigError> {
        if q.len() == self.len() {
            return Ok(());
        }
        Err(RigError::WrongLength {
            what: "numbers of a parametrization",
            found: q.len(),
            expected: self.len(),
        })
    }

    pub(super) fn trusted_parameters(&self, q: &[f64]) -> Parameters {
        let (activations, cranium, jaw) = self.split(q);
        let mut parameters = Parameters::rest(self.muscles);
        for (&muscle, &value) in self.active.iter().zip(activations) {
            parameters.activations[muscle] = value;
        }
        parameters.cranium = self.cranium_map(cranium).0;
        parameters.jaw = self.jaw_map(jaw).0;
        parameters.controls = self.controls.iter().map(|c| c.neutral).collect();
        for ((k, _, unit), value) in self.varying().zip(&q[q.len() - self.control_numbers()..]) {
            parameters.controls[k] = unit * value;
        }
        parameters
    }

    /// dθ for each number of q, up to its scale ([`Parametrization::scales`]).
    ///
    /// # Errors
    /// As [`Parametrization::parameters`].
    pub fn directions(&self, q: &[f64]) -> Result<Vec<Direction>, RigError> {
        self.check(q)?;
        Ok(self.trusted_directions(q))
    }

    pub(super) fn trusted_directions(&self, q: &[f64]) -> Vec<Direction> {
        let (_, cranium, jaw) = self.split(q);
        let activations = self.active.iter().map(|&m| Direction::Activation(m));
        let cranium = self
            .cranium_map(cranium)
            .1
            .into_iter()
            .map(Direction::Cranium);
        let jaw = self.jaw_map(jaw).1.into_iter().map(Direction::Jaw);
        let controls = self.varying().map(|(k, _, _)| Direction::Control(k));
        activations
            .chain(cranium)
            .chain(jaw)
            .chain(controls)
            .collect()
    }

    /// What each column of [`Parametrization::directions`] is multiplied by: the unit of a control, 1
    /// for all else.
    pub fn scales(&self) -> Vec<f64> {
        let mut scales = vec![1.0; self.len() - self.control_numbers()];
        scales.extend(self.varying().map(|(_, _, unit)| unit));
        scales
    }

    /// Where the jaw's numbers begin in q.
    pub fn jaw_start(&self) -> usize {
        self.active.len() + self.cranium_numbers()
    }

    fn split<'q>(&self, q: &'q [f64]) -> (&'q [f64], &'q [f64], &'q [f64]) {
        let (activations, rest) = q.split_at(self.active.len());
        let (cranium, rest) = rest.split_at(self.cranium_numbers());
        (activations, cranium, &rest[..self.jaw_numbers()])
    }

    fn cranium_map(&self, numbers: &[f64]) -> (AffineMap, Vec<AffineMap>) {
        match self.cranium {
            CraniumModel::Fixed => (AffineMap::IDENTITY, vec![]),
            CraniumModel::Rigid => rigid([0.0; 3], vector(numbers), vector(&numbers[3..])),
            CraniumModel::Affine => affine(numbers),
        }
    }

    fn jaw_map(&self, numbers: &[f64]) -> (AffineMap, Vec<AffineMap>) {
        match self.jaw {
            JawModel::Fixed => (AffineMap::IDENTITY, vec![]),
            JawModel::Joint(joint) => {
                let (map, by) = joint.motion(std::array::from_fn(|k| numbers[k]));
                (map, by.to_vec())
            }
            JawModel::Hinge(hinge) => {
                let map = hinge.motion(numbers[0], [0.0; 3]);
                (map, vec![hinge.motion_by_angle(numbers[0])])
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
    let map = AffineMap::from_array(std::array::from_fn(|k| numbers[k]));
    (map, (0..12).map(AffineMap::unit).collect())
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
                    controls: vec![
                        ControlModel {
                            neutral: 2.0,
                            bounds: None,
                        },
                        ControlModel {
                            neutral: 500.0,
                            bounds: Some([-1000.0, 3000.0]),
                        },
                    ],
                };
                let scales = map.scales();
                assert_eq!(map.parameters(&map.rest()).unwrap().controls, [2.0, 500.0]);
                let q: Vec<f64> = (0..map.len())
                    .map(|k| map.rest()[k] + 0.3 * (k as f64).cos())
                    .collect();
                for (k, direction) in map.directions(&q).unwrap().into_iter().enumerate() {
                    let h = 1e-6;
                    let at = |t: f64| {
                        let mut q = q.clone();
                        q[k] += t;
                        map.parameters(&q).unwrap().to_vec()
                    };
                    let mut exact = vec![0.0; 3];
                    let (mut c, mut j) = (AffineMap::ZERO, AffineMap::ZERO);
                    let mut controls = [0.0; 2];
                    match direction {
                        Direction::Activation(m) => exact[m] = 1.0,
                        Direction::Cranium(d) => c = d,
                        Direction::Jaw(d) => j = d,
                        Direction::Control(k) => controls[k] = 1.0,
                    }
                    exact.extend(c.to_array());
                    exact.extend(j.to_array());
                    exact.extend(controls);
                    for ((high, low), exact) in at(h).iter().zip(at(-h)).zip(exact) {
                        let exact = scales[k] * exact;
                        assert!(((high - low) / (2.0 * h) - exact).abs() < 1e-9 * scales[k]);
                    }
                }
            }
        }
    }
}
