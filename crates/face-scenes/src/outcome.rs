//! How a fit ended, as data.

use super::alignment::Suspicion;
use face_rig::anatomy::{JOINT_NAMES, JawJoint};
use face_rig::fit::JawModel;
use face_rig::rig::{AffineMap, RigError};
use fem_solvers::{GaussNewtonFailure, GaussNewtonStop};
use serde::ser::{Serialize, Serializer};

/// The end of a fit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Outcome {
    /// A stop rule was met.
    Converged(Option<GaussNewtonStop>),
    /// It was not; the best pose was kept.
    NotConverged(Unfinished),
    /// It was met at a pose that no face can take: flesh inside out, or a jaw out of its joint.
    Impossible(Vec<ImpossiblePose>),
    /// It was met so far from the target that this face cannot have been meant.
    Missed {
        /// Root-mean-square distance that is left, meters.
        rms: f64,
        /// That of the face's landmarks from their middle, meters.
        spread: f64,
        /// What may be wrong with the target.
        suspicion: Suspicion,
    },
}

/// Why a fit met no stop rule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfinished {
    /// All steps were taken.
    #[error("{0} steps were not enough")]
    Steps(usize),
    /// The pose has another shape by now than the one that was fitted; it is the one told of.
    #[error(
        "the pose has another shape by now, {found_mm:.3} mm from the target where {told_mm:.3} mm were fitted"
    )]
    AnotherShape {
        /// The distance of the shape that was fitted, millimeters.
        told_mm: f64,
        /// That of the present one.
        found_mm: f64,
    },
    /// The solver gave up.
    #[error("{0}")]
    Failed(Box<GaussNewtonFailure<RigError>>),
}

/// What is wrong with a pose that no face can take.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImpossiblePose {
    /// Elements are turned inside out.
    #[error("{inverted} tets are inside out (worst: tet {worst}, det F {ratio:.2})")]
    InsideOut {
        /// How many.
        inverted: usize,
        /// The one turned most.
        worst: usize,
        /// Its det F.
        ratio: f64,
    },
    /// A number of the jaw's joint is beyond its limits.
    #[error("the jaw's {name} is beyond its limits")]
    BeyondLimits {
        /// One of [`JOINT_NAMES`].
        name: &'static str,
    },
    /// The jaw left its joint.
    #[error("the jaw is {:.1} mm beside the path of its joint", 1e3 * distance)]
    Beside {
        /// Meters.
        distance: f64,
    },
}

impl Outcome {
    /// Why it ended so, for people.
    pub fn why(&self) -> String {
        match self {
            Self::Converged(None) => String::new(),
            Self::Converged(Some(stop)) => format!("{stop:?}").to_lowercase(),
            Self::NotConverged(why) => why.to_string(),
            Self::Impossible(wrong) => {
                let wrong: Vec<String> = wrong.iter().map(ImpossiblePose::to_string).collect();
                wrong.join("; ")
            }
            Self::Missed {
                rms,
                spread,
                suspicion,
            } => format!(
                "{:.1} mm from a target of landmarks that spread over {:.1} mm: {suspicion}",
                1e3 * rms,
                1e3 * spread
            ),
        }
    }
}

impl Serialize for Outcome {
    /// The end with its reason, like `{ "converged": "step" }`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (index, variant) = match self {
            Self::Converged(_) => (0, "converged"),
            Self::NotConverged(_) => (1, "not_converged"),
            Self::Impossible(_) => (2, "impossible"),
            Self::Missed { .. } => (3, "missed"),
        };
        serializer.serialize_newtype_variant("Outcome", index, variant, &self.why())
    }
}

/// The share of a range that counts as its end.
pub(super) const LIMIT_SHARE: f64 = 1e-6;

/// The numbers of a joint that lie past their limits by more than a share of the range.
pub(super) fn past_limits(joint: &JawJoint, jaw: &AffineMap, share: f64) -> Vec<&'static str> {
    let (numbers, _) = joint.closest(jaw);
    let all = JOINT_NAMES.into_iter().zip(numbers);
    let all = all.zip(joint.limits().to_array());
    let past = all.filter(|((_, number), [lower, upper])| {
        let slack = share * (upper - lower);
        !(lower - slack <= *number && *number <= upper + slack)
    });
    past.map(|((name, _), _)| name).collect()
}

