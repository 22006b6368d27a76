//! A solid bounded by triangles: what is inside, and how far its surface is.

use super::geometry::{
    Aabb, Point, add, cross, dot, nearest_on_triangle, norm, scale, solid_angle, sub,
};
use super::tree::BoxTree;
use fem_solvers::parallel::map;
use std::collections::BTreeMap;

/// How many radii away a cluster of triangles is seen as one.
const FAR: f64 = 2.5;

/// Triangles seen counter-clockwise from outside, or all of them from inside. They may overlap, and
/// their surface may have holes, which are closed by fans around their rims' centers.
pub(crate) struct Solid {
    corners: Vec<[Point; 3]>,
    tree: BoxTree,
    clusters: Vec<Cluster>,
}

/// The triangles of a node of the tree, seen from afar.
struct Cluster {
    center: Point,
    /// Sum of the area vectors, m².
    area: Point,
    radius: f64,
}

impl Solid {
    /// Every index must exist.
    pub fn new(points: &[Point], triangles: &[[u32; 3]]) -> Self {
        let place = |t: &[u32; 3]| t.map(|n| points[n as usize]);
        let mut corners: Vec<[Point; 3]> = triangles.iter().map(place).collect();
        corners.extend(lids(points, triangles));
        let volume: f64 = corners.iter().map(|[a, b, c]| dot(*a, cross(*b, *c))).sum();
        if volume < 0.0 {
            corners.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Self::of(corners)
    }

    fn of(corners: Vec<[Point; 3]>) -> Self {
        let boxes: Vec<Aabb> = corners.iter().map(|t| Aabb::around(*t)).collect();
        let tree = BoxTree::new(&boxes);
        let cluster = |index: usize| {
            let node = &tree.nodes[index];
            let items = &tree.order[node.start as usize..node.end as usize];
            let (mut area, mut center, mut total) = ([0.0; 3], [0.0; 3], 0.0);
            for &k in items {
                let [a, b, c] = corners[k as usize];
                let vector = scale(cross(sub(b, a), sub(c, a)), 0.5);
                let size = norm(vector);
                area = add(area, vector);
                center = add(center, scale(add(a, add(b, c)), size / 3.0));
                total += size;
            }
            let center = if total > 0.0 {
                scale(center, 1.0 / total)
            } else {
                node.around.center()
            };
            let from = |p: &Point| norm(sub(*p, center));
            let places = items.iter().flat_map(|&k| &corners[k as usize]);
            let radius = places.map(from).fold(0.0, f64::max);
            Cluster {
                center,
                area,
                radius,
            }
        };
        let clusters = (0..tree.nodes.len()).map(cluster).collect();
        Self {
            corners,
            tree,
            clusters,
        }
    }

    /// The triangles that separate inside and outside; those deep in another part of the solid are
    /// left out. `beside` is how far beside a triangle is looked.
    pub fn outer(&self, beside: f64) -> Self {
        let seen = |[a, b, c]: &[Point; 3]| {
            let normal = cross(sub(*b, *a), sub(*c, *a));
            let out = scale(normal, beside / norm(normal));
            let center = scale(add(*a, add(*b, *c)), 1.0 / 3.0);
            // Part of a triangle may be outside: its corners are looked at, too.
            let nearly = |p: Point| add(scale(p, 0.95), scale(center, 0.05));
            let places = [center, nearly(*a), nearly(*b), nearly(*c)];
            // Triangles without area have no sides.
            let buried = |p: &Point| self.winding(add(*p, out)) > 0.5;
            !places.iter().all(buried)
        };
        let kept: Vec<bool> = map(self.corners.iter().collect(), seen);
        let pairs = self.corners.iter().zip(kept);
        Self::of(pairs.filter_map(|(t, kept)| kept.then_some(*t)).collect())
    }

    /// Does it have as many triangles?
    pub fn is_as_large_as(&self, other: &Self) -> bool {
        self.corners.len() == other.corners.len()
    }

    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.corners.iter().flatten().copied())
    }

    /// How often the surface goes round a point: about 1 inside and 0 outside (Jacobson, Kavan &
    /// Sorkine-Hornung 2013; clusters far away count as dipoles: Barill et al. 2018).
    pub fn winding(&self, p: Point) -> f64 {
        let mut angle = 0.0;
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let (Some(node), Some(cluster)) =
                (self.tree.nodes.get(index), self.clusters.get(index))
            else {
                continue;
            };
            let way = sub(cluster.center, p);
            let distance = norm(way);
            if distance > FAR * cluster.radius {
                angle += dot(cluster.area, way) / (distance * distance * distance);
            } else if node.right == 0 {
                let items = &self.tree.order[node.start as usize..node.end as usize];
                let of = |&k: &u32| solid_angle(p, self.corners[k as usize]);
                angle += items.iter().map(of).sum::<f64>();
            } else {
                open.extend([node.right as usize, index + 1]);
            }
        }
        angle / (4.0 * std::f64::consts::PI)
    }

    /// Distance to the nearest triangle, meters, where that is below `bound`: triangles farther away
    /// need no look; else `bound`.
    pub fn distance_below(&self, p: Point, bound: f64) -> f64 {
        let mut best = bound * bound;
        let mut open = vec![(0, 0.0)];
        while let Some((index, least)) = open.pop() {
            let Some(node) = self.tree.nodes.get(index) else {
                continue;
            };
            if least >= best {
                continue;
            }
            if node.right == 0 {
                let items = &self.tree.order[node.start as usize..node.end as usize];
                for &k in items {
                    let nearest = nearest_on_triangle(p, self.corners[k as usize]);
                    let way = sub(p, nearest);
                    best = best.min(dot(way, way));
                }
                continue;
            }
            let child = |k: usize| (k, square_to_box(p, &self.tree.nodes[k].around));
            let (left, right) = (child(index + 1), child(node.right as usize));
            // The nearer one is looked at first.
            open.extend(if left.1 <= right.1 {
                [right, left]
            } else {
                [left, right]
            });
        }
        best.sqrt()
    }
}

