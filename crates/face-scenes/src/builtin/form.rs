//! The form of the head: where the flesh at a material coordinate lies at rest.
//!
//! Flesh is described by material coordinates `(a, b, w)`: `a` runs sideways along the skin from
//! the midplane (0) to the cut in front of the ears, `b` downwards from the top of the forehead over
//! the chin to the neck (both about millimeters, and about x and y in the frontal part of the
//! face), and `w` from the bone (0) to the skin (1). Mouth and eyes are slits of the material along
//! lines of constant `b`; [`Side`] says which lip or lid a point on a slit belongs to.
//!
//! All lengths here are millimeters. The proportions are ordinary adult ones (pupils 62 mm apart,
//! mouth 50 mm, brow to chin 120 mm), chosen by eye; no measured person is behind them.

use super::features::{Features, Relief};
use super::spline::Spline;

/// Half width of the material: `a` goes from `-SIDE` to `SIDE`.
pub(super) const SIDE: f64 = 115.0;
/// Lower end of the material on the neck.
pub(super) const BOTTOM: f64 = -150.0;
/// Upper end of the material on the forehead.
pub(super) const TOP: f64 = 105.0;
/// The line between the lips.
pub(super) const MOUTH: f64 = -33.0;
/// The line between the lids.
pub(super) const EYES: f64 = 34.0;
/// x of the mouth corner and of the inner and outer corner of the eye.
pub(super) const MOUTH_CORNER: f64 = 25.5;
pub(super) const INNER_CANTHUS: f64 = 16.5;
pub(super) const OUTER_CANTHUS: f64 = 45.5;

/// Which side of a slit a point belongs to; without meaning away from the slits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Upper lip or lid.
    Upper,
    /// Lower lip or lid.
    Lower,
}

/// The smooth head without nose, lips, eyes: cross-sections lofted between the midline profile and
/// the line in front of the ears.
#[derive(Debug, Clone)]
pub(super) struct Form {
    front_y: Spline,
    front_z: Spline,
    side_x: Spline,
    side_y: Spline,
    side_z: Spline,
    fullness: Spline,
    features: Features,
    /// Material `a` of the inner and outer corner of the eye and the corner of the mouth.
    pub corners: [f64; 3],
}

/// A point of the smooth head with its outward unit normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Base {
    pub point: [f64; 3],
    pub normal: [f64; 3],
}

/// Profile: b, y, z.
const FRONT: [[f64; 3]; 19] = [
    [-150.0, -117.0, 30.0],
    [-130.0, -98.0, 35.0],
    [-115.0, -87.5, 48.0],
    [-100.0, -84.5, 65.0],
    [-88.0, -82.5, 80.5],
    [-80.0, -78.0, 90.0],
    [-72.0, -71.0, 94.5],
    [-62.0, -61.5, 94.5],
    [-50.0, -50.0, 92.5],
    [-33.0, -33.0, 94.5],
    [-15.0, -15.0, 94.5],
    [-5.0, -5.0, 93.5],
    [10.0, 10.0, 92.0],
    [25.0, 25.0, 91.0],
    [38.0, 38.0, 91.5],
    [50.0, 50.0, 93.5],
    [68.0, 67.5, 92.5],
    [88.0, 87.0, 86.5],
    [105.0, 102.5, 76.5],
];

/// In front of the ears: b, x, y, z.
const EAR: [[f64; 4]; 13] = [
    [-150.0, 51.0, -112.0, -14.0],
    [-115.0, 51.0, -77.0, -10.0],
    [-100.0, 52.0, -60.0, -8.0],
    [-80.0, 55.0, -43.0, -5.0],
    [-65.0, 58.5, -32.5, -3.0],
    [-50.0, 62.0, -23.5, -1.0],
    [-33.0, 65.5, -13.5, 0.0],
    [-10.0, 69.5, 0.0, 0.0],
    [10.0, 72.0, 14.5, 0.0],
    [34.0, 73.5, 34.0, 0.0],
    [55.0, 73.5, 54.0, 0.0],
    [80.0, 71.5, 78.0, 0.0],
    [105.0, 66.0, 100.0, 0.0],
];

