//! What closes the holes of a surface: where the surface, without them, goes round a half.

use super::geometry::{Point, add, cross, dot, norm, scale, sub, unit};
use fem_solvers::parallel::map;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Most points along all rims that tell a level (but for the fewest of a rim), most points of a ring, and
/// most rings of a lid: a rim of tens of thousands of edges takes seconds, not hours.
const MOST_ALONG: usize = 1024;
const FEWEST_OF_A_RIM: usize = 16;
const MOST_AROUND: usize = 256;
const MOST_RINGS: f64 = 32.0;
/// How far a level may be from a fan, in radii of the rim: the level of another rim is no lid of this one.
const FARTHEST: f64 = 0.5;
/// Newton steps of a point towards its level, and the part of a turn that is near enough.
const MOST_STEPS: usize = 30;
const LEVEL: f64 = 1e-9;

/// Lids for all holes of a surface, in triangles of about `size` meters. They lie where the surface without
/// lids goes round a half, as far as `size` resolves: what a winding number above a half calls inside of
/// the open surface is inside of the closed one. Around a plane hole that is its plane.
///
/// A hole that is not wider than twice `size` has a fan around its center, and so has one whose half level
/// is no lid of its own: that of a short tube that is open at both ends is a ring from rim to rim.
pub(super) fn lids(points: &[Point], triangles: &[[u32; 3]], size: f64) -> Vec<[Point; 3]> {
    let rims = rims(points, triangles);
    let rims: Vec<Rim> = rims.into_iter().map(|rim| rim.divided(size)).collect();
    let along: usize = rims.iter().map(|rim| rim.0.len()).sum();
    let told_by = |rim: &Rim| {
        let most = (rim.0.len() / FEWEST_OF_A_RIM).max(1);
        rim.thinned(along.div_ceil(MOST_ALONG).min(most))
    };
    let coarse: Vec<Rim> = rims.iter().map(told_by).collect();
    let lid = |rim: &Rim| {
        let most = FARTHEST * rim.radius();
        let level = |p: Point| onto_level(&coarse, p, size, most);
        rim.lid(size, level).unwrap_or_else(|| rim.fan())
    };
    rims.iter().flat_map(lid).collect()
}

/// A closed way along the open edges of a surface, first point not repeated.
struct Rim(Vec<Point>);

impl Rim {
    fn edges(&self) -> impl Iterator<Item = [Point; 2]> {
        let next = self.0.iter().cycle().skip(1);
        self.0.iter().zip(next).map(|(&a, &b)| [a, b])
    }
    fn center(&self) -> Point {
        let sum = self.0.iter().fold([0.0; 3], |s, &p| add(s, p));
        scale(sum, 1.0 / self.0.len() as f64)
    }
    fn radius(&self) -> f64 {
        let center = self.center();
        let off = self.0.iter().map(|&p| norm(sub(p, center)));
        off.fold(0.0, f64::max)
    }
    fn fan(&self) -> Vec<[Point; 3]> {
        let center = self.center();
        self.edges().map(|[a, b]| [b, a, center]).collect()
    }
    /// No edge is longer than `size`, but for rims that would have more than so many points then.
    fn divided(self, size: f64) -> Self {
        let length: f64 = self.edges().map(|[a, b]| norm(sub(b, a))).sum();
        let size = size.max(length / MOST_ALONG as f64);
        let parts = |[a, b]: [Point; 2]| {
            let count = (norm(sub(b, a)) / size).ceil().max(1.0);
            let at = move |k: usize| add(a, scale(sub(b, a), k as f64 / count));
            (0..count as usize).map(at)
        };
        Self(self.edges().flat_map(parts).collect())
    }
    fn thinned(&self, stride: usize) -> Self {
        Self(self.0.iter().copied().step_by(stride).collect())
    }
    /// Rings around the center, each of whose points is taken to `level`, and what joins them to the rim;
    /// seen from the side that the surface's triangles show. `None` for a rim too small for a ring, or
    /// with a point that has no level.
    fn lid(
        &self,
        size: f64,
        level: impl Fn(Point) -> Option<Point> + Sync,
    ) -> Option<Vec<[Point; 3]>> {
        let (rim, center) = (&self.0, self.center());
        let rings = (self.radius() / size).ceil().clamp(1.0, MOST_RINGS) as usize;
        if rings == 1 {
            return None;
        }
        let around: Vec<usize> = (0..rim.len())
            .step_by(rim.len().div_ceil(MOST_AROUND))
            .collect();
        let ring = |k: usize| -> Option<Vec<Point>> {
            let share = k as f64 / rings as f64;
            let inner = |&n: &usize| add(center, scale(sub(rim[n], center), share));
            map(around.iter().map(inner).collect(), &level)
        };
        let mut triangles = Vec::new();
        let mut inside = ring(1)?;
        let apex = level(center)?;
        let next = |i: usize| (i + 1) % around.len();
        triangles.extend((0..around.len()).map(|i| [inside[next(i)], inside[i], apex]));
        for outside in (2..rings).map(ring) {
            let outside = outside?;
            for i in 0..around.len() {
                let j = next(i);
                triangles.push([outside[j], outside[i], inside[i]]);
                triangles.push([outside[j], inside[i], inside[j]]);
            }
            inside = outside;
        }
        for (i, &first) in around.iter().enumerate() {
            let end = around.get(i + 1).map_or(rim.len(), |&n| n);
            let edges = (first..end).map(|n| [rim[(n + 1) % rim.len()], rim[n], inside[i]]);
            triangles.extend(edges);
            triangles.push([rim[end % rim.len()], inside[i], inside[next(i)]]);
        }
        Some(triangles)
    }
}

