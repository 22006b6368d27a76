//! The flesh of a course as samples.

use super::line::{add, cross, dot, mix, norm, scale, sub, unit};
use super::{Course, Section};
use std::f64::consts::PI;

/// A piece of flesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub position: [f64; 3],
    /// Of length 1.
    pub tangent: [f64; 3],
    /// m³.
    pub volume: f64,
}

/// Places within cells that fill the unit cube evenly (Roberts 2018: multiples of the powers of the
/// inverse of x with x⁴ = x + 1), so that rows of samples meet no row of elements in step.
struct Places(u32);

impl Places {
    fn next(&mut self) -> [f64; 3] {
        const INVERSE: f64 = 0.819_172_513_396_164_4;
        self.0 = self.0.wrapping_add(1);
        let at = f64::from(self.0);
        [INVERSE, INVERSE * INVERSE, INVERSE * INVERSE * INVERSE]
            .map(|step| (0.5 + at * step).fract())
    }
}

/// How many steps of at most `spacing` a length takes.
fn steps(length: f64, spacing: f64) -> usize {
    (length / spacing).ceil().clamp(1.0, 1e6) as usize
}

impl Course {
    /// All flesh of the course, in pieces about `spacing` apart.
    pub(super) fn sweep(&self, spacing: f64, visit: &mut dyn FnMut(Sample)) {
        let lines = self.whole_lines();
        let places = &mut Places(0);
        match self.section {
            Section::Round { radius } => {
                for line in &lines {
                    tube(line, self.closed, radius, spacing, places, visit);
                }
            }
            Section::Strap {
                width,
                thickness,
                normal,
            } => {
                for line in &lines {
                    let [left, right] = sides(line, width, normal, self.closed);
                    let pair = [&left[..], &right[..]];
                    strip(pair, self.closed, thickness, spacing, places, visit);
                }
            }
            Section::Sheet { thickness, rounded } => {
                let paired = paired(&lines);
                for pair in paired.windows(2) {
                    let pair = [&pair[0][..], &pair[1][..]];
                    strip(pair, self.closed, thickness, spacing, places, visit);
                }
                if let (true, [first, second, ..]) = (rounded, &paired[..]) {
                    let [.., before, last] = &paired[..] else {
                        return;
                    };
                    for (line, inner) in [(first, second), (last, before)] {
                        let radius = 0.5 * thickness;
                        border(line, inner, self.closed, radius, spacing, places, visit);
                    }
                }
            }
        }
    }
}

/// The direction of a line at each of its points, of length 1: between those of the pieces that meet.
fn directions(line: &[[f64; 3]], closed: bool) -> Vec<[f64; 3]> {
    let pieces: Vec<[f64; 3]> = line.windows(2).map(|w| unit(sub(w[1], w[0]))).collect();
    let last = pieces.len() - 1;
    let around = |i: usize| match (i, closed) {
        (0, true) => [last, 0],
        (0, false) => [0, 0],
        (i, true) if i > last => [last, 0],
        (i, false) if i > last => [last, last],
        (i, _) => [i - 1, i],
    };
    let meet = |i: usize| {
        let sum = around(i).map(|k| pieces[k]).into_iter().fold([0.0; 3], add);
        match norm(sum) > 1e-9 {
            true => unit(sum),
            false => pieces[around(i)[1]],
        }
    };
    (0..=last + 1).map(meet).collect()
}

/// The part of `a` across a unit vector, of length 1.
fn across(a: [f64; 3], direction: [f64; 3]) -> Option<[f64; 3]> {
    let rest = sub(a, scale(direction, dot(a, direction)));
    (norm(rest) > 1e-9 * norm(a)).then(|| unit(rest))
}

/// A bundle about a line.
fn tube(
    line: &[[f64; 3]],
    closed: bool,
    radius: f64,
    spacing: f64,
    places: &mut Places,
    visit: &mut dyn FnMut(Sample),
) {
    let mut side = start_across(line);
    let frame = |direction: [f64; 3]| {
        // Carried along without turning about the line.
        side = across(side, direction).unwrap_or_else(|| any_across(direction));
        [side, cross(direction, side)]
    };
    let frames: Vec<_> = directions(line, closed).into_iter().map(frame).collect();
    let disc = Disc {
        radius,
        turn: 2.0 * PI,
    };
    for (ends, frames) in line.windows(2).zip(frames.windows(2)) {
        disc.sweep(ends, frames, spacing, places, visit);
    }
}

