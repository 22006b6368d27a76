//! Nested dissection.

use super::minimum_degree::order_leaf;
use super::separator::{Side, cover_cut};
use super::{Graph, Permutation};
use crate::block_matrix::BlockPattern;
use crate::parallel::each;

/// Vertices from which a part is not split any further.
const LEAF: usize = 96;
/// Vertices from which a piece is worth a thread, and about how many such pieces there may be.
const LARGE: usize = 2_048;
const MOST: usize = 16;
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
    let cuts = Cuts {
        graph: &graph,
        coordinates,
    };
    cuts.dissect((0..n as u32).collect(), &mut order);
    Permutation::from_order(order)
}

struct Cuts<'a, const N: usize> {
    graph: &'a Graph,
    coordinates: Option<&'a [[f64; N]]>,
}

impl<const N: usize> Cuts<'_, N> {
    /// Orders a part; what is cut into large pieces goes to several threads, each with numbers of its own
    /// for all vertices: few pieces, however many there are.
    fn dissect(&self, vertices: Vec<u32>, order: &mut [u32]) {
        let worth = LARGE.max(self.graph.len() / MOST);
        let mut local = vec![u32::MAX; self.graph.len()];
        let mut work = vec![(vertices, order)];
        while let Some((vertices, order)) = work.pop() {
            let parts = self.cut(vertices, order, &mut local).into_iter();
            let (large, small): (Vec<_>, Vec<_>) = parts.partition(|(v, _)| v.len() > worth);
            work.extend(small);
            if large.len() > 1 {
                each(large, |(vertices, order)| self.dissect(vertices, order));
            } else {
                work.extend(large);
            }
        }
    }

    /// Orders a leaf or a separator, and returns what is left with its place in the order.
    fn cut<'o>(
        &self,
        vertices: Vec<u32>,
        order: &'o mut [u32],
        local: &mut [u32],
    ) -> Vec<(Vec<u32>, &'o mut [u32])> {
        if vertices.len() <= LEAF {
            order_leaf(self.graph, &vertices, local, order);
            return Vec::new();
        }
        let sub = self.graph.induced(&vertices, local);
        let components = sub.components();
        if components.len() > 1 {
            let global = |own: Vec<u32>| own.iter().map(|&k| vertices[k as usize]).collect();
            return shares(components.into_iter().map(global).collect(), order);
        }
        let Some(sides) = split(&sub, &vertices, self.coordinates) else {
            // No cut leaves two sides: nearly a complete graph, where every order fills alike.
            order.copy_from_slice(&vertices);
            return Vec::new();
        };
        let pick = |which: Side| -> Vec<u32> {
            let own = vertices.iter().zip(&sides).filter(|(_, p)| **p == which);
            own.map(|(v, _)| *v).collect()
        };
        let separator = pick(Side::Separator);
        let (order, last) = order.split_at_mut(vertices.len() - separator.len());
        last.copy_from_slice(&separator);
        shares(vec![pick(Side::Left), pick(Side::Right)], order)
    }
}

/// Each part with its place in the order, one behind the other.
fn shares(parts: Vec<Vec<u32>>, mut order: &mut [u32]) -> Vec<(Vec<u32>, &mut [u32])> {
    let mut shares = Vec::with_capacity(parts.len());
    for part in parts {
        let (own, rest) = order.split_at_mut(part.len());
        shares.push((part, own));
        order = rest;
    }
    shares
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

#[cfg(test)]
mod tests {
    use super::nested_dissection;
    use crate::block_matrix::BlockPattern;

    /// A hundred thousand bodies of three, and one that is worth two threads.
    #[test]
    fn many_small_bodies_are_ordered_one_by_one() {
        let (small, large) = (100_000, 6_000);
        let triples = (0..small).flat_map(|k| [(3 * k, 3 * k + 1), (3 * k + 1, 3 * k + 2)]);
        let begin = 3 * small;
        let chain = (1..large).map(move |k| (begin + k - 1, begin + k));
        let pattern = BlockPattern::from_adjacency(begin + large, triples.chain(chain)).unwrap();
        let order = nested_dissection::<3>(&pattern, None);
        let position = order.position();
        let together = |of: &[u32]| {
            let (first, last) = (of.iter().min(), of.iter().max());
            last.zip(first).map(|(l, f)| (l - f) as usize) == Some(of.len() - 1)
        };
        assert!(position[..begin].chunks(3).all(together));
        assert!(together(&position[begin..]));
    }
}
