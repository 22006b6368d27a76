//! Finding the tetrahedron that a point lies in, or the nearest one.

use super::EmbeddedPoint;
use fem_assembly::mesh::SimplexMesh;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A point found in a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The tetrahedron that contains the point, or the nearest one.
    pub tet: u32,
    /// Barycentric weights there: all in [0, 1] inside, one or more negative outside.
    pub weights: [f64; 4],
    /// Distance to the tetrahedron, meters; 0 inside.
    pub distance: f64,
}

impl Located {
    /// The point as one that rides on `mesh`, in which it was found.
    pub fn embed(&self, mesh: &SimplexMesh<3>) -> EmbeddedPoint {
        EmbeddedPoint {
            nodes: mesh.tet(self.tet as usize),
            weights: self.weights,
        }
    }
}

/// A tree of bounding boxes over the tetrahedra of a mesh at rest.
#[derive(Clone, Debug)]
pub struct TetLocator<'a> {
    mesh: &'a SimplexMesh<3>,
    /// Tetrahedra, those of one leaf next to each other.
    order: Vec<u32>,
    boxes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// Range of `order`.
    start: u32,
    end: u32,
    /// The second child; the first one follows its parent. 0 for a leaf.
    second: u32,
}

const LEAF: usize = 8;

impl<'a> TetLocator<'a> {
    /// Builds the tree, O(n log² n).
    pub fn new(mesh: &'a SimplexMesh<3>) -> Self {
        let centers: Vec<[f64; 3]> = mesh
            .tets()
            .map(|t| {
                let x = t.map(|n| mesh.node(n));
                std::array::from_fn(|i| 0.25 * (x[0][i] + x[1][i] + x[2][i] + x[3][i]))
            })
            .collect();
        let mut locator = Self {
            mesh,
            order: (0..mesh.num_elements() as u32).collect(),
            boxes: Vec::new(),
        };
        locator.split(&centers, 0, mesh.num_elements());
        locator
    }

    fn split(&mut self, centers: &[[f64; 3]], start: usize, end: usize) -> u32 {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &tet in &self.order[start..end] {
            for x in self.mesh.tet(tet as usize).map(|n| self.mesh.node(n)) {
                for i in 0..3 {
                    low[i] = low[i].min(x[i]);
                    high[i] = high[i].max(x[i]);
                }
            }
        }
        let me = self.boxes.len();
        self.boxes.push(Node {
            low,
            high,
            start: start as u32,
            end: end as u32,
            second: 0,
        });
        if end - start > LEAF {
            let axis = (0..3)
                .max_by(|&i, &j| (high[i] - low[i]).total_cmp(&(high[j] - low[j])))
                .unwrap_or(0);
            let middle = (end - start) / 2;
            self.order[start..end].select_nth_unstable_by(middle, |&a, &b| {
                let key = |t: u32| centers[t as usize][axis];
                key(a).total_cmp(&key(b)).then(a.cmp(&b))
            });
            self.split(centers, start, start + middle);
            let second = self.split(centers, start + middle, end);
            self.boxes[me].second = second;
        }
        me as u32
    }

    /// The tetrahedron that contains `p` (the lowest-numbered one on a shared face), or else the
    /// nearest. `None` for a point that is not finite.
    pub fn locate(&self, p: [f64; 3]) -> Option<Located> {
        if !p.iter().all(|v| v.is_finite()) {
            return None;
        }
        let mut best: Option<Located> = None;
        let mut heap = BinaryHeap::from([Candidate {
            distance: distance_to_box(p, &self.boxes[0]),
            node: 0,
        }]);
        while let Some(Candidate { distance, node }) = heap.pop() {
            if best.is_some_and(|b| distance > b.distance) {
                break;
            }
            let at = &self.boxes[node as usize];
            if at.second > 0 {
                for child in [node + 1, at.second] {
                    heap.push(Candidate {
                        distance: distance_to_box(p, &self.boxes[child as usize]),
                        node: child,
                    });
                }
                continue;
            }
            for &tet in &self.order[at.start as usize..at.end as usize] {
                let found = self.measure(tet, p);
                let closer = |b: Located| (found.distance, tet) < (b.distance, b.tet);
                if best.is_none_or(closer) {
                    best = Some(found);
                }
            }
        }
        best
    }

