//! Which pairs of a surface are near each other.

use super::cones::Cones;
use super::geometry::{Aabb, Point, cross, dot, nearest_on_triangle, norm, segment_distance, sub};
use super::pair::{BAND, Kind, Pair};
use super::params::FleshContactParams;
use super::surface::{Normals, Surface};
use super::tree::BoxTree;
use super::way::Way;
use fem_solvers::parallel::map;

/// Of the normals of two edges, how much must lie along their common perpendicular.
const SQUARE: f64 = 0.3;
/// sin² from which on two edges have a common perpendicular.
const SKEW: f64 = 0.005;
/// What a pair that is to be kept may lose of that before it is none.
const KEPT: f64 = 0.5;
/// Up to which product of its normals it still faces each other; others do below 0.
const AWAY: f64 = 0.2;
/// Behind a surface, as a share of the distance: beyond doubt where surfaces are curved.
const CLEARLY: f64 = 0.6;

/// Finds pairs; holds what it needs to be quick.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    pub surface: Surface,
    pub params: FleshContactParams,
    rest_normals: Normals,
    /// Of each vertex: the gap to what faces it at rest where that is less than the
    /// activation; negative where it is behind.
    pub clearance: Vec<f64>,
    triangle_tree: BoxTree,
    edge_tree: BoxTree,
}

/// One look at a configuration.
struct Look<'a> {
    way: &'a Way,
    positions: &'a [Point],
    normals: Normals,
    plates: Vec<Plate>,
    /// No two vertices move against each other by more on the way.
    most: f64,
    /// How much wider than what is felt.
    margin: f64,
    stay: Stay<'a>,
}

/// Of a triangle in a look what tells where points are before it: most pairs are ruled out by that.
#[derive(Clone, Copy)]
struct Plate {
    /// The gap and the second and third share as affine functions.
    gap: (Point, f64),
    shares: [(Point, f64); 2],
    heights: [f64; 3],
}

impl Plate {
    fn new([a, b, c]: [Point; 3], unit_normal: Point) -> Self {
        let (e, f) = (sub(b, a), sub(c, a));
        let normal = cross(e, f);
        let square = dot(normal, normal);
        let affine = |slope: Point| (slope, -dot(slope, a));
        let share = |slope: Point| affine(slope.map(|s| s / square));
        let height = |side: Point| square.sqrt() / norm(side);
        Self {
            gap: affine(unit_normal),
            shares: [share(cross(f, normal)), share(cross(normal, e))],
            heights: [height(sub(c, b)), height(f), height(e)],
        }
    }

    fn gap(&self, x: Point) -> f64 {
        dot(self.gap.0, x) + self.gap.1
    }

    /// Is x above the triangle, or beside it by no more than its windows and a margin?
    fn is_above(&self, x: Point, margin: f64) -> bool {
        let [second, third] = self.shares.map(|(slope, start)| dot(slope, x) + start);
        let shares = [1.0 - second - third, second, third];
        let over = |(share, height): (&f64, &f64)| *share >= -BAND - margin / height;
        shares.iter().zip(&self.heights).all(over)
    }
}

/// A pair, and whether its partners face each other beyond doubt.
struct Partners {
    pair: Pair,
    clearly: bool,
}

/// Pairs that a look finds although they do not face each other, sorted by kind and vertices.
#[derive(Clone, Copy, Default)]
pub(crate) struct Stay<'a> {
    /// Until they clearly face away.
    pub kept: &'a [Pair],
    /// As long as they are near.
    pub held: &'a [Pair],
}

impl Look<'_> {
    /// The pair, if it faces each other clearly, or is to stay and has no force at rest.
    fn accepted(&self, Partners { pair, clearly }: Partners, rest: &[Point]) -> Option<Pair> {
        let stays = || has(self.stay.kept, &pair) || has(self.stay.held, &pair);
        let quiet = || !(pair.energy(pair.vertices.map(|n| rest[n as usize])) > 0.0);
        (clearly || (stays() && quiet())).then_some(pair)
    }

    /// May partners whose normals have this product be a pair?
    fn may_face(&self, toward: f64, kinds: &[Kind], vertices: [u32; 4]) -> bool {
        let held = |&kind: &Kind| {
            let found = self.stay.held.binary_search_by_key(&(kind, vertices), key);
            found.is_ok()
        };
        toward < AWAY || (!self.stay.held.is_empty() && kinds.iter().any(held))
    }
}

