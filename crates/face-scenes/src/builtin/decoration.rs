//! Eyeballs, teeth and the inside of the mouth: surfaces for pictures, not simulated.

use super::features::{EYEBALL, EYEBALL_RADIUS};
use face_rig::anatomy::Bone;
use std::f64::consts::{PI, TAU};

/// What a decoration is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ornament {
    /// An eyeball; its pattern coordinate is the unit vector from its center.
    Eyeball,
    /// A row of teeth with the gum; the coordinate is `(millimeters along the arch, millimeters
    /// from the edge, 0)`.
    Teeth,
    /// The dark inside of the mouth.
    MouthCavity,
    /// The tongue on the floor of the mouth; the coordinate is `(millimeters from the midplane, 0, 0)`.
    Tongue,
    /// What shows between the lids beside the eyeball.
    EyeSocket,
}

/// A surface that is only drawn; it moves rigidly with a bone.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoration {
    /// What it is.
    pub ornament: Ornament,
    /// The bone it moves with.
    pub bone: Bone,
    /// Rest positions, meters.
    pub points: Vec<[f64; 3]>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Coordinates for [`Ornament::color`].
    pub coordinates: Vec<[f64; 3]>,
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    let t = t.clamp(0.0, 1.0);
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
}

impl Ornament {
    /// sRGB color at a pattern coordinate.
    pub fn color(self, c: [f64; 3]) -> [f32; 3] {
        match self {
            Self::Eyeball => {
                // Radius on the ball around the line of sight, millimeters.
                let r = EYEBALL_RADIUS * c[0].hypot(c[1]);
                let white = mix([0.93, 0.91, 0.89], [0.86, 0.70, 0.66], (r - 8.0) / 4.0);
                let spokes = 0.5 + 0.5 * (c[1].atan2(c[0]) * 23.0).sin();
                let iris = mix([0.40, 0.30, 0.20], [0.25, 0.19, 0.14], 0.5 * spokes);
                let iris = mix(iris, [0.13, 0.10, 0.09], (r - 4.7) / 0.9);
                let eye = mix(iris, white, (r - 5.6) / 0.5);
                let eye = mix([0.03, 0.03, 0.03], eye, (r - 2.1) / 0.3);
                // The light in the eye.
                let spark = (EYEBALL_RADIUS * c[0] + 1.7).hypot(EYEBALL_RADIUS * c[1] - 2.2);
                mix([1.0; 3], eye, (spark - 0.7) / 0.5).map(|x| x as f32)
            }
            Self::Teeth => {
                let gap = [0.0, 8.3, 15.0, 22.5, 29.5, 36.5]
                    .map(|x: f64| (c[0].abs() - x).abs())
                    .into_iter()
                    .fold(f64::INFINITY, f64::min);
                let tooth = mix([0.62, 0.52, 0.45], [0.93, 0.90, 0.83], (gap - 0.1) / 0.7);
                let gum_line = 8.6 - 0.8 * (1.0 - (gap / 2.5).min(1.0));
                mix(tooth, [0.70, 0.38, 0.37], (c[1] - gum_line) / 0.6).map(|x| x as f32)
            }
            Self::MouthCavity => [0.20, 0.06, 0.06],
            Self::Tongue => {
                let groove = (-0.5 * (c[0] / 1.6).powi(2)).exp();
                mix([0.76, 0.40, 0.40], [0.62, 0.29, 0.30], groove).map(|x| x as f32)
            }
            Self::EyeSocket => [0.72, 0.44, 0.41],
        }
    }
}

/// A grid of points as a surface: `rows x columns`, outward on the left of increasing columns.
fn sheet(
    ornament: Ornament,
    bone: Bone,
    [rows, columns]: [usize; 2],
    at: impl Fn(f64, f64) -> ([f64; 3], [f64; 3]),
) -> Decoration {
    let mut points = Vec::new();
    let mut coordinates = Vec::new();
    for i in 0..=rows {
        for j in 0..=columns {
            let (p, c) = at(i as f64 / rows as f64, j as f64 / columns as f64);
            points.push(p.map(|x| 1e-3 * x));
            coordinates.push(c);
        }
    }
    let id = |i: usize, j: usize| (i * (columns + 1) + j) as u32;
    let mut triangles = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            triangles.push([id(i, j), id(i, j + 1), id(i + 1, j + 1)]);
            triangles.push([id(i, j), id(i + 1, j + 1), id(i + 1, j)]);
        }
    }
    Decoration {
        ornament,
        bone,
        points,
        triangles,
        coordinates,
    }
}

/// The front of the teeth at a distance from the midplane, millimeters: a parabola behind lips and
/// cheeks.
pub(super) fn arch(x: f64) -> f64 {
    82.8 - 0.0225 * x * x
}

