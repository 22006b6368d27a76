//! The way of a step, along which what is near was found.

use super::geometry::{Point, add, dot, norm, scale, sub};

/// Every vertex's place at the start, and its way from there.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    pub from: Vec<Point>,
    /// Empty where nothing moves.
    by: Vec<Point>,
}

impl Way {
    /// A place to stay.
    pub fn at(from: Vec<Point>) -> Self {
        Self {
            from,
            by: Vec::new(),
        }
    }

    /// Where a vertex begins and ends.
    pub fn ends(&self, vertex: u32) -> [Point; 2] {
        let from = self.from[vertex as usize];
        [from, add(from, self.of(vertex))]
    }

    /// As far along a step as none of the points moves by more than `longest`, meters.
    pub fn along(from: Vec<Point>, step: &[Point], points: &[u32], longest: f64) -> Self {
        let length = |&n: &u32| norm(step[n as usize]);
        let most = points.iter().map(length).fold(0.0, f64::max);
        let share = (longest / most).min(1.0);
        Self {
            from,
            by: step.iter().map(|&d| scale(d, share)).collect(),
        }
    }

    /// The way of a node.
    pub fn of(&self, node: u32) -> Point {
        self.by.get(node as usize).copied().unwrap_or([0.0; 3])
    }

    /// By how much the distance between two sets of vertices changes at most.
    pub fn change_between(&self, some: &[u32], others: &[u32]) -> f64 {
        let between = |&a: &u32| {
            let apart = |&b: &u32| norm(sub(self.of(a), self.of(b)));
            others.iter().map(apart).fold(0.0, f64::max)
        };
        some.iter().map(between).fold(0.0, f64::max)
    }

    /// The share of the way at which positions are, as well as a share says it.
    fn share(&self, positions: &[Point], points: &[u32]) -> f64 {
        let progress = |&n: &u32| {
            dot(
                sub(positions[n as usize], self.from[n as usize]),
                self.of(n),
            )
        };
        self.in_ways(points.iter().map(progress).sum(), points)
            .clamp(0.0, 1.0)
    }

    /// Over the square of the whole way; 0 where that is none.
    fn in_ways(&self, product: f64, points: &[u32]) -> f64 {
        let square: f64 = points.iter().map(|&n| dot(self.of(n), self.of(n))).sum();
        if square > 0.0 { product / square } else { 0.0 }
    }

    /// How far a node is from where it would be at this share of the way.
    fn off(&self, positions: &[Point], node: u32, share: f64) -> Point {
        let n = node as usize;
        sub(positions[n], add(self.from[n], scale(self.of(node), share)))
    }

    /// Are all points as near to one place of the way as that?
    pub fn holds(&self, positions: &[Point], points: &[u32], radius: f64) -> bool {
        let share = self.share(positions, points);
        let near = |&n: &u32| norm(self.off(positions, n, share)) <= radius;
        points.iter().all(near)
    }

    /// The t at which a step leaves the tube of this radius around the way, the same place of the way
    /// for all points; 0 from outside.
    pub fn left_after(
        &self,
        positions: &[Point],
        step: &[Point],
        points: &[u32],
        radius: f64,
    ) -> f64 {
        let share = self.share(positions, points);
        let advance = |&n: &u32| dot(step[n as usize], self.of(n));
        let speed = self
            .in_ways(points.iter().map(advance).sum(), points)
            .max(0.0);
        // With the way to its end, from there on alone.
        let end = if speed > 0.0 {
            (1.0 - share) / speed
        } else {
            0.0
        };
        let beside = |&n: &u32| sub(step[n as usize], scale(self.of(n), speed));
        let leaves = |n: &u32| leaves_ball(self.off(positions, *n, share), beside(n), radius);
        let first = points.iter().map(leaves).fold(f64::INFINITY, f64::min);
        if first <= end {
            return first;
        }
        let leaves = |n: &u32| {
            let off = add(self.off(positions, *n, share), scale(beside(n), end));
            leaves_ball(off, step[*n as usize], radius)
        };
        end + points.iter().map(leaves).fold(f64::INFINITY, f64::min)
    }
}

/// The t ≥ 0 at which from + t d has the given length; 0 when it is outside.
fn leaves_ball(from: Point, d: Point, radius: f64) -> f64 {
    let (a, b, c) = (dot(d, d), dot(from, d), dot(from, from) - radius * radius);
    if !(c < 0.0) {
        return 0.0;
    }
    if a > 0.0 {
        -c / (b + (b * b - a * c).sqrt())
    } else {
        f64::INFINITY
    }
}
