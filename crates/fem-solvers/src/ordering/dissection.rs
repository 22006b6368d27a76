//! Nested dissection.

use super::minimum_degree::order_leaf;
use super::separator::{Side, cover_cut};
use super::{Graph, Permutation};
use crate::block_matrix::BlockPattern;

/// Vertices from which a part is not split any further.
const LEAF: usize = 96;
/// Cuts tried along each direction, as fractions of the vertices.
const FRACTIONS: [f64; 3] = [0.5, 0.42, 0.58];

/// A fill-reducing ordering of the blocks of a symmetric matrix.
///
/// With coordinates (one point per block, in any unit) the cuts are planes across the axes; without,
/// or when a coordinate is not finite, they are level sets of the distance in the graph. In both
/// cases the separator is the smallest vertex set that covers the cut edges. The result depends on
/// the pattern and the coordinates alone.
pub fn nested_dissection<const N: usize>(
    pattern: &BlockPattern,
    coordinates: Option<&[[f64; N]]>,
) -> Permutation {
    let graph = Graph::of_pattern(pattern);
    let n = graph.len();
    let coordinates =
        coordinates.filter(|c| N > 0 && c.len() == n && c.iter().flatten().all(|v| v.is_finite()));
    let mut order = vec![0; n];
    let mut local = vec![u32::MAX; n];
    let mut work = vec![((0..n as u32).collect::<Vec<_>>(), 0usize)];
    // A part is a set of vertices and the place of its first one in the order.
    while let Some((vertices, begin)) = work.pop() {
        let end = begin + vertices.len();
        if vertices.len() <= LEAF {
            order_leaf(&graph, &vertices, &mut local, &mut order[begin..end]);
            continue;
        }
        let sub = graph.induced(&vertices, &mut local);
        let components = sub.components();
        if components.len() > 1 {
            let mut place = begin;
            for component in components {
                let size = component.len();
                work.push((
                    component.iter().map(|&k| vertices[k as usize]).collect(),
                    place,
                ));
                place += size;
            }
            continue;
        }
        let Some(sides) = split(&sub, &vertices, coordinates) else {
            // No cut leaves two sides: nearly a complete graph, where every order fills alike.
            order[begin..end].copy_from_slice(&vertices);
            continue;
        };
        let pick = |which: Side| -> Vec<u32> {
            vertices
                .iter()
                .zip(&sides)
                .filter(|(_, p)| **p == which)
                .map(|(v, _)| *v)
                .collect()
        };
        let (left, right, separator) = (pick(Side::Left), pick(Side::Right), pick(Side::Separator));
        order[end - separator.len()..end].copy_from_slice(&separator);
        let middle = begin + left.len();
        work.push((left, begin));
        work.push((right, middle));
    }
    Permutation::from_order(order)
}

/// The best of several cuts, `None` when no cut leaves anything on both sides.
fn split<const N: usize>(
    graph: &Graph,
    vertices: &[u32],
    coordinates: Option<&[[f64; N]]>,
) -> Option<Vec<Side>> {
    let n = graph.len();
    let heights: Vec<Vec<f64>> = match coordinates {
        Some(points) => (0..N)
            .map(|axis| vertices.iter().map(|&v| points[v as usize][axis]).collect())
            .collect(),
        None => level_sets(graph),
    };
    let mut best: Option<(f64, Vec<Side>)> = None;
    for height in &heights {
        let mut sorted: Vec<u32> = (0..n as u32).collect();
        sorted.sort_by(|&a, &b| {
            height[a as usize]
                .total_cmp(&height[b as usize])
                .then(a.cmp(&b))
        });
        let mut tried = Vec::new();
        for fraction in FRACTIONS {
            let cut = level_cut(&sorted, height, (fraction * n as f64) as usize);
            if cut == 0 || cut == n || tried.contains(&cut) {
                continue;
            }
            tried.push(cut);
            let mut sides = vec![Side::Right; n];
            for &v in &sorted[..cut] {
                sides[v as usize] = Side::Left;
            }
            let size = cover_cut(graph, &mut sides);
            let left = sides.iter().filter(|p| **p == Side::Left).count();
            let right = n - size - left;
            if left == 0 || right == 0 {
                continue;
            }
            let score = size as f64 / (left as f64 * right as f64);
            if best.as_ref().is_none_or(|(s, _)| score < *s) {
                best = Some((score, sides));
            }
        }
    }
    best.map(|(_, sides)| sides)
}

/// The place nearest to `target` where the height changes, unless that is far away: a cut between
/// two layers of a grid needs no jog.
fn level_cut(sorted: &[u32], height: &[f64], target: usize) -> usize {
    let n = sorted.len();
    let changes =
        |k: usize| k > 0 && k < n && height[sorted[k - 1] as usize] < height[sorted[k] as usize];
    for offset in 0..n / 8 {
        if changes(target + offset) {
            return target + offset;
        }
        if target >= offset && changes(target - offset) {
            return target - offset;
        }
    }
    target
}

/// Distances in the graph from far-apart vertices, and their differences.
fn level_sets(graph: &Graph) -> Vec<Vec<f64>> {
    let (_, a) = graph.distances(0);
    let (from_a, b) = graph.distances(a);
    let (from_b, _) = graph.distances(b);
    // Farthest from both ends: the direction across.
    let c = (0..graph.len())
        .max_by_key(|&v| from_a[v].min(from_b[v]))
        .unwrap_or(0);
    let (from_c, d) = graph.distances(c);
    let (from_d, _) = graph.distances(d);
    let single = |x: &[u32]| x.iter().map(|&v| f64::from(v)).collect::<Vec<_>>();
    let difference = |x: &[u32], y: &[u32]| {
        x.iter()
            .zip(y)
            .map(|(&p, &q)| f64::from(p) - f64::from(q))
            .collect::<Vec<_>>()
    };
    vec![
        single(&from_a),
        difference(&from_a, &from_b),
        single(&from_c),
        difference(&from_c, &from_d),
    ]
}