/// Teeth and gums of one jaw as a closed block with the arch in front, meters: points and triangles.
pub(super) fn teeth_block(bone: Bone) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    const COLUMNS: usize = 16;
    const HALF: f64 = 31.0;
    let ([low, high], back) = match bone {
        Bone::Jaw => ([-52.0, -34.6], 2.2),
        _ => ([-35.6, -15.0], 0.0),
    };
    let mut outline: Vec<[f64; 2]> = (0..=COLUMNS)
        .map(|i| HALF * (2.0 * i as f64 / COLUMNS as f64 - 1.0))
        .map(|x| [x, arch(x) - back])
        .collect();
    // Behind the last tooth straight across.
    outline.extend([[HALF, 50.0], [-HALF, 50.0]]);
    let count = outline.len() as u32;
    let mut points: Vec<[f64; 3]> = Vec::new();
    for y in [low, high] {
        points.extend(outline.iter().map(|&[x, z]| [x, y, z]));
        points.push([0.0, y, 60.0]);
    }
    let mut triangles = Vec::new();
    for i in 0..count {
        let (j, up) = ((i + 1) % count, count + 1);
        triangles.extend([[i, j, up + j], [i, up + j, up + i]]);
        triangles.extend([[count, j, i], [up + count, up + i, up + j]]);
    }
    (
        points.iter().map(|p| p.map(|c| 1e-3 * c)).collect(),
        triangles,
    )
}

/// The surfaces that make pictures of the face complete.
pub(super) fn decorations() -> Vec<Decoration> {
    let mut all = Vec::new();
    for side in [1.0, -1.0] {
        all.extend(eye(side));
    }
    for (bone, edge, up, back) in [
        (Bone::Cranium, -36.2, 1.0, 0.0),
        (Bone::Jaw, -34.2, -1.0, 2.2),
    ] {
        all.push(sheet(Ornament::Teeth, bone, [12, 48], |s, t| {
            let x = 64.0 * (t - 0.5) * 0.9;
            let height = 15.0 * if up > 0.0 { s } else { 1.0 - s };
            let bulge = 0.6 - 0.04 * (height - 4.0).powi(2) * 0.3;
            let p = [x, edge + up * height, arch(x) - back + bulge];
            (p, [1.18 * x, height, 0.0])
        }));
    }
    all.push(tongue());
    all.push(sheet(
        Ornament::MouthCavity,
        Bone::Cranium,
        [16, 32],
        |s, t| {
            let d = direction(s, (t - 0.5) * PI);
            // A bowl behind the teeth, seen from inside.
            (
                [-30.0 * d[0], -42.0 + 34.0 * d[1], 58.0 - 34.0 * d[2]],
                [0.0; 3],
            )
        },
    ));
    all
}

/// A flat dome between the lower teeth with a groove in the middle.
fn tongue() -> Decoration {
    sheet(Ornament::Tongue, Bone::Jaw, [16, 32], |s, t| {
        let d = direction(0.5 + 0.5 * s, (t - 0.5) * TAU);
        let x = 25.0 * d[0];
        let groove = 1.2 * (-0.5 * (x / 3.0_f64).powi(2)).exp() * d[1];
        let p = [x, -47.0 + 10.0 * d[1] - groove, 46.0 + 31.0 * d[2]];
        (p, [x, 0.0, 0.0])
    })
}

/// On the unit ball, with poles up and down and the front in the middle of the columns.
fn direction(s: f64, longitude: f64) -> [f64; 3] {
    let latitude = (s - 0.5) * PI;
    [
        latitude.cos() * longitude.sin(),
        latitude.sin(),
        latitude.cos() * longitude.cos(),
    ]
}

/// The socket and the ball of the eye on one side.
fn eye(side: f64) -> [Decoration; 2] {
    let socket = sheet(Ornament::EyeSocket, Bone::Cranium, [12, 24], |s, t| {
        let d = direction(s, (t - 0.5) * TAU);
        let center = [side * 29.0, EYEBALL[1], 63.0];
        (
            [0, 1, 2].map(|k| center[k] + [17.0, 13.0, 15.0][k] * d[k]),
            [0.0; 3],
        )
    });
    let ball = sheet(Ornament::Eyeball, Bone::Cranium, [24, 48], |s, t| {
        let d = direction(s, (t - 0.5) * TAU);
        let r = EYEBALL_RADIUS - 0.1;
        (
            [
                side * EYEBALL[0] + r * d[0],
                EYEBALL[1] + r * d[1],
                EYEBALL[2] + r * d[2],
            ],
            if d[2] > 0.0 { d } else { [1.0, 0.0, 0.0] },
        )
    });
    [socket, ball]
}