/// Is the pair in a list sorted by kind and vertices?
pub(crate) fn has(sorted: &[Pair], pair: &Pair) -> bool {
    sorted.binary_search_by_key(&key(pair), key).is_ok()
}

/// What pairs are sorted by.
pub(crate) fn key(pair: &Pair) -> (Kind, [u32; 4]) {
    (pair.kind, pair.vertices)
}

impl Search {
    pub fn new(mut surface: Surface, params: FleshContactParams) -> Self {
        if !params.edges {
            surface.drop_edges();
        }
        let rest = surface.rest.clone();
        let normals = surface.normals(&rest);
        let still = Way::at(rest.clone());
        let mut search = Self {
            clearance: vec![params.activation; rest.len()],
            triangle_tree: BoxTree::new(&surface.triangle_boxes(&still)),
            edge_tree: BoxTree::new(&surface.edge_boxes(&still)),
            rest_normals: normals,
            surface,
            params,
        };
        search.measure_clearance(&rest);
        search
    }

    /// Pairs that feel something at the start of a way, or would if their partners came nearer by as
    /// much as they move against each other on it and by `margin`, meters; sorted by kind and vertices.
    pub fn pairs(&mut self, way: &Way, margin: f64, stay: Stay) -> Vec<Pair> {
        let mut pairs = self.looked(way, margin, stay, &|search, look, kind, a, b| {
            search.candidate(look, kind, a, b)
        });
        pairs.sort_unstable_by_key(key);
        pairs
    }

    /// What is found in the pairs (point, triangle) and (edge, edge) whose boxes are near.
    fn looked<T: Send>(
        &mut self,
        way: &Way,
        margin: f64,
        stay: Stay,
        found: &(impl Fn(&Self, &Look, Kind, usize, usize) -> Option<T> + Sync),
    ) -> Vec<T> {
        let triangles = self.surface.triangle_boxes(way);
        self.triangle_tree.fit(&triangles);
        let edges = self.surface.edge_boxes(way);
        self.edge_tree.fit(&edges);
        let search = &*self;
        let positions = &way.from;
        let normals = self.surface.normals(positions);
        let plate = |(corners, normal): (&[u32; 3], &Point)| {
            Plate::new(self.surface.corners(positions, corners), *normal)
        };
        let all = self.surface.triangles.iter().zip(&normals.triangles);
        let look = Look {
            way,
            positions,
            plates: all.map(plate).collect(),
            most: way.most_between(&self.surface.points),
            normals,
            margin,
            stay,
        };
        let reach = (self.params.activation + margin).max(self.params.deepest());
        let of_triangles = Cones::new(&self.triangle_tree, &look.normals.triangles, AWAY);
        let of_edges = Cones::new(&self.edge_tree, &look.normals.edges, AWAY);
        // What is held stays wherever it looks.
        let all = !look.stay.held.is_empty();
        let of_point = |&node: &u32| {
            let around = Aabb::around(way.ends(node)).grown(reach);
            let normal = look.normals.nodes[node as usize];
            let wanted = |branch| all || !of_triangles.look_away(branch, normal);
            let mut own = Vec::new();
            let tree = &search.triangle_tree;
            tree.visit_where(&around, &wanted, &mut |t| {
                if triangles[t as usize].overlaps(&around) {
                    own.extend(found(search, &look, Kind::Point, node as usize, t as usize));
                }
            });
            own
        };
        let of_edge = |(edge, around): (usize, &Aabb)| {
            let mut own = Vec::new();
            let around = around.grown(reach);
            let normal = look.normals.edges[edge];
            let wanted = |branch| all || !of_edges.look_away(branch, normal);
            search
                .edge_tree
                .visit_where(&around, &wanted, &mut |other| {
                    if other as usize > edge && edges[other as usize].overlaps(&around) {
                        own.extend(found(search, &look, Kind::EdgeAlong, edge, other as usize));
                    }
                });
            own
        };
        let points: Vec<Vec<T>> = map(self.surface.points.iter().collect(), of_point);
        let pairs: Vec<Vec<T>> = map(edges.iter().enumerate().collect(), of_edge);
        points.into_iter().chain(pairs).flatten().collect()
    }