    /// The tetrahedron that contains `p`, as [`locate`](Self::locate) finds it; `None` outside, where
    /// this looks for none: many times faster.
    pub fn containing(&self, p: [f64; 3]) -> Option<u32> {
        let in_box = |node: &Node| (0..3).all(|i| node.low[i] <= p[i] && p[i] <= node.high[i]);
        let mut found: Option<u32> = None;
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            let at = &self.boxes[node as usize];
            if !in_box(at) {
                continue;
            }
            if at.second > 0 {
                open.extend([node + 1, at.second]);
                continue;
            }
            for &tet in &self.order[at.start as usize..at.end as usize] {
                let first = found.is_none_or(|known| tet < known);
                if first && self.weights(tet, p).iter().all(|&w| w >= -1e-12) {
                    found = Some(tet);
                }
            }
        }
        found
    }

    fn weights(&self, tet: u32, p: [f64; 3]) -> [f64; 4] {
        let inverse = self.mesh.rest_edges(tet as usize).inverse();
        let origin = self.mesh.node(self.mesh.tet(tet as usize)[0]);
        let w = inverse.mul_vec(sub(p, origin));
        [1.0 - w[0] - w[1] - w[2], w[0], w[1], w[2]]
    }

    fn measure(&self, tet: u32, p: [f64; 3]) -> Located {
        let x = self.mesh.tet(tet as usize).map(|n| self.mesh.node(n));
        let weights = self.weights(tet, p);
        // Faces whose opposite weight is negative are the ones that see the point; a hair of
        // rounding does not put it outside.
        let mut distance = f64::INFINITY;
        for k in 0..4 {
            if weights[k] < -1e-12 {
                let [a, b, c] = [x[(k + 1) % 4], x[(k + 2) % 4], x[(k + 3) % 4]];
                distance = distance.min(distance_to_triangle(p, a, b, c));
            }
        }
        Located {
            tet,
            weights,
            distance: if distance.is_finite() { distance } else { 0.0 },
        }
    }
}

/// Ordered so that a max-heap gives the nearest box first, ties by number.
#[derive(PartialEq)]
struct Candidate {
    distance: f64,
    node: u32,
}
impl Eq for Candidate {}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let near = other.distance.total_cmp(&self.distance);
        near.then(other.node.cmp(&self.node))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn distance_to_box(p: [f64; 3], node: &Node) -> f64 {
    let outside = |i: usize| (node.low[i] - p[i]).max(p[i] - node.high[i]).max(0.0);
    (0..3).map(|i| outside(i).powi(2)).sum::<f64>().sqrt()
}

/// Distance to the closest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
fn distance_to_triangle(p: [f64; 3], a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let along = |from: [f64; 3], edge: [f64; 3], t: f64| {
        let closest: [f64; 3] = std::array::from_fn(|i| from[i] + t * edge[i]);
        length(sub(p, closest))
    };
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return length(ap);
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return length(bp);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return along(a, ab, d1 / (d1 - d3));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return length(cp);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return along(a, ac, d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return along(b, sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    let closest: [f64; 3] = std::array::from_fn(|i| a[i] + ab[i] * (vb / sum) + ac[i] * (vc / sum));
    length(sub(p, closest))
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_assembly::mesh::kuhn_grid;

    /// A small deterministic stream of numbers in [0, 1).
    fn stream() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Up to 24 tetrahedra meet in a node: the same one by both ways.
    #[test]
    fn what_elements_share_is_in_the_lowest_numbered() {
        let mesh = kuhn_grid(4, 3, 3, [1.0; 3]).expect("a grid");
        let locator = TetLocator::new(&mesh);
        for (node, &p) in (0..).zip(mesh.nodes()) {
            let first = (0..).zip(mesh.tets()).find(|(_, tet)| tet.contains(&node));
            let first = first.map(|(tet, _)| tet);
            assert_eq!(locator.containing(p), first);
            assert_eq!(locator.locate(p).map(|found| found.tet), first);
        }
    }

    #[test]
    fn points_inside_are_reproduced() {
        let mesh = kuhn_grid(5, 4, 6, [1.0, 2.0, 1.5]).expect("a grid");
        let locator = TetLocator::new(&mesh);
        let mut next = stream();
        for _ in 0..200 {
            let p = [next(), 2.0 * next(), 1.5 * next()];
            let found = locator.locate(p).expect("finite");
            assert_eq!(found.distance, 0.0);
            assert_eq!(locator.containing(p), Some(found.tet));
            assert_eq!(locator.containing([p[0], p[1], p[2] + 1.5]), None);
            assert!(found.weights.iter().all(|&w| w >= -1e-12));
            let back = found.embed(&mesh).position(mesh.nodes());
            assert!(length(sub(back, p)) < 1e-14);
        }
    }

    #[test]
    fn outside_the_nearest_element_is_found() {
        let mesh = kuhn_grid(3, 3, 3, [1.0; 3]).expect("a grid");
        let locator = TetLocator::new(&mesh);
        let mut next = stream();
        for _ in 0..200 {
            let p = [4.0 * next() - 2.0, 4.0 * next() - 2.0, 4.0 * next() - 2.0];
            let outside = |v: f64| (-v).max(v - 1.0).max(0.0);
            let expected = length(p.map(outside));
            let found = locator.locate(p).expect("finite");
            assert!((found.distance - expected).abs() < 1e-12);
            let back = found.embed(&mesh).position(mesh.nodes());
            assert!(length(sub(back, p)) < 1e-12);
        }
    }

    #[test]
    fn nan_is_nowhere() {
        let mesh = kuhn_grid(1, 1, 1, [1.0; 3]).expect("a grid");
        assert_eq!(TetLocator::new(&mesh).locate([0.0, f64::NAN, 0.0]), None);
    }
}
