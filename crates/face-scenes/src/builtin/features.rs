//! Nose, lips, eyes, brows, cheeks and chin: relief on the smooth head, for skin and bone.
//!
//! Functions of the frontal coordinates `x >= 0` and `y` in millimeters. What belongs to the front
//! of the face is raised along +z, what goes around the side along the normal of the smooth head.

use super::form::{EYES, INNER_CANTHUS, MOUTH, MOUTH_CORNER, OUTER_CANTHUS, Side};
use super::spline::Spline;

/// Center (x, y, z) and radius of the left eyeball.
pub(super) const EYEBALL: [f64; 3] = [31.0, 34.0, 68.5];
pub(super) const EYEBALL_RADIUS: f64 = 12.0;
/// Radius of the sphere on which the skin of the lids lies.
const LID_RADIUS: f64 = 14.8;

/// Displacements at a point, in millimeters: along +z and along the outward normal, for the skin
/// and for the inner surface, and a displacement along +y that the skin has on top.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relief {
    pub skin: f64,
    pub bone: f64,
    pub skin_out: f64,
    pub bone_out: f64,
    pub drop: f64,
}

#[derive(Debug, Clone)]
pub(super) struct Features {
    nose_height: Spline,
    nose_width: Spline,
    upper_lip: Spline,
    lower_lip: Spline,
}

fn bell(d: f64, width: f64) -> f64 {
    (-0.5 * (d / width).powi(2)).exp()
}

