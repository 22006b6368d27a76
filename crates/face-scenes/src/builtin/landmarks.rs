//! The 68 facial landmarks of the Multi-PIE mark-up.
//!
//! Order (R. Gross et al., "Multi-PIE", Image and Vision Computing 28, 2010; the 68 points are the
//! usual mark-up of its images): 0-16 jaw line from the subject's right ear over the chin to the
//! left ear, 17-21 right brow and 22-26 left brow, 27-30 bridge of the nose, 31-35 under the nose,
//! 36-41 right eye, 42-47 left eye, 48-59 outer and 60-67 inner line of the lips.

use super::features::Features;
use super::form::{EYES, Form, MOUTH, Side};
use super::paint::brow_line;

/// Material point and side of a landmark.
type Place = ([f64; 2], Side);

/// The landmarks on the skin, material coordinates `(a, b)` in millimeters.
pub(super) fn landmarks(form: &Form) -> Vec<Place> {
    let upper = |a: f64, b: f64| ([a, b], Side::Upper);
    // Frontal x (either sign) to material a.
    let at = |x: f64, b: f64| x.signum() * form.lateral(x.abs(), b);
    let mut all: Vec<Place> = Vec::with_capacity(68);
    let jaw = [
        [0.0, -81.0],
        [28.0, -80.5],
        [56.0, -79.0],
        [83.0, -74.0],
        [100.0, -57.0],
        [107.0, -29.0],
        [109.0, -5.0],
        [110.0, 16.0],
        [110.0, 36.0],
    ];
    all.extend((1..9).rev().map(|i| upper(-jaw[i][0], jaw[i][1])));
    all.extend(jaw.iter().map(|p| upper(p[0], p[1])));
    let brow: [f64; 5] = [13.0, 24.0, 35.0, 46.0, 55.0];
    for x in brow.iter().rev().map(|x| -x).chain(brow) {
        let b = brow_line(x.abs());
        all.push(upper(at(x, b), b));
    }
    all.extend([38.0, 28.0, 17.5, 2.5].map(|b| upper(0.0, b)));
    for (x, b) in [
        (-12.5, -11.0),
        (-6.5, -13.0),
        (0.0, -13.5),
        (6.5, -13.0),
        (12.5, -11.0),
    ] {
        all.push(upper(at(x, b), b));
    }
    let [inner, outer, corner] = form.corners;
    let lid = |x: f64, side| ([at(x, EYES), EYES], side);
    use Side::{Lower, Upper};
    all.push(upper(-outer, EYES));
    all.extend([lid(-36.5, Upper), lid(-26.0, Upper)]);
    all.push(upper(-inner, EYES));
    all.extend([lid(-26.0, Lower), lid(-36.5, Lower)]);
    all.push(upper(inner, EYES));
    all.extend([lid(26.0, Upper), lid(36.5, Upper)]);
    all.push(upper(outer, EYES));
    all.extend([lid(36.5, Lower), lid(26.0, Lower)]);
    let lip = |x: f64, side: Side| {
        let edge = lip_edge(x.abs(), side);
        ([at(x, edge), edge], side)
    };
    let line = |x: f64, side: Side| ([at(x, MOUTH), MOUTH], side);
    all.push(upper(-corner, MOUTH));
    all.extend([-16.5, -6.2, 0.0, 6.2, 16.5].map(|x| lip(x, Upper)));
    all.push(upper(corner, MOUTH));
    all.extend([16.5, 8.5, 0.0, -8.5, -16.5].map(|x| lip(x, Lower)));
    all.extend([-22.5, -10.0, 0.0, 10.0, 22.5].map(|x| line(x, Upper)));
    all.extend([10.0, 0.0, -10.0].map(|x| line(x, Lower)));
    all
}

/// Material `b` of the edge between the red of the lip and the skin.
pub(super) fn lip_edge(x: f64, side: Side) -> f64 {
    match side {
        Side::Upper => MOUTH + 7.6 * Features::lip_scale(x, side),
        Side::Lower => MOUTH - 9.2 * Features::lip_scale(x, side),
    }
}
