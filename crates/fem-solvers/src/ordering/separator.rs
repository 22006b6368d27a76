//! From a cut of the edges to a small vertex separator.

use super::Graph;

/// Side of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Separator,
}

/// The smallest vertex set that touches every cut edge: a minimum vertex cover of the bipartite
/// graph of cut edges, from a maximum matching (König 1931).
///
/// On entry `side` holds only `Left` and `Right`; on return the cover is `Separator`. Returns its size.
pub(super) fn cover_cut(graph: &Graph, side: &mut [Side]) -> usize {
    let n = graph.len();
    let cut = |v: usize, side: &[Side]| {
        let own = side[v];
        graph
            .of(v)
            .iter()
            .copied()
            .filter(move |&w| own != side[w as usize])
            .collect::<Vec<_>>()
    };
    let left: Vec<usize> = (0..n)
        .filter(|&v| {
            side[v] == Side::Left && graph.of(v).iter().any(|&w| side[w as usize] == Side::Right)
        })
        .collect();
    let edges: Vec<Vec<u32>> = left.iter().map(|&v| cut(v, side)).collect();
    let mut matching = Matching::greedy(&edges, n);
    matching.augment(&edges);
    let (reached_left, reached_right) = matching.reached(&edges);
    let mut size = 0;
    for (l, &v) in left.iter().enumerate() {
        if !reached_left[l] {
            side[v] = Side::Separator;
            size += 1;
        }
    }
    for (w, reached) in reached_right.iter().enumerate() {
        if *reached {
            side[w] = Side::Separator;
            size += 1;
        }
    }
    size
}

const NONE: u32 = u32::MAX;

/// Who is matched with whom across a cut.
struct Matching {
    /// The right vertex of each left one, numbered along the cut.
    left: Vec<u32>,
    /// The left vertex of each vertex of the graph.
    right: Vec<u32>,
}

impl Matching {
    /// Everyone takes the first who is free.
    fn greedy(edges: &[Vec<u32>], n: usize) -> Self {
        let (mut left, mut right) = (vec![NONE; edges.len()], vec![NONE; n]);
        for (l, adjacent) in edges.iter().enumerate() {
            if let Some(&w) = adjacent.iter().find(|&&w| right[w as usize] == NONE) {
                left[l] = w;
                right[w as usize] = l as u32;
            }
        }
        Self { left, right }
    }

    /// Augmenting paths, breadth first from each free left vertex, until the matching is largest.
    fn augment(&mut self, edges: &[Vec<u32>]) {
        // The left vertex that discovered each right vertex.
        let mut came_from = vec![NONE; self.right.len()];
        let (mut touched, mut queue) = (Vec::new(), Vec::new());
        for root in 0..edges.len() {
            if self.left[root] != NONE {
                continue;
            }
            queue.clear();
            queue.push(root as u32);
            match self.search(edges, &mut queue, &mut came_from, &mut touched) {
                Some(end) => {
                    self.flip(end, &came_from);
                    for w in touched.drain(..) {
                        came_from[w as usize] = NONE;
                    }
                }
                // Nothing reachable from here is free; what was visited can never be useful again.
                None => touched.clear(),
            }
        }
    }

    /// The first free right vertex that alternating paths reach from the queue.
    fn search(
        &self,
        edges: &[Vec<u32>],
        queue: &mut Vec<u32>,
        came_from: &mut [u32],
        touched: &mut Vec<u32>,
    ) -> Option<u32> {
        let mut head = 0;
        while head < queue.len() {
            let l = queue[head];
            head += 1;
            for &w in &edges[l as usize] {
                if came_from[w as usize] != NONE {
                    continue;
                }
                came_from[w as usize] = l;
                touched.push(w);
                match self.right[w as usize] {
                    NONE => return Some(w),
                    mate => queue.push(mate),
                }
            }
        }
        None
    }

    /// Matches along the path that ends at a right vertex what was not, and the other way around.
    fn flip(&mut self, end: u32, came_from: &[u32]) {
        let mut w = end;
        while w != NONE {
            let l = came_from[w as usize];
            self.right[w as usize] = l;
            w = std::mem::replace(&mut self.left[l as usize], w);
        }
    }

    /// König: who is reached by alternating paths from free left vertices. The cover is the left who are
    /// not and the right who are.
    fn reached(&self, edges: &[Vec<u32>]) -> (Vec<bool>, Vec<bool>) {
        let (mut left, mut right) = (vec![false; edges.len()], vec![false; self.right.len()]);
        let free = |&l: &usize| self.left[l] == NONE;
        let mut stack: Vec<usize> = (0..edges.len()).filter(free).collect();
        for &l in &stack {
            left[l] = true;
        }
        while let Some(l) = stack.pop() {
            for &w in &edges[l] {
                let mate = self.right[w as usize];
                if !std::mem::replace(&mut right[w as usize], true)
                    && mate != NONE
                    && !std::mem::replace(&mut left[mate as usize], true)
                {
                    stack.push(mate as usize);
                }
            }
        }
        (left, right)
    }
}
