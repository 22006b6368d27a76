//! Vertices of a skin that ride on other flesh than what is around them.

use super::distance::distance;
use super::{Landmark, Skin};
use fem_assembly::mesh::EmbeddedPoint;
use std::collections::{BTreeMap, BTreeSet};

/// How near a neighbor must be to ride on flesh next to a vertex's own, as a share of the shortest edge
/// of the element that carries the vertex.
const NEAR: f64 = 0.5;
/// Of how many near neighbors on something is said.
const ENOUGH: usize = 3;
/// A vertex further outside an element than this has no place on it, as in the embedding's table.
const OUTSIDE: f64 = -1.0;

/// The vertices of a skin whose element shares no node with the elements of most of their near
/// neighbors: an upper lip that carries a point of the lower one, say. `rest` are the nodes' places.
pub(super) fn strays(skin: &Skin, rest: &[[f64; 3]]) -> Vec<u32> {
    let neighbors = neighbors(skin);
    let strays = |&v: &u32| {
        let own = &skin.points[v as usize];
        let reach = NEAR * shortest_edge(own, rest);
        let place = |n: u32| skin.rest[n as usize];
        let around = neighbors[v as usize].iter().copied();
        let near: Vec<u32> = around
            .filter(|&n| distance(place(n), place(v)) < reach)
            .collect();
        let apart = |n: &&u32| shares_nothing(own, &skin.points[**n as usize]);
        near.len() >= ENOUGH && 2 * near.iter().filter(apart).count() > near.len()
    };
    (0..skin.points.len() as u32).filter(strays).collect()
}

/// Points of a face that are known by more than their place on the skin.
pub(super) struct Named<'a> {
    pub embedding: &'a mut BTreeMap<u32, EmbeddedPoint>,
    pub landmarks: &'a mut [Landmark],
}

/// Gives each stray the element of a near neighbor that rides on other flesh, the one that it lies deepest
/// in or least outside of; at rest it stays where it is. `numbers` are those of the skin's vertices in the
/// embedding; returned are those of the strays that are none any more.
pub(super) fn repair(
    skin: &mut Skin,
    numbers: &[u32],
    rest: &[[f64; 3]],
    named: Named,
) -> Vec<u32> {
    let strays = strays(skin, rest);
    let neighbors = neighbors(skin);
    let mut mended = Vec::new();
    for &v in &strays {
        let own = skin.points[v as usize];
        let (place, reach) = (own.position(rest), NEAR * shortest_edge(&own, rest));
        let other = |n: &&u32| {
            let point = &skin.points[**n as usize];
            let near = distance(skin.rest[**n as usize], skin.rest[v as usize]) < reach;
            near && shares_nothing(&own, point) && strays.binary_search(n).is_err()
        };
        let on = |n: &u32| EmbeddedPoint::at(skin.points[*n as usize].nodes, rest, place);
        let around = neighbors[v as usize].iter().filter(other);
        let best = around
            .filter_map(on)
            .filter(|p| depth(p) >= OUTSIDE)
            .max_by(|a, b| depth(a).total_cmp(&depth(b)));
        mended.extend(best.map(|point| (v, point)));
    }
    for &(v, point) in &mended {
        skin.points[v as usize] = point;
    }
    let left = self::strays(skin, rest);
    let mut repaired = BTreeSet::new();
    for (v, point) in mended {
        let Some(&number) = numbers.get(v as usize) else {
            continue;
        };
        named.embedding.insert(number, point);
        let landmarks = named.landmarks.iter_mut();
        for landmark in landmarks.filter(|l| l.vertex == number) {
            landmark.point = point;
        }
        if left.binary_search(&v).is_err() {
            repaired.insert(number);
        }
    }
    repaired.into_iter().collect()
}

fn shares_nothing(a: &EmbeddedPoint, b: &EmbeddedPoint) -> bool {
    !a.nodes.iter().any(|node| b.nodes.contains(node))
}