    fn measure_clearance(&mut self, rest: &[Point]) {
        // As deep as `pairs` looks: what lies that far behind at rest must not push there either.
        let found = self.looked(
            &Way::at(rest.to_vec()),
            self.params.margin,
            Stay::default(),
            &|search, look, kind, a, b| {
                let pair = search.facing(look, kind, a, b)?;
                let x = pair.vertices.map(|n| look.positions[n as usize]);
                let (gap, weight) = pair.gap(x);
                let clearance = if weight > 0.0 {
                    gap
                } else if kind == Kind::Point {
                    norm(sub(x[0], nearest_on_triangle(x[0], [x[1], x[2], x[3]])))
                } else {
                    segment_distance([x[0], x[1]], [x[2], x[3]])
                };
                (clearance >= -search.params.deepest()).then_some((pair.vertices, clearance))
            },
        );
        for (vertices, clearance) in found {
            for n in vertices {
                let known = &mut self.clearance[n as usize];
                *known = known.min(clearance);
            }
        }
    }

    /// The pair, if it would do. What rules most out comes first, what reads most memory last.
    fn candidate(&self, look: &Look, kind: Kind, a: usize, b: usize) -> Option<Pair> {
        if kind == Kind::Point && self.is_far(look, a, b) {
            return None;
        }
        let partners = self.partners(look, kind, a, b)?;
        let near = if kind == Kind::Point {
            self.is_point_near(look, &partners.pair, b)
        } else {
            self.are_edges_near(look, &partners.pair)
        };
        if !near || self.is_one_piece(kind, a, b) {
            return None;
        }
        look.accepted(partners, &self.surface.rest)
    }

    /// The pair, if its partners face each other and were not neighbors or two sides of one piece of
    /// flesh at rest.
    fn facing(&self, look: &Look, kind: Kind, a: usize, b: usize) -> Option<Pair> {
        let partners = self.partners(look, kind, a, b)?;
        if self.is_one_piece(kind, a, b) {
            return None;
        }
        look.accepted(partners, &self.surface.rest)
    }

    /// May what the pair would feel be reached from where the look is?
    fn is_point_near(&self, look: &Look, pair: &Pair, triangle: usize) -> bool {
        let [node, ..] = pair.vertices;
        let (plate, x) = (&look.plates[triangle], look.positions[node as usize]);
        let gap = plate.gap(x);
        let within = |margin: f64| {
            gap <= pair.activation + margin
                && gap >= -self.params.deepest()
                && plate.is_above(x, margin)
        };
        let moved = || {
            look.way
                .change_between(&pair.vertices[..1], &pair.vertices[1..])
        };
        // The longest way of any vertices was asked for before (`is_far`).
        within(look.margin) || within(look.margin + moved())
    }

    fn are_edges_near(&self, look: &Look, pair: &Pair) -> bool {
        let x = pair.vertices.map(|n| look.positions[n as usize]);
        let (gap, shares, sizes) = on_edges(pair.kind, x);
        let (first, second) = pair.vertices.split_at(2);
        let margin = look.margin + look.way.change_between(first, second);
        let high = pair.activation + margin;
        let near = gap <= high && gap >= -self.params.deepest();
        let over = |(share, size): (&f64, &f64)| *share >= -BAND - margin / size;
        near && shares.iter().zip(&sizes).all(over)
    }

