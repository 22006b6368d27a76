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

    /// The distance of no two of the points changes by more.
    pub fn most_between(&self, points: &[u32]) -> f64 {
        let length = |&n: &u32| norm(self.of(n));
        2.0 * points.iter().map(length).fold(0.0, f64::max)
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

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [u32; 3] = [0, 1, 2];
    const RADIUS: f64 = 0.1;

    fn wave(n: usize, phase: f64) -> Point {
        std::array::from_fn(|i| (7.3 * (3 * n + i) as f64 + phase).sin())
    }

    /// Whether some place of the way is within the radius of all points, by trying a thousand.
    fn is_near(way: &Way, x: &[Point]) -> bool {
        (0..=1000).any(|k| {
            let s = f64::from(k) / 1000.0;
            POINTS.iter().all(|&n| norm(way.off(x, n, s)) <= RADIUS)
        })
    }

    #[test]
    fn a_step_stays_in_the_tube_as_long_as_it_says() {
        let from: Vec<Point> = (0..3).map(|n| wave(n, 0.0)).collect();
        let by: Vec<Point> = (0..3).map(|n| wave(n, 1.0)).collect();
        let way = Way::along(from.clone(), &by, &POINTS, 10.0);
        for trial in 0..20 {
            let phase = f64::from(trial);
            let start: Vec<Point> = (0..3)
                .map(|n| {
                    let off = scale(wave(n, phase), 0.3 * RADIUS);
                    add(add(from[n], scale(by[n], 0.05 * phase)), off)
                })
                .collect();
            let turn = if trial % 2 == 0 { 0.2 } else { 1.0 };
            let step: Vec<Point> = (0..3)
                .map(|n| add(by[n], scale(wave(n, 2.0 + phase), turn)))
                .collect();
            let t = way.left_after(&start, &step, &POINTS, RADIUS);
            assert!(t > 0.0, "{trial}");
            for share in [0.3, 0.7, 0.99] {
                let x: Vec<Point> = (0..3)
                    .map(|n| add(start[n], scale(step[n], share * t)))
                    .collect();
                assert!(is_near(&way, &x), "{trial}: {share} of {t}");
            }
        }
        // The step for which it was made is covered, and what is left at its end beside it.
        let whole = way.left_after(&from, &by, &POINTS, RADIUS);
        let fastest = by.iter().map(|d| norm(*d)).fold(0.0, f64::max);
        assert!((whole - 1.0 - RADIUS / fastest).abs() < 1e-12, "{whole}");
        // Outside there is nothing to leave.
        let far: Vec<Point> = from.iter().map(|x| add(*x, [1.0, 0.0, 0.0])).collect();
        assert!(!way.holds(&far, &POINTS, RADIUS));
        assert_eq!(way.left_after(&far, &by, &POINTS, RADIUS), 0.0);
    }

    #[test]
    fn a_long_step_is_a_way_as_far_as_allowed() {
        let by = [[3.0, 0.0, 4.0]; 3];
        let way = Way::along(vec![[0.0; 3]; 3], &by, &POINTS, 0.5);
        assert!((norm(way.of(1)) - 0.5).abs() < 1e-15);
        assert_eq!(way.change_between(&[0], &[1, 2]), 0.0);
        assert_eq!(Way::at(vec![[0.0; 3]; 3]).of(2), [0.0; 3]);
    }
}