/// 0 below `low`, 1 above `high`, C2 between.
fn step(x: f64, low: f64, high: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// Smooth maximum: rounds the corner over a height of about `k`.
fn smooth_max(a: f64, b: f64, k: f64) -> f64 {
    0.5 * (a + b + ((a - b).powi(2) + k * k).sqrt())
}

/// Opening profile of a slit between its ends: a parabola, with C1 support.
fn lens(x: f64, low: f64, high: f64) -> f64 {
    let s = (2.0 * x - low - high) / (high - low);
    (1.0 - s * s).max(0.0)
}

impl Features {
    pub fn new() -> Self {
        Self {
            nose_height: Spline::new(&[
                [-26.0, 0.0],
                [-19.0, 0.0],
                [-14.5, 0.8],
                [-11.5, 4.0],
                [-8.0, 11.5],
                [-4.0, 17.5],
                [0.5, 20.0],
                [5.0, 19.2],
                [12.0, 15.0],
                [22.0, 9.3],
                [30.0, 5.2],
                [38.0, 2.2],
                [46.0, 0.6],
                [54.0, 0.0],
                [60.0, 0.0],
            ]),
            nose_width: Spline::new(&[
                [-26.0, 7.5],
                [-12.0, 7.5],
                [-4.0, 9.5],
                [1.0, 9.8],
                [8.0, 8.6],
                [18.0, 8.0],
                [28.0, 7.8],
                [36.0, 8.4],
                [46.0, 12.0],
                [60.0, 16.0],
            ]),
            // Height over the distance from the lip line, in units of the lip's own height / 7.5.
            upper_lip: Spline::new(&[
                [0.0, 0.2],
                [1.0, 2.3],
                [3.0, 4.3],
                [5.5, 4.3],
                [7.5, 3.2],
                [10.0, 1.7],
                [14.0, 0.6],
                [19.0, 0.0],
                [26.0, 0.0],
            ]),
            lower_lip: Spline::new(&[
                [0.0, -0.3],
                [1.0, 1.7],
                [3.0, 4.0],
                [5.5, 4.5],
                [8.0, 3.2],
                [11.0, 0.4],
                [15.0, -1.8],
                [20.0, -1.2],
                [27.0, 0.0],
                [34.0, 0.0],
            ]),
        }
    }

    /// Displacement along +y that opens the slits and bends their lines.
    pub fn opening(&self, x: f64, y: f64, b: f64, side: Side) -> f64 {
        let up = side == Side::Upper;
        let fade = |d: f64, reach: f64| (1.0 - d / reach).clamp(0.0, 1.0).powi(2);
        // Eyes: wider near the nose above and near the temple below; the outer corner is higher.
        let middle = lens(x, INNER_CANTHUS, OUTER_CANTHUS).powf(0.8);
        let slant = (x - EYEBALL[0]) / 14.5;
        let tilt = 0.9 * slant * bell(x - EYEBALL[0], 22.0);
        let d = (b - EYES).abs();
        let eye = if b > 0.0 {
            if up {
                5.2 * middle * (1.0 - 0.12 * slant) * fade(d, 23.0)
            } else {
                -3.6 * middle * (1.0 + 0.12 * slant) * fade(d, 20.0)
            }
        } else {
            0.0
        };
        // Mouth: almost closed; the line dips a little in the middle and at the corners.
        let d = (b - MOUTH).abs();
        let gap = lens(x, -MOUTH_CORNER, MOUTH_CORNER);
        let line = (-0.7 * bell(x, 4.0) + 0.5 * bell(x - 10.0, 6.0) - 0.9 * bell(x - 27.0, 7.0))
            * fade(d, 24.0);
        let mouth = if up { 0.30 * gap } else { -0.45 * gap } * fade(d, 14.0);
        eye + tilt * bell(y - EYES, 14.0) + line + mouth
    }

    /// Thickness of the flesh along the normal of the smooth head.
    pub fn thickness(&self, a: f64, b: f64) -> f64 {
        // Forehead 5.5, temple 9, over the cheekbone 8.5, lips 10, buccal 15, masseter 17, neck 14.
        let forehead = 5.5 + 4.0 * step(a, 55.0, 85.0) * bell(b - 48.0, 26.0);
        let cheek = 8.0 * bell(a - 66.0, 26.0) * bell(b + 28.0, 24.0);
        let masseter = 9.0 * bell(a - 92.0, 15.0) * bell(b + 34.0, 26.0);
        let midface = 3.6 * bell(b - 2.0, 30.0);
        let mouth = 2.2 * bell(a, 32.0) * bell(b - MOUTH, 18.0);
        let chin = 5.0 * bell(b + 72.0, 20.0);
        let neck = 8.5 * step(-b, 78.0, 118.0);
        forehead + cheek + masseter + midface + mouth + chin + neck
    }

    /// Distance of the lip's edge from the lip line over its value in the middle, 7.5 mm.
    pub fn lip_scale(x: f64, side: Side) -> f64 {
        let taper = (1.0 - (x / (MOUTH_CORNER + 1.5)).powi(2))
            .max(0.0)
            .powf(0.62);
        match side {
            // Two peaks beside a dip: Cupid's bow.
            Side::Upper => {
                0.16 + 0.84 * taper * (1.0 - 0.16 * bell(x, 2.6) + 0.06 * bell(x - 6.0, 3.0))
            }
            Side::Lower => 0.18 + 0.92 * taper,
        }
    }

    /// Height of the nose above the smooth face.
    fn nose(&self, x: f64, y: f64) -> f64 {
        let height =
            self.nose_height.at(y).max(0.0) * step(60.0 - y, 0.0, 6.0) * step(y, -26.0, -20.0);
        let width = self.nose_width.at(y);
        let ridge = height * (-((x / width).powi(2)).powf(1.08)).exp();
        let wing =
            11.5 * (-(((x - 11.2) / 6.0).powi(2) + ((y + 4.6) / 6.6).powi(2)).powf(1.3)).exp();
        let tip = 2.0 * bell(x, 6.0) * bell(y + 0.5, 5.5);
        smooth_max(ridge, wing, 1.6) - 0.8 * (ridge + wing).clamp(0.0, 1.0) + tip
    }

    /// Relief at the frontal point `(x, y)` of the opened face, where the smooth head is at `z`.
    pub fn relief(
        &self,
        x: f64,
        y: f64,
        z: f64,
        b: f64,
        side: Side,
        thickness: f64,
        normal: [f64; 3],
    ) -> Relief {
        let lower_face = b <= 0.0;
        let nose = if normal[2] > 0.0 {
            self.nose(x, y)
        } else {
            0.0
        };

        let lips = if !lower_face || b < -70.0 {
            0.0
        } else {
            self.lips(x, y, side)
        };
        let philtrum = if side == Side::Upper && lower_face {
            philtrum(x, y)
        } else {
            0.0
        };
        let glabella =
            1.0 * bell(x, 10.0) * bell(y - 52.0, 8.0) - 1.6 * bell(x, 9.0) * bell(y - 38.0, 6.0);
        let socket = -7.5 * bell(x - 29.0, 13.5) * bell(y - 36.0, 9.0)
            - 3.0 * bell(x - 17.0, 5.0) * bell(y - 33.0, 8.0);
        let upper_face = b > 0.0 && normal[2] > 0.0;
        let corner = -1.8 * bell(x - 28.5, 4.0) * bell(y - MOUTH + 1.0, 6.0);
        let surface = nose + lips + philtrum + corner + fold(x, y) + glabella;
        let mut skin = surface + if upper_face { socket + bag(x, y) } else { 0.0 };
        let nasal_bone = 0.55 * nose * step(y, -4.0, 26.0) + 0.30 * nose;
        let mut bone =
            nasal_bone + 0.45 * lips + glabella + if upper_face { 0.9 * socket } else { 0.0 };
        let out = outward(x, y);
        let mut skin_out = out;
        let mut bone_out = -thickness + 0.8 * out;
        if b < -40.0 {
            let chin = 4.2 * bell(x, 14.0) * bell(y + 68.0, 9.0)
                - 0.5 * bell(x, 3.0) * bell(y + 69.0, 6.0);
            skin_out += chin;
            bone_out += 0.8 * chin;
        }
        if upper_face {
            let lift = normal[2].max(0.3);
            [skin, bone] = lids([x, y, z], [skin, bone], [skin_out, bone_out], lift);
        }
        // Nostrils, and the tip that hangs over them.
        let nostril = bell(x - 6.2, 2.6) * bell(y + 10.2, 1.8);
        skin -= 3.2 * nostril;
        let drop = -2.6 * (nose / 20.0).max(0.0).powi(2);
        Relief {
            skin,
            bone,
            skin_out,
            bone_out,
            drop,
        }
    }

    fn lips(&self, x: f64, y: f64, side: Side) -> f64 {
        let v = y - MOUTH;
        let mouth_width = (1.0 - (x / 33.0).powi(2)).max(0.0).powf(0.75);
        let scale = Features::lip_scale(x, side);
        let curve = match side {
            Side::Upper => self.upper_lip.at((v.max(0.0) / scale).min(26.0)),
            Side::Lower => self.lower_lip.at((-v.min(0.0) / scale).min(34.0)),
        };
        curve * mouth_width * (0.45 + 0.55 * scale.min(1.0))
    }
}

/// Brow, cheek, hollow and temple, along the normal.
fn outward(x: f64, y: f64) -> f64 {
    let cheek = 5.2 * bell(x - 45.0, 14.0) * bell(y - 12.0, 12.0);
    let hollow = -2.6 * bell(x - 53.0, 11.0) * bell(y + 24.0, 15.0);
    let temple = -3.0 * bell(x - 68.0, 9.0) * bell(y - 52.0, 17.0);
    brow(x, y) + cheek + hollow + temple
}

fn philtrum(x: f64, y: f64) -> f64 {
    (0.7 * bell(x - 4.6, 1.8) - 1.1 * bell(x, 2.4))
        * step(y - MOUTH, 3.0, 8.0)
        * step(-y, 13.0, 19.0)
}

/// The fold from the wing of the nose past the corner of the mouth.
fn fold(x: f64, y: f64) -> f64 {
    let fold_x = 17.5 + 0.50 * (-4.0 - y) - 0.0035 * (-4.0 - y).powi(2);
    let mask = step(-y, -2.0, 12.0) * step(y, -52.0, -34.0);
    mask * (-1.5 * bell(x - fold_x, 2.6) + 1.2 * bell(x - fold_x - 8.0, 6.0))
}

fn brow(x: f64, y: f64) -> f64 {
    let line = 53.0 + 3.0 * bell(x - 38.0, 14.0) - 3.0 * step(x, 44.0, 60.0);
    3.6 * bell(y - line, 6.0) * step(x, -6.0, 12.0) * (1.0 - step(x, 46.0, 62.0))
}

/// Under the eye.
fn bag(x: f64, y: f64) -> f64 {
    0.7 * bell(y - (24.5 + 0.012 * (x - 31.0).powi(2)), 2.5) * bell(x - 31.0, 11.0)
        - 0.9 * bell(y - (20.5 + 0.012 * (x - 31.0).powi(2)), 2.5) * bell(x - 29.0, 11.0)
}

/// Skin and bone over the eyeball: the lids lie on it, so take whichever is farther out, in the direction
/// of z.
fn lids(
    [x, y, z]: [f64; 3],
    [skin, bone]: [f64; 2],
    [skin_out, bone_out]: [f64; 2],
    lift: f64,
) -> [f64; 2] {
    let (dx, dy) = (x - EYEBALL[0], y - EYEBALL[1]);
    let ball = |radius: f64| {
        let q = (dx * dx + dy * dy) / (radius * radius);
        EYEBALL[2] + radius * (1.0 - 0.5 * q - 0.125 * q * q - 0.08 * q * q * q) - z
    };
    let crease_y = 42.6 - 0.017 * (x - 30.0).powi(2);
    let crease = -1.5 * bell(y - crease_y, 1.5) * bell(x - 31.0, 10.5);
    let blend = bell(dx, 17.0) * bell(dy, 15.0);
    let over = smooth_max(skin + skin_out * lift, ball(LID_RADIUS), 1.4) - skin_out * lift;
    let under =
        smooth_max(bone + bone_out * lift, ball(EYEBALL_RADIUS + 0.15), 1.4) - bone_out * lift;
    let share = step(blend, 0.05, 0.5);
    [
        skin + ((over - skin) * share + crease),
        bone + (under - bone) * share,
    ]
}
