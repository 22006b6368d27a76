//! What of a factorization depends on the pattern alone.

use super::amalgamation::{Panel, panels};
use super::elimination_tree::{NO_PARENT, column_counts, parents, postorder};
use crate::block_matrix::BlockPattern;
use crate::ordering::{Graph, Permutation, nested_dissection};
use std::ops::Range;
use std::sync::Arc;

/// Ordering, elimination tree and storage plan of `P A Pᵀ = L Lᵀ`; made once per pattern and shared.
///
/// `D` is the size of the blocks.
#[derive(Clone, Debug)]
pub struct SymbolicCholesky<const D: usize> {
    pub(super) pattern: Arc<BlockPattern>,
    /// New block row → old block row, and back.
    pub(super) permutation: Permutation,
    /// In postorder: children before parents, subtrees contiguous.
    pub(super) supernodes: Vec<Supernode>,
    /// Scalars in all panels.
    pub(super) panel_scalars: usize,
    flops: f64,
}

/// One dense front: `columns` are eliminated here, `rows` are updated.
#[derive(Clone, Debug)]
pub(super) struct Supernode {
    /// Block columns, new numbering.
    pub columns: Range<usize>,
    /// Block rows below, new numbering, ascending.
    pub rows: Vec<u32>,
    pub parent: u32,
    /// Ascending.
    pub children: Vec<u32>,
    /// First supernode of the subtree that ends here.
    pub subtree: usize,
    /// First scalar of the panel, a column-major `(columns + rows)·D × columns·D` matrix.
    pub panel: usize,
    /// For each of `rows`, its block position in the parent's front (`columns` then `rows`), as runs.
    pub runs: Vec<Run>,
    /// Blocks of `A` that enter here.
    pub entries: Vec<Entry>,
    /// Arithmetic of the subtree.
    pub subtree_flops: f64,
}

/// `len` consecutive block rows from `from` in a child sit at `to` in its parent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub from: u32,
    pub to: u32,
    pub len: u32,
}

/// Stored block `source` of `A` goes to block `(row, column)` of a panel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub source: u32,
    pub row: u32,
    pub column: u32,
    pub orientation: Orientation,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Orientation {
    AsStored,
    Transposed,
}

impl Supernode {
    pub fn width(&self) -> usize {
        self.columns.len()
    }
    /// Block rows of the front.
    pub fn height(&self) -> usize {
        self.columns.len() + self.rows.len()
    }
}

impl<const D: usize> SymbolicCholesky<D> {
    /// Analyses a pattern, ordering by graph distances.
    pub fn new(pattern: &Arc<BlockPattern>) -> Self {
        Self::with_permutation(pattern, &nested_dissection::<0>(pattern, None))
    }

    /// Analyses a pattern whose block `i` sits at `coordinates[i]`; planar cuts give less fill.
    ///
    /// Coordinates of another length than the pattern, or not finite, are ignored.
    pub fn with_coordinates<const N: usize>(
        pattern: &Arc<BlockPattern>,
        coordinates: &[[f64; N]],
    ) -> Self {
        Self::with_permutation(pattern, &nested_dissection(pattern, Some(coordinates)))
    }

    /// Analyses a pattern in an order of the caller's; a postorder of its elimination tree is used,
    /// which has the same fill.
    ///
    /// # Panics
    /// If the permutation is not as long as the pattern has block rows.
    pub fn with_permutation(pattern: &Arc<BlockPattern>, ordering: &Permutation) -> Self {
        assert_eq!(ordering.len(), pattern.blocks(), "one place per block row");
        let graph = Graph::of_pattern(pattern);
        // Postorder, so that supernodes are runs of columns.
        let parent = parents(&graph, ordering);
        let post = postorder(&parent);
        let order = post.iter().map(|&k| ordering.order()[k as usize]).collect();
        let permutation = Permutation::from_order(order);
        let parent = parents(&graph, &permutation);
        let count = column_counts(&graph, &permutation, &parent);
        // Merged supernodes, again in postorder.
        let merged = panels(&parent, &count, D);
        let tree: Vec<u32> = merged.iter().map(|p| p.parent).collect();
        let post = postorder(&tree);
        let order = post
            .iter()
            .flat_map(|&s| merged[s as usize].columns.iter())
            .map(|&k| permutation.order()[k as usize])
            .collect();
        let permutation = Permutation::from_order(order);
        let mut supernodes = layout(&graph, &permutation, &merged, &post);
        let (panel_scalars, flops) = sizes::<D>(&mut supernodes);
        place_entries(pattern, &permutation, &mut supernodes);
        Self {
            pattern: pattern.clone(),
            permutation,
            supernodes,
            panel_scalars,
            flops,
        }
    }

    /// The pattern that was analysed.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Scalar dimension of the matrix.
    pub fn dim(&self) -> usize {
        D * self.pattern.blocks()
    }

    /// Scalars on and below the diagonal of `L`, explicit zeros of merged supernodes included.
    pub fn fill(&self) -> usize {
        self.supernodes
            .iter()
            .map(|s| {
                let (w, r) = (D * s.width(), D * s.rows.len());
                w * (w + 1) / 2 + w * r
            })
            .sum()
    }

    /// Additions and multiplications of one factorization.
    pub fn flops(&self) -> f64 {
        self.flops
    }