    /// Is a point farther before or behind the plane of a triangle than any pair may be, or beside it? The
    /// cheapest of all reasons against one.
    fn is_far(&self, look: &Look, node: usize, triangle: usize) -> bool {
        let (plate, x) = (&look.plates[triangle], look.positions[node]);
        let gap = plate.gap(x);
        let (activation, behind) = (self.params.activation, self.params.deepest());
        let margin = look.margin + look.most;
        gap < -behind || gap > activation + margin || !plate.is_above(x, margin)
    }

    fn partners(&self, look: &Look, kind: Kind, a: usize, b: usize) -> Option<Partners> {
        if kind == Kind::Point {
            self.point_and_triangle(look, a, b)
        } else {
            self.two_edges(look, a, b)
        }
    }

    fn point_and_triangle(&self, look: &Look, node: usize, triangle: usize) -> Option<Partners> {
        let [b, c, d] = self.surface.triangles[triangle];
        let toward = dot(look.normals.nodes[node], look.normals.triangles[triangle]);
        let vertices = [node as u32, b, c, d];
        if !look.may_face(toward, &[Kind::Point], vertices) {
            return None;
        }
        // Edges bear the other half.
        let share = if self.params.edges { 0.5 } else { 1.0 } * self.surface.area[node];
        Some(Partners {
            pair: self.pair(vertices, Kind::Point, share),
            clearly: toward < 0.0,
        })
    }

    fn two_edges(&self, look: &Look, first: usize, second: usize) -> Option<Partners> {
        let surface = &self.surface;
        let normals = [look.normals.edges[first], look.normals.edges[second]];
        let toward = dot(normals[0], normals[1]);
        let [a, b] = [first, second].map(|e| surface.edges[e].nodes);
        let kinds = [Kind::EdgeAlong, Kind::EdgeAgainst];
        if !look.may_face(toward, &kinds, [a[0], a[1], b[0], b[1]]) {
            return None;
        }
        let ends = |e: [u32; 2]| e.map(|n| look.positions[n as usize]);
        let direction = |[p, q]: [Point; 2]| sub(q, p);
        let (e, f) = (direction(ends(a)), direction(ends(b)));
        let across = cross(e, f);
        let length = norm(across);
        let apart = sub(normals[0], normals[1]);
        let along = dot(across, apart);
        let skew = length * length / (dot(e, e) * dot(f, f));
        let square = along.abs() / (length * norm(apart));
        if !(skew > KEPT * SKEW) || !(square > KEPT * SQUARE) {
            return None;
        }
        let kind = if along > 0.0 {
            Kind::EdgeAlong
        } else {
            Kind::EdgeAgainst
        };
        let areas = [surface.edge_area[first], surface.edge_area[second]];
        let share = 0.5 * areas[0] * areas[1] / (areas[0] + areas[1]);
        Some(Partners {
            pair: self.pair([a[0], a[1], b[0], b[1]], kind, share),
            clearly: toward < 0.0 && skew > SKEW && square > SQUARE,
        })
    }

    /// Were they neighbors, or two sides of one piece of flesh, at rest?
    fn is_one_piece(&self, kind: Kind, a: usize, b: usize) -> bool {
        if kind == Kind::Point {
            self.are_point_and_triangle_one(a, b)
        } else {
            self.are_edges_one(a, b)
        }
    }

    fn are_point_and_triangle_one(&self, node: usize, triangle: usize) -> bool {
        let surface = &self.surface;
        let corners = surface.triangles[triangle];
        if surface.are_neighbors(node as u32, &corners) {
            return true;
        }
        let (p, t) = (surface.rest[node], surface.corners(&surface.rest, &corners));
        let way = sub(nearest_on_triangle(p, t), p);
        let ahead = [
            dot(self.rest_normals.nodes[node], way),
            dot(self.rest_normals.triangles[triangle], sub(p, t[0])),
        ];
        let behind = ahead[1] < 0.0 || is_clearly_behind(ahead, norm(way));
        behind && !surface.buried[node] && self.is_thin(norm(way))
    }

