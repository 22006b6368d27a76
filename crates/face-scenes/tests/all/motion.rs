//! Where the landmarks of the built-in face go when muscles pull: millimeters, seen by the face's own
//! left side.

use crate::promise::Rig;
use face_rig::anatomy::EmbeddedPoint;
use face_rig::rig::{Parameters, RigError};
use face_scenes::Scene;
use face_scenes::builtin::{BuiltinFace, Side};

/// Upper and lower points of a slit, and its rest gap there in the material.
const EYE_LINE: [f64; 3] = [26.0, 31.0, 36.5];
const LIP_LINE: [f64; 4] = [0.0, 6.0, 12.0, 18.0];

/// Motions on the left side: [out, up, forward], millimeters.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    pub nose_tip: [f64; 3],
    pub inner_brow: [f64; 3],
    pub outer_brow: [f64; 3],
    pub inner_canthus: [f64; 3],
    pub outer_canthus: [f64; 3],
    pub upper_lip: [f64; 3],
    pub lower_lip: [f64; 3],
    pub mouth_corner: [f64; 3],
    /// On the skin over the buccinator.
    pub cheek: [f64; 3],
    /// On the inside of the cheek over the molars.
    pub cheek_inside: [f64; 3],
    pub chin: [f64; 3],
    /// Upper above lower lid along the eye, smallest and largest.
    pub eye_gap: [f64; 2],
    /// Upper above lower lip along the mouth, smallest and largest.
    pub lip_gap: [f64; 2],
    /// The largest way of a node.
    pub largest: f64,
    pub inverted: usize,
}

pub struct Probe {
    face: BuiltinFace,
    eye: Vec<[EmbeddedPoint; 2]>,
    mouth: Vec<[EmbeddedPoint; 2]>,
    cheek: EmbeddedPoint,
    inside: EmbeddedPoint,
}

impl Probe {
    pub fn new(tets: usize) -> Self {
        let face = BuiltinFace::with_tets(tets).expect("a size that can be made");
        let pair = |b: f64| {
            let face = &face;
            move |&a: &f64| [Side::Upper, Side::Lower].map(|side| face.embed([a, b, 1.0], side))
        };
        let eye = EYE_LINE.iter().map(pair(34.0)).collect();
        let mouth = LIP_LINE.iter().map(pair(-33.0)).collect();
        let cheek = face.embed([60.0, -29.0, 1.0], Side::Upper);
        Self {
            eye,
            mouth,
            cheek,
            inside: face.embed([48.0, -36.0, 0.0], Side::Lower),
            face,
        }
    }

    pub fn face(&self) -> &BuiltinFace {
        &self.face
    }

    pub fn motion(&self, rig: &Rig, positions: &[[f64; 3]]) -> Motion {
        let rest = &self.face.nodes;
        let moved = |p: &EmbeddedPoint| {
            let (x, r) = (p.position(positions), p.position(rest));
            [0, 1, 2].map(|k| 1e3 * (x[k] - r[k]))
        };
        let landmark = |i: usize| moved(&self.face.landmarks[i]);
        let shape = rig.assembly().positions(positions).expect("all nodes");
        let ratios = rig.assembly().volume_ratios(shape).unwrap();
        let ways = positions
            .iter()
            .zip(rest)
            .map(|(x, r)| length([0, 1, 2].map(|k| x[k] - r[k])));
        Motion {
            nose_tip: landmark(30),
            inner_brow: landmark(22),
            outer_brow: landmark(26),
            inner_canthus: landmark(42),
            outer_canthus: landmark(45),
            upper_lip: landmark(51),
            lower_lip: landmark(57),
            mouth_corner: landmark(54),
            cheek: moved(&self.cheek),
            cheek_inside: moved(&self.inside),
            chin: landmark(8),
            eye_gap: gap(&self.eye, positions),
            lip_gap: gap(&self.mouth, positions),
            largest: 1e3 * ways.fold(0.0, f64::max),
            inverted: ratios.iter().filter(|j| !(**j > 0.0)).count(),
        }
    }
}

fn gap(pairs: &[[EmbeddedPoint; 2]], positions: &[[f64; 3]]) -> [f64; 2] {
    let gaps = pairs
        .iter()
        .map(|[upper, lower]| 1e3 * (upper.position(positions)[1] - lower.position(positions)[1]));
    gaps.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], g| {
        [low.min(g), high.max(g)]
    })
}

pub fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The pose with these muscles (names without a side) at a value, on both sides or one.
pub fn parameters(scene: &Scene, muscles: &[&str], sides: &[&str], value: f64) -> Parameters {
    let mut parameters = Parameters::rest(scene.muscles.len());
    for muscle in muscles {
        for side in sides {
            let name = format!("{muscle}_{side}");
            let place = scene.muscles.iter().position(|m| m.name == name);
            parameters.activations[place.expect("a muscle of the face")] = value;
        }
    }
    parameters
}

/// The pose from rest, and where its nodes are.
pub fn pose(rig: &mut Rig, parameters: &Parameters) -> Result<Vec<[f64; 3]>, RigError> {
    Ok(rig.solve(parameters)?.positions())
}