impl Form {
    pub fn new() -> Self {
        let front = |k: usize| Spline::new(&FRONT.map(|p| [p[0], p[k]]));
        let ear = |k: usize| Spline::new(&EAR.map(|p| [p[0], p[k]]));
        let mut form = Self {
            front_y: front(1),
            front_z: front(2),
            side_x: ear(1),
            side_y: ear(2),
            side_z: ear(3),
            fullness: Spline::new(&[
                [-150.0, 2.0],
                [-100.0, 2.0],
                [-72.0, 2.0],
                [-33.0, 2.1],
                [10.0, 2.25],
                [50.0, 2.35],
                [105.0, 2.3],
            ]),
            features: Features::new(),
            corners: [0.0; 3],
        };
        form.corners = [
            form.lateral(INNER_CANTHUS, EYES),
            form.lateral(OUTER_CANTHUS, EYES),
            form.lateral(MOUTH_CORNER, MOUTH),
        ];
        form
    }

    /// A point of the smooth head.
    pub fn loft(&self, a: f64, b: f64) -> [f64; 3] {
        let (front_y, front_z) = (self.front_y.at(b), self.front_z.at(b));
        let (x, y, z) = (self.side_x.at(b), self.side_y.at(b), self.side_z.at(b));
        let depth = front_z - z;
        let n = self.fullness.at(b);
        let t = a / SIDE;
        let quarter = std::f64::consts::FRAC_PI_2;
        // One millimeter of a is one millimeter of x at the midline (less on the slim neck).
        let c = (SIDE / (depth * quarter)).min(1.25);
        let angle = quarter * (c * t + (1.0 - c) * t * t * t);
        let (sine, cosine) = angle.sin_cos();
        let r = ((sine.abs() / x).powf(n) + (cosine.abs() / depth).powf(n)).powf(-1.0 / n);
        let lower = 1.0 - (1.0 - t * t).max(0.0).powf(1.8);
        [r * sine, front_y + (y - front_y) * lower, z + r * cosine]
    }

    /// The smooth head and its normal.
    pub fn base(&self, a: f64, b: f64) -> Base {
        let step = 0.25;
        let [a0, a1, b0, b1] = [
            self.loft(a - step, b),
            self.loft(a + step, b),
            self.loft(a, b - step),
            self.loft(a, b + step),
        ];
        let u = [0, 1, 2].map(|k| a1[k] - a0[k]);
        let v = [0, 1, 2].map(|k| b1[k] - b0[k]);
        let n = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        Base {
            point: self.loft(a, b),
            normal: n.map(|x| x / length),
        }
    }

    /// Material `a >= 0` of the smooth head's point with this `x >= 0` in row `b`, by bisection.
    pub fn lateral(&self, x: f64, b: f64) -> f64 {
        let (mut low, mut high) = (0.0, SIDE);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.loft(middle, b)[0] < x {
                low = middle
            } else {
                high = middle
            }
        }
        0.5 * (low + high)
    }

    /// Rest position in millimeters of the flesh at a material coordinate.
    pub fn position(&self, a: f64, b: f64, w: f64, side: Side) -> [f64; 3] {
        // The right half is the exact mirror image of the left half.
        let mirror = if a < 0.0 { -1.0 } else { 1.0 };
        let a = a.abs();
        let base = self.base(a, b);
        let [x, y, _] = base.point;
        let side = if b == MOUTH || b == EYES {
            side
        } else if b > if b > 0.0 { EYES } else { MOUTH } {
            Side::Upper
        } else {
            Side::Lower
        };
        let shift = self.features.opening(x, y, b, side);
        let Relief {
            skin,
            bone,
            skin_out,
            bone_out,
            drop,
        } = self.features.relief(
            x,
            y + shift,
            base.point[2],
            b,
            side,
            self.features.thickness(a, b),
            base.normal,
        );
        let forward = bone + (skin - bone) * w;
        let out = bone_out + (skin_out - bone_out) * w;
        let p = [
            x + out * base.normal[0],
            y + shift + out * base.normal[1] + drop * w,
            base.point[2] + out * base.normal[2] + forward,
        ];
        // Exactly on the midplane where the material is.
        [if a == 0.0 { 0.0 } else { mirror * p[0] }, p[1], p[2]]
    }
}
