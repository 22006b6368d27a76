//! A solid bounded by triangles: what is inside, and how far its surface is.

use super::geometry::{
    Aabb, Point, add, cross, dot, nearest_on_triangle, norm, scale, solid_angle, sub,
};
use super::lids::lids;
use super::tree::BoxTree;
use fem_solvers::parallel::map;

/// How many radii away a cluster of triangles is seen as one.
const FAR: f64 = 2.5;

/// Triangles seen counter-clockwise from outside, or all of them from inside. They may overlap, and
/// their surface may have holes, which are [closed](lids).
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
    /// Every index must exist. Holes are closed by triangles of about `size` meters.
    pub fn new(points: &[Point], triangles: &[[u32; 3]], size: f64) -> Self {
        let place = |t: &[u32; 3]| t.map(|n| points[n as usize]);
        let mut corners: Vec<[Point; 3]> = triangles.iter().map(place).collect();
        corners.extend(lids(points, triangles, size));
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

    /// The triangles that separate inside and outside, and those that do not: deep in another part of the
    /// solid, or folds outside of it.
    /// `beside` is how far beside a triangle is looked.
    pub fn parted(&self, beside: f64) -> [Self; 2] {
        let separates = |[a, b, c]: &[Point; 3]| {
            let normal = cross(sub(*b, *a), sub(*c, *a));
            let out = scale(normal, beside / norm(normal));
            let center = scale(add(*a, add(*b, *c)), 1.0 / 3.0);
            // Part of a triangle may be outside: its corners are looked at, too.
            let nearly = |p: Point| add(scale(p, 0.95), scale(center, 0.05));
            let places = [center, nearly(*a), nearly(*b), nearly(*c)];
            // Triangles without area have no sides, and folds of a lid have air on both.
            let inside = |p: Point| self.winding(p) > 0.5;
            places
                .iter()
                .any(|&p| inside(add(p, out)) != inside(sub(p, out)))
        };
        let seen: Vec<bool> = map(self.corners.iter().collect(), separates);
        let those = |which: bool| {
            let pairs = self.corners.iter().zip(&seen);
            Self::of(
                pairs
                    .filter(|(_, s)| **s == which)
                    .map(|(t, _)| *t)
                    .collect(),
            )
        };
        [those(true), those(false)]
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
            let solid = Solid::new(&points, &triangles, 0.1);
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

    /// The rim of the box is a saddle: the shape of a lid is not told by the rim's points alone.
    #[test]
    fn a_lid_lies_where_the_surface_without_it_goes_round_a_half() {
        let (mut points, triangles) = open_box();
        for p in &mut points {
            p[2] *= 1.0 + 2.4 * (p[0] - 0.5) * (p[1] - 0.5);
        }
        let place = |t: &[u32; 3]| t.map(|n| points[n as usize]);
        let open = Solid::of(triangles.iter().map(place).collect());
        // How many points of a grid a lid puts on the wrong side.
        let astray = |size: f64| {
            let closed = Solid::new(&points, &triangles, size);
            let mut wrong = 0;
            for k in 0..20 * 20 * 80 {
                let at = [k % 20, k / 20 % 20, k / 400].map(f64::from);
                let p = [
                    0.025 + 0.05 * at[0],
                    0.025 + 0.05 * at[1],
                    0.3 + 0.0151 * at[2],
                ];
                let turns = open.winding(p) - 0.5;
                // Clusters and flat triangles of the lid leave some thousandths of a turn.
                if turns.abs() > 0.01 && (turns > 0.0) != (closed.winding(p) > 0.5) {
                    wrong += 1;
                }
            }
            wrong
        };
        assert_eq!(astray(0.05), 0);
        assert!(astray(f64::INFINITY) > 300, "{}", astray(f64::INFINITY));
    }

    #[test]
    fn parts_inside_others_are_no_surface() {
        let mesh = kuhn_grid(4, 4, 4, [1.0; 3]).unwrap();
        let small = mesh.nodes().iter().map(|p| p.map(|c| 0.4 + 0.2 * c));
        let points: Vec<Point> = mesh.nodes().iter().copied().chain(small).collect();
        let faces = mesh.boundary().faces;
        let inner = faces.iter().map(|t| t.map(|n| n + mesh.num_nodes() as u32));
        let triangles: Vec<_> = faces.iter().copied().chain(inner).collect();
        let [outer, inner] = Solid::new(&points, &triangles, 0.1).parted(1e-3);
        assert_eq!(outer.corners.len(), faces.len());
        assert_eq!(inner.corners.len(), faces.len());
        assert!((distance(&inner, [0.5; 3]) - 0.1).abs() < 1e-12);
        assert!((distance(&outer, [0.5; 3]) - 0.5).abs() < 1e-12);
    }
}