/// A pose that no face can take ends no fit well. A jaw that only turns is held to how far it may
/// open: that its condyles stay back while they should glide is what was asked for.
pub(super) fn possible(
    outcome: Outcome,
    ratios: &[f64],
    joint: &JawJoint,
    model: &JawModel,
    jaw: &AffineMap,
) -> Outcome {
    let Outcome::Converged(stop) = outcome else {
        return outcome;
    };
    let mut wrong = Vec::new();
    let inverted = ratios.iter().filter(|ratio| !(**ratio > 0.0)).count();
    let worst = ratios.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    if let (1.., Some((worst, &ratio))) = (inverted, worst) {
        wrong.push(ImpossiblePose::InsideOut {
            inverted,
            worst,
            ratio,
        });
    }
    let turns = matches!(model, JawModel::Hinge(_));
    let past = past_limits(joint, jaw, LIMIT_SHARE).into_iter();
    let past = past.filter(|name| !turns || *name == JOINT_NAMES[0]);
    wrong.extend(past.map(|name| ImpossiblePose::BeyondLimits { name }));
    let distance = joint.closest(jaw).1;
    if !turns && !(distance <= JawJoint::PLAY) {
        wrong.push(ImpossiblePose::Beside { distance });
    }
    if wrong.is_empty() {
        Outcome::Converged(stop)
    } else {
        Outcome::Impossible(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    fn end(ratios: &[f64], jaw: &AffineMap) -> Outcome {
        let joint = Scene::builtin(5_000).expect("a face").joint;
        let stop = Outcome::Converged(Some(GaussNewtonStop::Step));
        possible(stop, ratios, &joint, &JawModel::Joint(joint), jaw)
    }

    fn impossible(ratios: &[f64], jaw: &AffineMap, words: &str) {
        match end(ratios, jaw) {
            end @ Outcome::Impossible(_) => assert!(end.why().contains(words), "{}", end.why()),
            other => panic!("{other:?} for {words}"),
        }
    }

    #[test]
    fn a_pose_that_no_face_can_take_is_no_good_end() {
        let joint = Scene::builtin(5_000).expect("a face").joint;
        let at = |numbers| joint.motion(numbers).0;
        let fine = [1.0, 0.2];
        for numbers in [
            [0.0; 4],
            [0.69, 0.01, -0.005, 0.08],
            [-0.03, -0.002, 0.0, 0.0],
        ] {
            let stop = Outcome::Converged(Some(GaussNewtonStop::Step));
            assert_eq!(end(&fine, &at(numbers)), stop, "{numbers:?}");
        }
        let inside_out = "2 tets are inside out (worst: tet 2, det F -0.50)";
        impossible(&[1.0, -0.1, -0.5], &AffineMap::IDENTITY, inside_out);
        impossible(&[f64::NAN], &AffineMap::IDENTITY, "1 tets are inside out");
        impossible(&fine, &at([0.8, 0.0, 0.0, 0.0]), "jaw's opening is beyond");
        impossible(
            &fine,
            &at([0.1, 0.0, 0.006, 0.0]),
            "jaw's lateral shift is beyond",
        );
        let mut up = at([0.0; 4]);
        up.translation[1] += 0.02;
        impossible(&fine, &up, "beside the path of its joint");
        // What failed before stays what it was.
        let failed = Outcome::NotConverged(Unfinished::Steps(7));
        let model = JawModel::Joint(joint);
        let kept = possible(failed.clone(), &[-1.0], &joint, &model, &up);
        assert_eq!(kept, failed);
    }

    #[test]
    fn a_jaw_that_only_turns_is_held_to_its_opening_alone() {
        let joint = Scene::builtin(5_000).expect("a face").joint;
        let turned = |radians| joint.hinge().motion(radians, [0.0; 3]);
        let model = JawModel::Hinge(*joint.hinge());
        let end = |jaw: &AffineMap| {
            let stop = Outcome::Converged(Some(GaussNewtonStop::Step));
            possible(stop, &[1.0], &joint, &model, jaw)
        };
        // Far from where the path of the condyles would have it, which a hinge does not know.
        assert_eq!(
            past_limits(&joint, &turned(0.5), LIMIT_SHARE),
            ["protrusion"]
        );
        assert_eq!(
            end(&turned(0.5)),
            Outcome::Converged(Some(GaussNewtonStop::Step))
        );
        let opening = ImpossiblePose::BeyondLimits { name: "opening" };
        assert_eq!(end(&turned(0.9)), Outcome::Impossible(vec![opening]));
    }
}
