//! Lines through points: smoothed, cut into short pieces, laid over solids.

pub(super) fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}
pub(super) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}
pub(super) fn scale(a: [f64; 3], s: f64) -> [f64; 3] {
    a.map(|v| v * s)
}
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}
pub(super) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    scale(a, 1.0 / norm(a))
}
pub(super) fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// The line through the same points without corners: a centripetal Catmull-Rom spline (Yuksel,
/// Schaefer and Keyser 2011), `pieces` straight pieces for each one given.
pub fn smoothed(line: &[[f64; 3]], closed: bool, pieces: usize) -> Vec<[f64; 3]> {
    let count = line.len();
    if count < 3 || pieces < 2 {
        return line.to_vec();
    }
    let at = |i: isize| -> [f64; 3] {
        if closed {
            return line[i.rem_euclid(count as isize) as usize];
        }
        match i {
            -1 => mix(line[0], line[1], -1.0),
            i if i as usize == count => mix(line[count - 1], line[count - 2], -1.0),
            i => line[i as usize],
        }
    };
    let spans = if closed { count } else { count - 1 };
    let mut smooth = Vec::with_capacity(spans * pieces + 1);
    for span in 0..spans as isize {
        let around = [at(span - 1), at(span), at(span + 1), at(span + 2)];
        smooth.extend((0..pieces).map(|k| catmull_rom(around, k as f64 / pieces as f64)));
    }
    if !closed {
        smooth.push(line[count - 1]);
    }
    smooth
}

/// The spline between the two middle points of four, at a share of the way (Barry and Goldman 1988).
fn catmull_rom(p: [[f64; 3]; 4], share: f64) -> [f64; 3] {
    let mut knots = [0.0; 4];
    for i in 0..3 {
        knots[i + 1] = knots[i] + norm(sub(p[i + 1], p[i])).sqrt();
    }
    let t = knots[1] + share * (knots[2] - knots[1]);
    let between = |a, b, from: f64, to: f64| mix(a, b, (t - from) / (to - from));
    let once: [[f64; 3]; 3] =
        std::array::from_fn(|i| between(p[i], p[i + 1], knots[i], knots[i + 1]));
    let twice: [[f64; 3]; 2] =
        std::array::from_fn(|i| between(once[i], once[i + 1], knots[i], knots[i + 2]));
    between(twice[0], twice[1], knots[1], knots[2])
}

/// The line with points added so that no piece is longer than `step`; `None` where `step` is not
/// above 0.
pub fn resampled(line: &[[f64; 3]], closed: bool, step: f64) -> Option<Vec<[f64; 3]>> {
    if !(step > 0.0) {
        return None;
    }
    let mut fine = Vec::new();
    let next = |i: usize| line.get(i + 1).or(line.first().filter(|_| closed));
    for (i, &from) in line.iter().enumerate() {
        let Some(&to) = next(i) else {
            fine.push(from);
            break;
        };
        let pieces = (norm(sub(to, from)) / step).ceil().clamp(1.0, 1e6) as usize;
        fine.extend((0..pieces).map(|k| mix(from, to, k as f64 / pieces as f64)));
    }
    Some(fine)
}

/// The line laid over a solid: points that are nearer to it than `clearance` go there along its
/// normal. `solid` gives signed distance and unit normal of a point.
pub fn wrapped(
    line: &[[f64; 3]],
    clearance: f64,
    solid: impl Fn(&[f64; 3]) -> (f64, [f64; 3]),
) -> Vec<[f64; 3]> {
    let lay = |&x: &[f64; 3]| {
        let (distance, normal) = solid(&x);
        match distance < clearance {
            true => add(x, scale(normal, clearance - distance)),
            false => x,
        }
    };
    line.iter().map(lay).collect()
}