/// Half a bundle along the border of a sheet, on the side away from `inner`.
fn border(
    line: &[[f64; 3]],
    inner: &[[f64; 3]],
    closed: bool,
    radius: f64,
    spacing: f64,
    places: &mut Places,
    visit: &mut dyn FnMut(Sample),
) {
    let directions = directions(line, closed);
    let frame = |i: usize| {
        let out = across(sub(line[i], inner[i]), directions[i])?;
        Some([out, cross(directions[i], out)])
    };
    let frames: Vec<_> = (0..line.len()).map(frame).collect();
    let disc = Disc { radius, turn: PI };
    for (ends, frames) in line.windows(2).zip(frames.windows(2)) {
        // Where the lines of a sheet run together it has no border.
        if let [Some(from), Some(to)] = *frames {
            disc.sweep(ends, &[from, to], spacing, places, visit);
        }
    }
}

/// A disc, or a part of it around the first axis, that is swept along a straight piece.
struct Disc {
    radius: f64,
    /// Its angle.
    turn: f64,
}

impl Disc {
    /// Every sample stands for the same share of the disc (ring j of n holds 6 j + 3 of them) and for
    /// the way that it goes: less inside of a bend, more outside.
    fn sweep(
        &self,
        ends: &[[f64; 3]],
        frames: &[[[f64; 3]; 2]],
        spacing: f64,
        places: &mut Places,
        visit: &mut dyn FnMut(Sample),
    ) {
        let way = sub(ends[1], ends[0]);
        if !(norm(way) > 0.0) {
            return;
        }
        let (tangent, pieces) = (unit(way), steps(norm(way), spacing));
        let rings = steps(self.radius, spacing);
        let area = 0.5 * self.turn * self.radius * self.radius / (3 * rings * rings) as f64;
        for piece in 0..pieces {
            for ring in 0..rings {
                let count = 6 * ring + 3;
                for k in 0..count {
                    let place = places.next();
                    let square = (ring * ring) as f64 + place[0] * (2 * ring + 1) as f64;
                    let r = self.radius * square.sqrt() / rings as f64;
                    let share = (k as f64 + place[1]) / count as f64;
                    let (sin, cos) = (self.turn * (share - 0.5)).sin_cos();
                    let [from, to]: [[f64; 3]; 2] = std::array::from_fn(|e| {
                        let [first, second] = frames[e];
                        let offset = add(scale(first, r * cos), scale(second, r * sin));
                        add(ends[e], offset)
                    });
                    let length = dot(sub(to, from), tangent).max(0.0);
                    visit(Sample {
                        position: mix(from, to, (piece as f64 + place[2]) / pieces as f64),
                        tangent,
                        volume: area * length / pieces as f64,
                    });
                }
            }
        }
    }
}

/// A sheet ruled between two lines of as many points, layer by layer.
fn strip(
    [left, right]: [&[[f64; 3]]; 2],
    closed: bool,
    thickness: f64,
    spacing: f64,
    places: &mut Places,
    visit: &mut dyn FnMut(Sample),
) {
    let [along, other] = [left, right].map(|line| directions(line, closed));
    let normal = |directions: &[[f64; 3]], i: usize| {
        let normal = cross(directions[i], sub(right[i], left[i]));
        let size = norm(normal);
        scale(normal, if size > 0.0 { 1.0 / size } else { 0.0 })
    };
    let layers = steps(thickness, spacing);
    let depth = thickness / layers as f64;
    for layer in 0..layers {
        let height = thickness * ((layer as f64 + 0.5) / layers as f64 - 0.5);
        let shifted = |line: &[[f64; 3]], directions: &[[f64; 3]]| -> Vec<[f64; 3]> {
            let points = line.iter().enumerate();
            let shift = |(i, &p)| add(p, scale(normal(directions, i), height));
            points.map(shift).collect()
        };
        let (l, r) = (shifted(left, &along), shifted(right, &other));
        for (l, r) in l.windows(2).zip(r.windows(2)) {
            quad(l, r, depth, spacing, places, visit);
        }
    }
}