    fn are_edges_one(&self, first: usize, second: usize) -> bool {
        let (surface, rest) = (&self.surface, &self.surface.rest);
        let [a, b] = [first, second].map(|e| surface.edges[e].nodes);
        if a.iter().any(|&n| surface.are_neighbors(n, &b)) {
            return true;
        }
        let way = sub(surface.middle(rest, second), surface.middle(rest, first));
        let ahead = [
            dot(self.rest_normals.edges[first], way),
            -dot(self.rest_normals.edges[second], way),
        ];
        let behind = ahead.iter().all(|&a| a < 0.0) || is_clearly_behind(ahead, norm(way));
        let at_rest = |e: [u32; 2]| e.map(|n| rest[n as usize]);
        let buried = a.iter().chain(&b).any(|&n| surface.buried[n as usize]);
        behind && !buried && self.is_thin(segment_distance(at_rest(a), at_rest(b)))
    }

    /// Could the other side of one piece of flesh, so far away at rest, be taken for a partner that
    /// was entered?
    fn is_thin(&self, distance: f64) -> bool {
        distance <= 2.0 * self.params.deepest()
    }

    fn pair(&self, vertices: [u32; 4], kind: Kind, area: f64) -> Pair {
        let FleshContactParams {
            activation,
            pressure,
            ..
        } = self.params;
        let least = |d: f64, &n: &u32| d.min(self.clearance[n as usize]);
        let own = vertices.iter().fold(activation, least);
        Pair {
            vertices,
            kind,
            force: pressure * area,
            activation: own,
            length: own.max(0.25 * activation),
        }
    }
}

/// Does one of two partners lie so far behind the other that they are sides of one wedge? One of them may
/// still be ahead of the other there, where its side is hollow.
fn is_clearly_behind(ahead: [f64; 2], distance: f64) -> bool {
    ahead.iter().any(|&a| a < -CLEARLY * distance)
}

/// Gap, shares of both edges before and behind the nearest points of their lines, lengths.
fn on_edges(kind: Kind, [p, q, r, s]: [Point; 4]) -> (f64, [f64; 4], [f64; 4]) {
    let (e, f, u) = (sub(q, p), sub(s, r), sub(r, p));
    let across = cross(e, f);
    let square = dot(across, across);
    let first = dot(cross(u, f), across) / square;
    let second = dot(cross(u, e), across) / square;
    let gap = dot(u, across) / square.sqrt();
    let (le, lf) = (norm(e), norm(f));
    (
        if kind == Kind::EdgeAlong { gap } else { -gap },
        [first, 1.0 - first, second, 1.0 - second],
        [le, le, lf, lf],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::contact::geometry::unit;

    /// Gap and shares by volumes and areas of their own, for points all around.
    #[test]
    fn a_plate_tells_where_points_are_before_its_triangle() {
        let wave = |k: usize| (12.9 * k as f64).sin();
        for k in 0..20 {
            let corner = |v: usize| std::array::from_fn(|i| 0.1 + wave(9 * k + 3 * v + i));
            let [a, b, c]: [Point; 3] = std::array::from_fn(corner);
            let normal = unit(cross(sub(b, a), sub(c, a)));
            let plate = Plate::new([a, b, c], normal);
            let signed = |p: Point, q: Point, r: Point| dot(cross(sub(q, p), sub(r, p)), normal);
            for n in 0..30 {
                let x: Point = std::array::from_fn(|i| 2.0 * wave(7 * n + i + k));
                let gap = dot(normal, sub(x, b));
                assert!((plate.gap(x) - gap).abs() < 1e-12);
                // How far x is beyond each side, within the plane, and the height over that side.
                let sides = [(b, c), (c, a), (a, b)];
                let off = sides.map(|(p, q)| {
                    let side = norm(sub(q, p));
                    let height = signed(a, b, c) / side;
                    -signed(p, q, x) / side - BAND * height
                });
                let most = off.into_iter().fold(f64::NEG_INFINITY, f64::max);
                assert!(plate.is_above(x, most + 1e-9), "{k} {n}");
                assert!(!plate.is_above(x, most - 1e-9), "{k} {n}");
            }
        }
    }
}
