//! From a cut of the edges to a small vertex separator.

use super::Graph;

/// Side of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Left,
    Right,
    Separator,
}

/// The smallest vertex set that touches every cut edge: a minimum vertex cover of the bipartite
/// graph of cut edges, from a maximum matching (König 1931).
///
/// On entry `part` holds only `Left` and `Right`; on return the cover is `Separator`. Returns its size.
pub(super) fn cover_cut(graph: &Graph, part: &mut [Part]) -> usize {
    const NONE: u32 = u32::MAX;
    let n = graph.len();
    let cut = |v: usize, part: &[Part]| {
        let own = part[v];
        graph
            .of(v)
            .iter()
            .copied()
            .filter(move |&w| own != part[w as usize])
            .collect::<Vec<_>>()
    };
    let left: Vec<usize> = (0..n)
        .filter(|&v| {
            part[v] == Part::Left && graph.of(v).iter().any(|&w| part[w as usize] == Part::Right)
        })
        .collect();
    let edges: Vec<Vec<u32>> = left.iter().map(|&v| cut(v, part)).collect();
    let mut mate_left = vec![NONE; left.len()];
    let mut mate_right = vec![NONE; n];
    for (l, adjacent) in edges.iter().enumerate() {
        if let Some(&w) = adjacent.iter().find(|&&w| mate_right[w as usize] == NONE) {
            mate_left[l] = w;
            mate_right[w as usize] = l as u32;
        }
    }
    // Augmenting paths, breadth first from each free left vertex; `came_from[w]` is the left vertex
    // that discovered right vertex w.
    let mut came_from = vec![NONE; n];
    let mut touched: Vec<u32> = Vec::new();
    let mut queue: Vec<u32> = Vec::new();
    for root in 0..left.len() {
        if mate_left[root] != NONE {
            continue;
        }
        queue.clear();
        queue.push(root as u32);
        let mut head = 0;
        let mut end = NONE;
        'search: while head < queue.len() {
            let l = queue[head];
            head += 1;
            for &w in &edges[l as usize] {
                if came_from[w as usize] != NONE {
                    continue;
                }
                came_from[w as usize] = l;
                touched.push(w);
                if mate_right[w as usize] == NONE {
                    end = w;
                    break 'search;
                }
                queue.push(mate_right[w as usize]);
            }
        }
        if end == NONE {
            // Nothing reachable from here is free; what was visited can never be useful again.
            touched.clear();
            continue;
        }
        let mut w = end;
        loop {
            let l = came_from[w as usize];
            let next = mate_left[l as usize];
            mate_left[l as usize] = w;
            mate_right[w as usize] = l;
            if next == NONE {
                break;
            }
            w = next;
        }
        for w in touched.drain(..) {
            came_from[w as usize] = NONE;
        }
    }
    // König: reached by alternating paths from free left vertices; cover = unreached left + reached right.
    let mut reached_left = vec![false; left.len()];
    let mut reached_right = vec![false; n];
    let mut stack: Vec<usize> = (0..left.len()).filter(|&l| mate_left[l] == NONE).collect();
    for &l in &stack {
        reached_left[l] = true;
    }
    while let Some(l) = stack.pop() {
        for &w in &edges[l] {
            let w = w as usize;
            if !reached_right[w] {
                reached_right[w] = true;
                let l = mate_right[w] as usize;
                if mate_right[w] != NONE && !reached_left[l] {
                    reached_left[l] = true;
                    stack.push(l);
                }
            }
        }
    }
    let mut size = 0;
    for (l, &v) in left.iter().enumerate() {
        if !reached_left[l] {
            part[v] = Part::Separator;
            size += 1;
        }
    }
    for (w, reached) in reached_right.iter().enumerate() {
        if *reached {
            part[w] = Part::Separator;
            size += 1;
        }
    }
    size
}