/// The open edges of a surface, joined to rims.
fn rims(points: &[Point], triangles: &[[u32; 3]]) -> Vec<Rim> {
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut open: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b] in triangles.iter().flat_map(sides) {
        match open.get_mut(&[b, a]) {
            Some(1) => {
                open.remove(&[b, a]);
            }
            Some(count) => *count -= 1,
            None if a == b => {}
            None => *open.entry([a, b]).or_default() += 1,
        }
    }
    // As many lead to a node as from it, so that every walk comes back to its start.
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for ([a, b], count) in open {
        next.entry(a).or_default().extend(vec![b; count]);
    }
    let starts: Vec<u32> = next.keys().copied().collect();
    let mut follow = |node: u32| {
        let ways = next.get_mut(&node)?;
        let way = ways.pop();
        if ways.is_empty() {
            next.remove(&node);
        }
        way
    };
    let mut rims: Vec<Vec<u32>> = Vec::new();
    for first in starts {
        while let Some(second) = follow(first) {
            let mut rim = vec![first];
            let mut last = second;
            while last != first {
                // A way that crosses itself there is two rims.
                if let Some(met) = rim.iter().position(|&n| n == last) {
                    rims.push(rim.drain(met..).collect());
                }
                rim.push(last);
                let Some(node) = follow(last) else {
                    break;
                };
                last = node;
            }
            rims.push(rim);
        }
    }
    let place = |&n: &u32| points[n as usize];
    let rim = |nodes: Vec<u32>| Rim(nodes.iter().map(place).collect());
    rims.into_iter().map(rim).collect()
}

/// The point of the half level that Newton's method finds from p, along the gradient of the level, not
/// farther than `most` away.
fn onto_level(rims: &[Rim], p: Point, size: f64, most: f64) -> Option<Point> {
    let mut at = p;
    for _ in 0..MOST_STEPS {
        let (off, gradient) = turns(rims, at);
        if off.abs() < LEVEL {
            return Some(at);
        }
        let step = scale(gradient, -off / dot(gradient, gradient));
        // Near a rim the level is steep and bent.
        let length = norm(step);
        at = add(at, scale(step, (size / length).min(1.0)));
        if !(norm(sub(at, p)) <= most) {
            return None;
        }
    }
    None
}