/// The least weight: how deep a point lies in its element, or how far outside.
fn depth(point: &EmbeddedPoint) -> f64 {
    point.weights.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The vertices with which each one shares an edge.
fn neighbors(skin: &Skin) -> Vec<BTreeSet<u32>> {
    let mut neighbors = vec![BTreeSet::new(); skin.points.len()];
    for &[a, b, c] in &skin.triangles {
        for (v, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            neighbors[v as usize].extend(others);
        }
    }
    neighbors
}

fn shortest_edge(point: &EmbeddedPoint, rest: &[[f64; 3]]) -> f64 {
    let corner = |k: usize| rest[point.nodes[k] as usize];
    let pairs = (0..4).flat_map(|a| (0..a).map(move |b| (a, b)));
    let lengths = pairs.map(|(a, b)| distance(corner(a), corner(b)));
    lengths.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tetrahedra, one above the other with a slit between, and a skin of small triangles around a
    /// vertex on the lower one.
    fn lips() -> (Vec<[f64; 3]>, Skin) {
        let lower = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [2.0, 0.0, 4.0],
            [2.0, -4.0, 1.0],
        ];
        let upper = lower.map(|[x, y, z]| [x, 0.2 - y, z]);
        let rest = [lower, upper].concat();
        let on = |[x, z]: [f64; 2], first: u32| {
            let nodes = [0, 1, 2, 3].map(|k| k + first);
            // Both faces of the slit have the same corners but for their height.
            let third = z / 4.0;
            let second = (x - 2.0 * third) / 4.0;
            EmbeddedPoint {
                nodes,
                weights: [1.0 - second - third, second, third, 0.0],
            }
        };
        let places = [[2.0, 1.0], [2.4, 1.0], [2.0, 1.4], [1.6, 1.0], [2.0, 0.6]];
        let points: Vec<EmbeddedPoint> = places.iter().map(|&p| on(p, 0)).collect();
        let skin = Skin {
            rest: points.iter().map(|p| p.position(&rest)).collect(),
            points,
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        };
        (rest, skin)
    }

    #[test]
    fn a_stray_is_given_the_flesh_of_its_neighbors_and_stays_where_it_is() {
        let (rest, mut skin) = lips();
        let good = skin.points[0];
        let place = good.position(&rest);
        let stray = EmbeddedPoint::at([4, 5, 6, 7], &rest, place).expect("a tetrahedron");
        skin.points[0] = stray;
        let mut embedding = BTreeMap::from([(70, skin.points[1]), (71, stray)]);
        let mut landmarks = [(48, stray), (49, skin.points[2])].map(|(index, point)| Landmark {
            index,
            vertex: 71 + index - 48,
            point,
        });
        let named = Named {
            embedding: &mut embedding,
            landmarks: &mut landmarks,
        };
        let numbers = [71, 70, 72, 73, 74];
        assert_eq!(repair(&mut skin, &numbers, &rest, named), [71]);
        assert_eq!(skin.points[0].nodes, good.nodes);
        assert!(distance(skin.points[0].position(&rest), place) < 1e-14);
        assert_eq!(embedding[&71], skin.points[0]);
        assert_eq!(embedding[&70], skin.points[1]);
        let points = landmarks.map(|l| l.point);
        assert_eq!(points, [skin.points[0], skin.points[2]]);
        assert_eq!(strays(&skin, &rest), [0_u32; 0]);
    }

    #[test]
    fn a_vertex_of_one_lip_on_the_other_is_found() {
        let (rest, mut skin) = lips();
        assert_eq!(strays(&skin, &rest), [0_u32; 0]);
        skin.points[0].nodes = [4, 5, 6, 7];
        assert_eq!(strays(&skin, &rest), [0]);
        // Neighbors as far away as the element is large say nothing.
        for n in 1..5 {
            let middle = skin.rest[0];
            skin.rest[n] = std::array::from_fn(|i| middle[i] + 9.0 * (skin.rest[n][i] - middle[i]));
        }
        assert_eq!(strays(&skin, &rest), [0_u32; 0]);
    }
}
