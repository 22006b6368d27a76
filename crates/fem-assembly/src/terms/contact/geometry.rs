//! Points, triangles and segments in space.

pub(crate) type Point = [f64; 3];

pub(crate) fn add(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] + b[i])
}
pub(crate) fn sub(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}
pub(crate) fn scale(a: Point, s: f64) -> Point {
    a.map(|c| s * c)
}
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
pub(crate) fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
pub(crate) fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}
/// a/|a|; 0 stays 0.
pub(crate) fn unit(a: Point) -> Point {
    let length = norm(a);
    if length > 0.0 {
        scale(a, 1.0 / length)
    } else {
        [0.0; 3]
    }
}

/// The point of a triangle nearest to p (Ericson 2005, "Real-Time Collision Detection", 5.1.5).
pub(crate) fn nearest_on_triangle(p: Point, [a, b, c]: [Point; 3]) -> Point {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return add(a, scale(ab, d1 / (d1 - d3)));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return add(a, scale(ac, d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return add(b, scale(sub(c, b), t));
    }
    let sum = 1.0 / (va + vb + vc);
    add(a, add(scale(ab, vb * sum), scale(ac, vc * sum)))
}

/// Distance of two segments (Ericson 2005, 5.1.9).
pub(crate) fn segment_distance([p1, q1]: [Point; 2], [p2, q2]: [Point; 2]) -> f64 {
    let (d1, d2, r) = (sub(q1, p1), sub(q2, p2), sub(p1, p2));
    let (a, e, f) = (dot(d1, d1), dot(d2, d2), dot(d2, r));
    let (b, c) = (dot(d1, d2), dot(d1, r));
    let denominator = a * e - b * b;
    let mut s = if denominator > 0.0 {
        ((b * f - c * e) / denominator).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut t = (b * s + f) / e;
    if t < 0.0 {
        (s, t) = ((-c / a).clamp(0.0, 1.0), 0.0);
    } else if t > 1.0 {
        (s, t) = (((b - c) / a).clamp(0.0, 1.0), 1.0);
    }
    norm(sub(add(p1, scale(d1, s)), add(p2, scale(d2, t))))
}

/// The solid angle of a triangle seen from p, positive from behind (Van Oosterom & Strackee 1983).
pub(crate) fn solid_angle(p: Point, corners: [Point; 3]) -> f64 {
    let [a, b, c] = corners.map(|x| sub(x, p));
    let (la, lb, lc) = (norm(a), norm(b), norm(c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * dot(a, cross(b, c)).atan2(below)
}

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub low: Point,
    pub high: Point,
}

impl Aabb {
    pub fn around(points: impl IntoIterator<Item = Point>) -> Self {
        let none = Self {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        };
        points
            .into_iter()
            .fold(none, |b, p| b.joined(&Self { low: p, high: p }))
    }
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
        }
    }
    pub fn grown(&self, by: f64) -> Self {
        Self {
            low: self.low.map(|c| c - by),
            high: self.high.map(|c| c + by),
        }
    }
    pub fn center(&self) -> Point {
        scale(add(self.low, self.high), 0.5)
    }
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }
}
