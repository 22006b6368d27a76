//! Where a surface passes through itself.

use std::collections::BTreeSet;

type Point = [f64; 3];

/// The triangles that another one of the same surface crosses, ascending. Triangles that share an edge
/// do not cross, of two that share a corner the sides opposite to it are looked at; triangles in one
/// plane do not count. One with a corner that is not finite, or too far away for products of three
/// lengths, is taken to cross.
///
/// Boxes are sorted along the axis on which the surface is longest, so that about as many pairs are looked
/// at as overlap along it.
pub fn crossing_triangles(points: &[Point], triangles: &[[u32; 3]]) -> Vec<u32> {
    let nowhere = [f64::NAN; 3];
    let at = |n: u32| points.get(n as usize).copied().unwrap_or(nowhere);
    let corners: Vec<[Point; 3]> = triangles.iter().map(|t| t.map(at)).collect();
    let mut crossing = BTreeSet::new();
    let mut boxes = Vec::with_capacity(triangles.len());
    for (k, t) in (0..).zip(&corners) {
        if t.as_flattened().iter().all(|x| x.is_finite()) {
            boxes.push((k, bounds(t)));
        } else {
            crossing.insert(k);
        }
    }
    let axis = longest(boxes.iter().map(|(_, around)| around));
    boxes.sort_by(|a, b| a.1[0][axis].total_cmp(&b.1[0][axis]).then(a.0.cmp(&b.0)));
    for (first, (a, [low, high])) in boxes.iter().enumerate() {
        let later = boxes[first + 1..].iter();
        for (b, [from, to]) in later.take_while(|(_, [from, _])| from[axis] <= high[axis]) {
            if (0..3).all(|i| from[i] <= high[i] && low[i] <= to[i])
                && cross(
                    [triangles[*a as usize], triangles[*b as usize]],
                    [&corners[*a as usize], &corners[*b as usize]],
                )
            {
                crossing.extend([*a, *b]);
            }
        }
    }
    crossing.into_iter().collect()
}

/// The axis along which boxes reach farthest.
fn longest<'a>(boxes: impl Iterator<Item = &'a [Point; 2]>) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for [from, to] in boxes {
        for i in 0..3 {
            low[i] = low[i].min(from[i]);
            high[i] = high[i].max(to[i]);
        }
    }
    let reach = |i: &usize| high[*i] - low[*i];
    (0..3)
        .max_by(|a, b| reach(a).total_cmp(&reach(b)))
        .unwrap_or(0)
}

fn bounds(t: &[Point; 3]) -> [Point; 2] {
    let [a, b, c] = *t;
    let pick = |f: fn(f64, f64) -> f64| std::array::from_fn(|i| f(f(a[i], b[i]), c[i]));
    [pick(f64::min), pick(f64::max)]
}

/// Does a side of one that has no corner in common with the other pass through it?
fn cross(names: [[u32; 3]; 2], corners: [&[Point; 3]; 2]) -> bool {
    let shared = names[0].iter().filter(|n| names[1].contains(n)).count();
    if shared > 1 {
        return false;
    }
    let through = |of: usize| {
        let other = 1 - of;
        (0..3).any(|k| {
            let (from, to) = (k, (k + 1) % 3);
            let apart = |n: usize| !names[other].contains(&names[of][n]);
            apart(from) && apart(to) && passes(corners[of][from], corners[of][to], corners[other])
        })
    };
    through(0) || through(1)
}

/// Does the segment from `p` to `q` pass through the inside of a triangle?
fn passes(p: Point, q: Point, [a, b, c]: &[Point; 3]) -> bool {
    let (before, behind) = (volume(*a, *b, *c, p), volume(*a, *b, *c, q));
    if before.is_nan() || behind.is_nan() {
        return true;
    }
    if !(before.signum() * behind.signum() < 0.0) || before == 0.0 || behind == 0.0 {
        return false;
    }
    let around = [
        volume(p, q, *a, *b),
        volume(p, q, *b, *c),
        volume(p, q, *c, *a),
    ];
    around.iter().all(|v| *v > 0.0) || around.iter().all(|v| *v < 0.0)
}

/// Six times the signed volume of a tetrahedron.
fn volume(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let from = |x: Point| -> Point { std::array::from_fn(|i| x[i] - a[i]) };
    let [u, v, w] = [from(b), from(c), from(d)];
    u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles across each other, a third one beside them.
    fn blades() -> (Vec<Point>, Vec<[u32; 3]>) {
        let points = vec![
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.5, 0.5, -1.0],
            [0.5, 0.5, 1.0],
            [3.0, 3.0, 0.0],
            [2.0, 2.0, 0.0],
        ];
        (points, vec![[0, 1, 2], [3, 4, 5], [1, 6, 2]])
    }

    #[test]
    fn blades_cross_and_neighbors_do_not() {
        let (mut points, triangles) = blades();
        assert_eq!(crossing_triangles(&points, &triangles), [0, 1, 2]);
        // Beside the first, through the second alone.
        points[3] = [1.5, 1.5, -1.0];
        points[4] = [1.5, 1.5, 1.0];
        assert_eq!(crossing_triangles(&points, &triangles), [1, 2]);
        points[3][2] = 0.5;
        points[5][2] = 0.5;
        assert_eq!(crossing_triangles(&points, &triangles), [0_u32; 0]);
    }

    #[test]
    fn a_corner_in_common_does_not_hide_a_crossing() {
        let (points, _) = blades();
        // The side (3, 4) of the second passes through the first; corner 1 is theirs both.
        assert_eq!(crossing_triangles(&points, &[[0, 1, 2], [1, 3, 4]]), [0, 1]);
        // Folded over along an edge.
        assert_eq!(
            crossing_triangles(&points, &[[0, 1, 2], [1, 2, 3]]),
            [0_u32; 0]
        );
    }

    /// Whichever way it lies, and scaled to the end of what numbers hold.
    #[test]
    fn no_axis_is_special() {
        let (points, triangles) = blades();
        for turn in 0..3 {
            for scale in [1.0, 1e-90, 1e90] {
                let turned = |p: &Point| std::array::from_fn(|i| scale * p[(i + turn) % 3]);
                let turned: Vec<Point> = points.iter().map(turned).collect();
                assert_eq!(crossing_triangles(&turned, &triangles), [0, 1, 2]);
            }
        }
    }

    #[test]
    fn a_place_that_is_none_crosses() {
        let (mut points, triangles) = blades();
        points[5][1] = f64::NAN;
        assert_eq!(crossing_triangles(&points, &triangles), [1]);
        assert_eq!(crossing_triangles(&points, &[[0, 1, 9]]), [0]);
        points[5] = [3.0, 3.0, 0.0];
        let far: Vec<Point> = points.iter().map(|p| p.map(|x| 1e200 * x)).collect();
        assert_eq!(crossing_triangles(&far, &[[0, 1, 2], [1, 3, 4]]), [0, 1]);
    }
}