/// One piece of a layer of a sheet.
fn quad(
    l: &[[f64; 3]],
    r: &[[f64; 3]],
    depth: f64,
    spacing: f64,
    places: &mut Places,
    visit: &mut dyn FnMut(Sample),
) {
    let long = norm(sub(l[1], l[0])).max(norm(sub(r[1], r[0])));
    let wide = norm(sub(r[0], l[0])).max(norm(sub(r[1], l[1])));
    let (pieces, rows) = (steps(long, spacing), steps(wide, spacing));
    let size = [1.0 / pieces as f64, 1.0 / rows as f64];
    for cell in 0..pieces * rows {
        let at = [(cell / rows) as f64, (cell % rows) as f64];
        let surface = |place: [f64; 2]| {
            let [u, v]: [f64; 2] = std::array::from_fn(|i| (at[i] + place[i]) * size[i]);
            let way = mix(sub(l[1], l[0]), sub(r[1], r[0]), v);
            let across = mix(sub(r[0], l[0]), sub(r[1], l[1]), u);
            let middle = mix(mix(l[0], l[1], u), mix(r[0], r[1], u), v);
            (middle, way, cross(way, across))
        };
        let [u, v, w] = places.next();
        let (middle, way, normal) = surface([u, v]);
        let area = norm(surface([0.5; 2]).2);
        if area > 0.0 && norm(normal) > 0.0 {
            let height = depth * (w - 0.5) / norm(normal);
            visit(Sample {
                position: add(middle, scale(normal, height)),
                tangent: unit(way),
                volume: area * depth * size[0] * size[1],
            });
        }
    }
}

/// The two sides of a strap.
fn sides(line: &[[f64; 3]], width: f64, normal: [f64; 3], closed: bool) -> [Vec<[f64; 3]>; 2] {
    let directions = directions(line, closed);
    let last = line.len() - 2;
    let across = |i: usize| {
        let half = unit(cross(normal, directions[i]));
        let piece = i.min(last);
        let beside = unit(cross(normal, sub(line[piece + 1], line[piece])));
        // Mitred, so that the width holds on both pieces.
        scale(half, 0.5 * width / dot(half, beside).max(0.3))
    };
    let side = |sign: f64| {
        let points = line.iter().enumerate();
        points
            .map(|(i, &p)| add(p, scale(across(i), sign)))
            .collect()
    };
    [side(-1.0), side(1.0)]
}

/// The lines with as many points each: as given where they have, at equal shares of their lengths
/// otherwise.
fn paired(lines: &[Vec<[f64; 3]>]) -> Vec<Vec<[f64; 3]>> {
    let most = lines.iter().map(Vec::len).max().unwrap_or(0);
    if lines.iter().all(|line| line.len() == most) {
        return lines.to_vec();
    }
    let even = |line: &Vec<[f64; 3]>| even(line, 4 * most);
    lines.iter().map(even).collect()
}

/// `count` + 1 points at equal distances along a line.
fn even(line: &[[f64; 3]], count: usize) -> Vec<[f64; 3]> {
    let mut way = vec![0.0];
    for ends in line.windows(2) {
        way.push(way[way.len() - 1] + norm(sub(ends[1], ends[0])));
    }
    let whole = way[way.len() - 1];
    let point = |k: usize| {
        let at = whole * k as f64 / count as f64;
        let piece = way.partition_point(|&w| w < at).clamp(1, line.len() - 1);
        let share = (at - way[piece - 1]) / (way[piece] - way[piece - 1]);
        mix(line[piece - 1], line[piece], share)
    };
    (0..=count).map(point).collect()
}

/// A direction across the start of a line that turns with it: toward its first bend.
fn start_across(line: &[[f64; 3]]) -> [f64; 3] {
    let tangent = unit(sub(line[1], line[0]));
    let bends = line[2..].iter().map(|&p| {
        let way = sub(p, line[0]);
        sub(way, scale(tangent, dot(way, tangent)))
    });
    let size = norm(sub(line[line.len() - 1], line[0])).max(norm(sub(line[1], line[0])));
    bends
        .into_iter()
        .find(|bend| norm(*bend) > 1e-6 * size)
        .map_or_else(|| any_across(tangent), unit)
}

fn any_across(tangent: [f64; 3]) -> [f64; 3] {
    let least = (0..3).min_by(|&i, &j| tangent[i].abs().total_cmp(&tangent[j].abs()));
    let mut axis = [0.0; 3];
    axis[least.unwrap_or(0)] = 1.0;
    unit(cross(tangent, axis))
}
