//! Colors of the face over its material coordinates, for pictures.

use super::features::Features;
use super::form::{EYES, MOUTH, Side};

fn bell(d: f64, width: f64) -> f64 {
    (-0.5 * (d / width).powi(2)).exp()
}

fn edge(x: f64, width: f64) -> f64 {
    0.5 * (1.0 + (x / width).clamp(-1.0, 1.0) * (1.5 - 0.5 * (x / width).clamp(-1.0, 1.0).powi(2)))
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t.clamp(0.0, 1.0))
}

/// Height of the middle of the brow at the frontal `x >= 0`, millimeters.
pub(super) fn brow_line(x: f64) -> f64 {
    54.4 + 2.7 * bell(x - 41.0, 13.0) - 6.5 * ((x - 45.0).max(0.0) / 16.0).powi(2)
}

/// sRGB color of the flesh at the material coordinate `(a, b, w)`: skin with lips, brows, a little
/// more blood in cheeks and nose, and red inside.
pub fn flesh_color(material: [f64; 3]) -> [f32; 3] {
    let [a, b, w] = material;
    let x = a.abs();
    let mut c = [0.845, 0.655, 0.555];
    let flush = 0.55 * bell(x - 46.0, 17.0) * bell(b - 3.0, 15.0)
        + 0.55 * bell(x, 12.0) * bell(b - 1.0, 9.0)
        + 0.25 * bell(x, 13.0) * bell(b + 68.0, 9.0);
    c = mix(c, [0.82, 0.50, 0.43], 0.6 * flush);
    let shadow = bell(x - 30.0, 13.0) * bell(b - 29.0, 8.0);
    c = mix(c, [0.68, 0.46, 0.41], 0.35 * shadow);
    // Lips.
    let v = b - MOUTH;
    let scale = Features::lip_scale(x, if v > 0.0 { Side::Upper } else { Side::Lower });
    let height = if v > 0.0 { 7.6 } else { 9.2 };
    let lip = edge(height * scale - v.abs(), 0.9) * edge(26.5 - x, 1.5);
    c = mix(c, [0.71, 0.37, 0.35], 0.8 * lip);
    // Brows: hair that thins out at both ends.
    let arch = brow_line(x);
    let half = 2.9 - 1.7 * ((x - 14.0) / 42.0).clamp(0.0, 1.0);
    let hair = edge(half - (b - arch).abs(), 2.2) * edge(x - 14.0, 4.5) * edge(57.0 - x, 3.0);
    c = mix(c, [0.27, 0.185, 0.145], 0.74 * hair);
    // Nostrils, and the line of the lashes.
    c = mix(
        c,
        [0.23, 0.10, 0.09],
        0.85 * bell(x - 6.2, 2.3) * bell(b + 10.3, 1.3),
    );
    let lash = bell(b - EYES, if b > EYES { 0.75 } else { 0.4 })
        * edge(x - 17.5, 2.0)
        * edge(49.5 - x, 2.0);
    c = mix(c, [0.20, 0.13, 0.11], 0.75 * lash);
    // Inside.
    let inside = edge(0.72 - w, 0.28);
    let wet = if b > 10.0 {
        [0.74, 0.47, 0.42]
    } else {
        [0.52, 0.21, 0.20]
    };
    mix(c, wet, inside).map(|x| x as f32)
}