/// By how much the turns of a surface with these rims around p differ from a half and a whole number,
/// and the gradient of that, 1/m.
///
/// The turns are a solid angle over 4π, which the rims alone tell but for whole numbers: the sum of
/// spherical triangles over their edges with any direction as the third corner. Its gradient is the
/// field of a current along them (Biot and Savart).
fn turns(rims: &[Rim], p: Point) -> (f64, Point) {
    let (mut angle, mut gradient) = (0.0, [0.0; 3]);
    for rim in rims {
        let edges = || rim.edges().map(|e| e.map(|x| sub(x, p)));
        let area = edges().fold([0.0; 3], |s, [a, b]| add(s, cross(a, b)));
        let third = unit(area);
        for [a, b] in edges() {
            let (u, v, turn) = (unit(a), unit(b), cross(a, b));
            let below = 1.0 + dot(third, u) + dot(u, v) + dot(v, third);
            angle += 2.0 * dot(third, cross(u, v)).atan2(below);
            let (la, lb) = (norm(a), norm(b));
            let field = (la + lb) / (la * lb * (la * lb + dot(a, b)));
            gradient = add(gradient, scale(turn, field));
        }
    }
    let turns = angle / (4.0 * PI) - 0.5;
    (turns - turns.round(), scale(gradient, 0.25 / PI))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saddle() -> Rim {
        let at = |k: usize| {
            let angle = 2.0 * PI * k as f64 / 40.0;
            [angle.cos(), 0.7 * angle.sin(), 0.3 * (2.0 * angle).cos()]
        };
        Rim((0..40).map(at).collect())
    }

    #[test]
    fn the_gradient_of_turns_is_their_slope() {
        let rims = [saddle()];
        for p in [[0.1, 0.2, 0.05], [0.4, -0.3, -0.2], [0.0, 0.1, 0.9]] {
            let (_, gradient) = turns(&rims, p);
            for i in 0..3 {
                let at = |h: f64| {
                    turns(
                        &rims,
                        std::array::from_fn(|k| p[k] + if k == i { h } else { 0.0 }),
                    )
                    .0
                };
                let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
                assert!(
                    (slope - gradient[i]).abs() < 1e-8,
                    "{p:?}: {slope} {gradient:?}"
                );
            }
        }
    }

    /// Two triangles that share a corner, and one with a side of no length, which is a line.
    #[test]
    fn rims_part_where_they_meet() {
        let at = |k: u32| [f64::from(k), f64::from(k * k), 0.0];
        let points: Vec<Point> = (0..5).map(at).collect();
        let found = rims(&points, &[[2, 0, 1], [2, 3, 4], [0, 0, 3]]);
        let lengths: Vec<usize> = found.iter().map(|rim| rim.0.len()).collect();
        assert_eq!(lengths, [3, 3]);
    }

    /// Of a tube that is shorter than wide no point of the axis sees half of what is around it.
    #[test]
    fn a_short_tube_has_plane_lids() {
        let at = |k: u32| {
            let angle = 2.0 * PI * f64::from(k % 40) / 40.0;
            [angle.cos(), angle.sin(), f64::from(k / 40)]
        };
        let points: Vec<Point> = (0..80).map(at).collect();
        let side = |k: u32| {
            let (a, b) = (k, (k + 1) % 40);
            [[a, b, b + 40], [a, b + 40, a + 40]]
        };
        let triangles: Vec<[u32; 3]> = (0..40).flat_map(side).collect();
        let lid = lids(&points, &triangles, 0.1);
        assert!(lid.iter().flatten().all(|p| p[2] == 0.0 || p[2] == 1.0));
        // Those of a long one bend inwards, for its other end is open.
        let long: Vec<Point> = points.iter().map(|p| [p[0], p[1], 4.0 * p[2]]).collect();
        let lid = lids(&long, &triangles, 0.1);
        let depth = |p: &Point| p[2].min(4.0 - p[2]);
        let depths: Vec<f64> = lid.iter().flatten().map(depth).collect();
        assert!(depths.iter().all(|d| (0.0..0.2).contains(d)), "{depths:?}");
        assert!(depths.iter().any(|d| *d > 0.02));
    }

    /// A cone with a thousand edges around its mouth: a lid of a few hundred points to a ring leaves no gap.
    #[test]
    fn a_lid_closes_every_edge() {
        let at = |k: u32| {
            let angle = 2.0 * PI * f64::from(k) / 1000.0;
            [angle.cos(), angle.sin(), 0.2 * (3.0 * angle).sin()]
        };
        let mut points: Vec<Point> = (0..1000).map(at).collect();
        points.push([0.0, 0.0, -1.0]);
        let side = |k: u32| [k, (k + 1) % 1000, 1000];
        let mut triangles: Vec<[u32; 3]> = (0..1000).map(side).collect();
        assert_eq!(rims(&points, &triangles).len(), 1);
        for size in [0.2, f64::INFINITY] {
            let lid = lids(&points, &triangles, size);
            let (mut points, mut closed) = (points.clone(), triangles.clone());
            for corners in lid {
                closed.push(corners.map(|c| {
                    let known = points.iter().position(|p| *p == c);
                    known.unwrap_or_else(|| {
                        points.push(c);
                        points.len() - 1
                    }) as u32
                }));
            }
            assert_eq!(rims(&points, &closed).len(), 0, "{size}");
        }
        triangles.clear();
        assert!(lids(&points, &triangles, 0.1).is_empty());
    }
}
