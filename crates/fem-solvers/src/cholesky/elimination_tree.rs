//! The elimination tree of a reordered graph.

use crate::ordering::{Graph, Permutation};

pub(super) const NO_PARENT: u32 = u32::MAX;

/// Parent of every vertex in the new numbering (Liu 1986).
pub(super) fn parents(graph: &Graph, permutation: &Permutation) -> Vec<u32> {
    let n = graph.len();
    let mut parent = vec![NO_PARENT; n];
    let mut ancestor = vec![NO_PARENT; n];
    for i in 0..n {
        let old = permutation.order()[i] as usize;
        for &w in graph.of(old) {
            let mut j = permutation.position()[w as usize] as usize;
            if j >= i {
                continue;
            }
            // Walk to the root of the tree so far, pointing everything passed at i.
            loop {
                let next = ancestor[j];
                if next == i as u32 {
                    break;
                }
                ancestor[j] = i as u32;
                if next == NO_PARENT {
                    parent[j] = i as u32;
                    break;
                }
                j = next as usize;
            }
        }
    }
    parent
}

/// Vertices so that children come before parents and subtrees are contiguous; children keep their order.
pub(super) fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let mut first_child = vec![NO_PARENT; n];
    let mut sibling = vec![NO_PARENT; n];
    for v in (0..n).rev() {
        if parent[v] != NO_PARENT {
            sibling[v] = first_child[parent[v] as usize];
            first_child[parent[v] as usize] = v as u32;
        }
    }
    let mut order = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for root in (0..n).filter(|&v| parent[v] == NO_PARENT) {
        stack.push(root as u32);
        while let Some(&v) = stack.last() {
            let child = first_child[v as usize];
            if child == NO_PARENT {
                order.push(v);
                stack.pop();
            } else {
                first_child[v as usize] = sibling[child as usize];
                stack.push(child);
            }
        }
    }
    order
}

/// Number of blocks in each column of the factor, with the diagonal.
///
/// Row `i` of the factor is the union of the tree paths from its entries up to `i`.
pub(super) fn column_counts(graph: &Graph, permutation: &Permutation, parent: &[u32]) -> Vec<u32> {
    let n = graph.len();
    let mut count = vec![1; n];
    let mut seen = vec![NO_PARENT; n];
    for i in 0..n {
        seen[i] = i as u32;
        let old = permutation.order()[i] as usize;
        for &w in graph.of(old) {
            let mut j = permutation.position()[w as usize] as usize;
            while j < i && seen[j] != i as u32 {
                seen[j] = i as u32;
                count[j] += 1;
                j = parent[j] as usize;
            }
        }
    }
    count
}