    /// Number of dense fronts.
    pub fn fronts(&self) -> usize {
        self.supernodes.len()
    }
}

/// Rows, tree and row positions of every supernode, in postorder.
fn layout(
    graph: &Graph,
    permutation: &Permutation,
    merged: &[Panel],
    post: &[u32],
) -> Vec<Supernode> {
    let mut number = vec![NO_PARENT; merged.len()];
    for (new, &old) in post.iter().enumerate() {
        number[old as usize] = new as u32;
    }
    let mut supernodes: Vec<Supernode> = Vec::with_capacity(post.len());
    let mut begin = 0;
    for &old in post {
        let panel = &merged[old as usize];
        let columns = begin..begin + panel.columns.len();
        begin = columns.end;
        let parent = if panel.parent == NO_PARENT {
            NO_PARENT
        } else {
            number[panel.parent as usize]
        };
        supernodes.push(Supernode {
            columns,
            rows: Vec::new(),
            parent,
            children: Vec::new(),
            subtree: supernodes.len(),
            panel: 0,
            runs: Vec::new(),
            entries: Vec::new(),
            subtree_flops: 0.0,
        });
    }
    for s in 0..supernodes.len() {
        if supernodes[s].parent != NO_PARENT {
            let (p, first) = (supernodes[s].parent as usize, supernodes[s].subtree);
            supernodes[p].children.push(s as u32);
            supernodes[p].subtree = supernodes[p].subtree.min(first);
        }
    }
    find_rows(graph, permutation, &mut supernodes);
    for s in 0..supernodes.len() {
        if supernodes[s].parent != NO_PARENT {
            supernodes[s].runs = runs(
                &supernodes[s].rows,
                &supernodes[supernodes[s].parent as usize],
            );
        }
    }
    supernodes
}

/// The rows of every supernode: those of its own columns and of its children, below it.
fn find_rows(graph: &Graph, permutation: &Permutation, supernodes: &mut [Supernode]) {
    let mut seen = vec![NO_PARENT; graph.len()];
    for s in 0..supernodes.len() {
        let end = supernodes[s].columns.end;
        let mut rows = Vec::new();
        let mut visit = |row: u32| {
            if row as usize >= end && seen[row as usize] != s as u32 {
                seen[row as usize] = s as u32;
                rows.push(row);
            }
        };
        for j in supernodes[s].columns.clone() {
            for &w in graph.of(permutation.order()[j] as usize) {
                visit(permutation.position()[w as usize]);
            }
        }
        for &c in &supernodes[s].children {
            supernodes[c as usize]
                .rows
                .iter()
                .for_each(|&row| visit(row));
        }
        rows.sort_unstable();
        supernodes[s].rows = rows;
    }
}

fn runs(rows: &[u32], parent: &Supernode) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut cursor = 0;
    for (k, &row) in rows.iter().enumerate() {
        let to = if (row as usize) < parent.columns.end {
            row as usize - parent.columns.start
        } else {
            while parent.rows[cursor] < row {
                cursor += 1;
            }
            parent.width() + cursor
        } as u32;
        match runs.last_mut() {
            // A run does not cross from the columns of the parent into its rows.
            Some(run) if run.to + run.len == to && to as usize != parent.width() => run.len += 1,
            _ => runs.push(Run {
                from: k as u32,
                to,
                len: 1,
            }),
        }
    }
    runs
}

/// Panel offsets and arithmetic; returns the totals.
fn sizes<const D: usize>(supernodes: &mut [Supernode]) -> (usize, f64) {
    let mut offset = 0;
    let mut total = 0.0;
    for s in 0..supernodes.len() {
        supernodes[s].panel = offset;
        offset += D * supernodes[s].height() * D * supernodes[s].width();
        let (w, r) = (
            (D * supernodes[s].width()) as f64,
            (D * supernodes[s].rows.len()) as f64,
        );
        let own = w * w * w / 3.0 + w * w * r + w * r * r;
        total += own;
        let below: f64 = supernodes[s]
            .children
            .iter()
            .map(|&c| supernodes[c as usize].subtree_flops)
            .sum();
        supernodes[s].subtree_flops = own + below;
    }
    (offset, total)
}

fn place_entries(pattern: &BlockPattern, permutation: &Permutation, supernodes: &mut [Supernode]) {
    let mut owner = vec![0u32; pattern.blocks()];
    for (s, node) in supernodes.iter().enumerate() {
        for j in node.columns.clone() {
            owner[j] = s as u32;
        }
    }
    for i in 0..pattern.blocks() {
        for k in pattern.row_start()[i]..pattern.row_start()[i + 1] {
            let a = permutation.position()[i] as usize;
            let b = permutation.position()[pattern.columns()[k] as usize] as usize;
            let (row, column, orientation) = if a >= b {
                (a, b, Orientation::AsStored)
            } else {
                (b, a, Orientation::Transposed)
            };
            let node = &mut supernodes[owner[column] as usize];
            let row = if row < node.columns.end {
                row - node.columns.start
            } else {
                node.width() + node.rows.partition_point(|&r| (r as usize) < row)
            };
            node.entries.push(Entry {
                source: k as u32,
                row: row as u32,
                column: (column - node.columns.start) as u32,
                orientation,
            });
        }
    }
}