fn square_to_box(p: Point, around: &Aabb) -> f64 {
    let beyond = |i: usize| (around.low[i] - p[i]).max(p[i] - around.high[i]).max(0.0);
    (0..3).map(|i| beyond(i) * beyond(i)).sum()
}

/// A fan for each hole of the surface.
fn lids(points: &[Point], triangles: &[[u32; 3]]) -> Vec<[Point; 3]> {
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut open: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b] in triangles.iter().flat_map(sides) {
        match open.get_mut(&[b, a]) {
            Some(1) => {
                open.remove(&[b, a]);
            }
            Some(count) => *count -= 1,
            None => *open.entry([a, b]).or_default() += 1,
        }
    }
    let mut next: BTreeMap<u32, u32> = open.into_keys().map(|[a, b]| (a, b)).collect();
    let mut fans = Vec::new();
    while let Some((first, second)) = next.pop_first() {
        let mut rim = vec![first, second];
        while let Some(node) = rim.last().and_then(|last| next.remove(last)) {
            rim.push(node);
        }
        let sum = rim[1..]
            .iter()
            .fold([0.0; 3], |s, &n| add(s, points[n as usize]));
        let center = scale(sum, 1.0 / (rim.len() - 1) as f64);
        let fan = |w: &[u32]| [points[w[1] as usize], points[w[0] as usize], center];
        fans.extend(rim.windows(2).map(fan));
    }
    fans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::kuhn_grid;

    /// The surface of [0, 1]³ without the triangles at its top.
    fn open_box() -> (Vec<Point>, Vec<[u32; 3]>) {
        let mesh = kuhn_grid(3, 3, 3, [1.0; 3]).unwrap();
        let points = mesh.nodes().to_vec();
        let top = |t: &[u32; 3]| t.iter().all(|&n| points[n as usize][2] == 1.0);
        let faces = mesh.boundary().faces.into_iter();
        let rest = faces.filter(|t| !top(t)).collect();
        (points, rest)
    }

    fn distance(solid: &Solid, p: Point) -> f64 {
        let unbounded = solid.distance_below(p, f64::INFINITY);
        // A bound changes nothing.
        assert_eq!(solid.distance_below(p, 1.01 * unbounded), unbounded);
        assert_eq!(solid.distance_below(p, 0.5 * unbounded), 0.5 * unbounded);
        unbounded
    }

    #[test]
    fn a_hole_is_closed_and_turned_triangles_bound_the_same_solid() {
        let (points, triangles) = open_box();
        let turned: Vec<_> = triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
        for triangles in [triangles, turned] {
            let solid = Solid::new(&points, &triangles);
            for (p, inside, distance) in [
                ([0.5, 0.4, 0.9], true, 0.1),
                ([0.5, 0.4, 1.2], false, 0.2),
                ([0.9, 0.4, 0.5], true, 0.1),
                ([1.3, 1.4, 0.5], false, 0.5),
            ] {
                let winding = solid.winding(p);
                assert!(
                    (winding - f64::from(u8::from(inside))).abs() < 0.02,
                    "{p:?}: {winding}"
                );
                assert!(
                    (self::distance(&solid, p) - distance).abs() < 1e-12,
                    "{p:?}"
                );
            }
        }
    }

    #[test]
    fn parts_inside_others_are_no_surface() {
        let mesh = kuhn_grid(4, 4, 4, [1.0; 3]).unwrap();
        let small = mesh.nodes().iter().map(|p| p.map(|c| 0.4 + 0.2 * c));
        let points: Vec<Point> = mesh.nodes().iter().copied().chain(small).collect();
        let faces = mesh.boundary().faces;
        let inner = faces.iter().map(|t| t.map(|n| n + mesh.num_nodes() as u32));
        let triangles: Vec<_> = faces.iter().copied().chain(inner).collect();
        let outer = Solid::new(&points, &triangles).outer(1e-3);
        assert_eq!(outer.corners.len(), faces.len());
        assert!((distance(&outer, [0.5; 3]) - 0.5).abs() < 1e-12);
    }
}
