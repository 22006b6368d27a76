//! Fill-reducing orderings of the block graph.
//!
//! Nested dissection (George 1973): split the graph by a small vertex separator, order both sides
//! first and the separator last, and so on down to leaves, which are ordered by minimum degree.

mod dissection;
mod graph;
mod minimum_degree;
mod separator;

pub use dissection::nested_dissection;
pub(crate) use graph::Graph;

/// A reordering of `0..len`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Permutation {
    order: Vec<u32>,
    position: Vec<u32>,
}

impl Permutation {
    /// From the list "new place → old index"; `None` unless it holds every index once.
    pub fn new(order: Vec<u32>) -> Option<Self> {
        let mut visited = vec![Visited::No; order.len()];
        for &old in &order {
            match visited.get_mut(old as usize) {
                Some(slot @ Visited::No) => *slot = Visited::Yes,
                _ => return None,
            }
        }
        Some(Self::from_order(order))
    }

    /// [`new`](Self::new) for lists that are permutations by construction.
    pub(crate) fn from_order(order: Vec<u32>) -> Self {
        let mut position = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            position[old as usize] = new as u32;
        }
        Self { order, position }
    }

    /// Number of indices.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there is nothing to order.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Old index at each new place.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// New place of each old index.
    pub fn position(&self) -> &[u32] {
        &self.position
    }
}

#[derive(Clone, Copy)]
enum Visited {
    No,
    Yes,
}
