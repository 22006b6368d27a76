//! What of a factorization depends on the pattern alone.

use super::amalgamation::{Panel, panels};
use super::elimination_tree::{NO_PARENT, column_counts, parents, postorder};
use super::scalars::Scalars;
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
    /// Place of each scalar of the factor in a vector of blocks.
    pub(super) places: Vec<usize>,
    /// In postorder: children before parents, subtrees contiguous.
    pub(super) supernodes: Vec<Supernode>,
    /// Scalars in all panels.
    pub(super) panel_scalars: usize,
    flops: f64,
}

/// One dense front: the scalars of `columns` are eliminated here, those of `rows` are updated.
#[derive(Clone, Debug)]
pub(super) struct Supernode {
    /// Block columns, new numbering.
    pub columns: Range<usize>,
    /// Block rows below, new numbering, ascending.
    pub rows: Vec<u32>,
    /// The scalars of `columns`, new numbering.
    pub scalars: Range<usize>,
    /// Number of the scalars of `rows`.
    pub below: usize,
    pub parent: u32,
    /// Ascending.
    pub children: Vec<u32>,
    /// First supernode of the subtree that ends here.
    pub subtree: usize,
    /// First scalar of the panel, a column-major `height × width` matrix.
    pub panel: usize,
    /// For each scalar of `rows`, its position in the parent's front (`columns` then `rows`), as runs.
    pub runs: Vec<Run>,
    /// Blocks of `A` that enter here whole.
    pub entries: Vec<Entry>,
    /// What enters of the other blocks.
    pub pieces: Vec<Piece>,
    /// Arithmetic of the subtree.
    pub subtree_flops: f64,
}

/// `len` consecutive rows from `from` below a child's columns sit at `to` in its parent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub from: u32,
    pub to: u32,
    pub len: u32,
}

/// Stored block `source` of `A` goes to a panel, its first scalar to `(row, column)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub source: u32,
    pub row: u32,
    pub column: u32,
    pub orientation: Orientation,
}

/// Scalar `source` of all that `A` stores goes to `to` in a panel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub source: usize,
    pub to: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Orientation {
    AsStored,
    Transposed,
}

impl Supernode {
    /// Columns of the panel.
    pub fn width(&self) -> usize {
        self.scalars.len()
    }
    /// Rows of the front.
    pub fn height(&self) -> usize {
        self.scalars.len() + self.below
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
        let graph = Graph::of_pattern(pattern).isolating(&pattern.empty_rows(D));
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
        let scalars = Scalars::new(pattern, &permutation, D);
        let mut supernodes = layout(&graph, &permutation, &merged, &post);
        let starts = place_rows(&scalars, &mut supernodes);
        let (panel_scalars, flops) = sizes(&mut supernodes);
        place_entries::<D>(pattern, &permutation, &scalars, &starts, &mut supernodes);
        Self {
            pattern: pattern.clone(),
            places: scalars.places,
            supernodes,
            panel_scalars,
            flops,
        }
    }

    /// The pattern that was analysed.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// Length of right-hand sides and solutions, places of absent scalars included.
    pub fn dim(&self) -> usize {
        D * self.pattern.blocks()
    }

    /// Number of scalar unknowns: rows of `L`.
    pub fn unknowns(&self) -> usize {
        self.places.len()
    }

    /// Puts 0 in the places of absent scalars of a vector of blocks.
    pub(super) fn clear_absent(&self, vector: &mut [f64]) {
        for place in self.pattern.absent_places(D) {
            vector[place] = 0.0;
        }
    }

    /// Scalars on and below the diagonal of `L`, explicit zeros of merged supernodes included.
    pub fn fill(&self) -> usize {
        let of = |s: &Supernode| s.width() * (s.width() + 1) / 2 + s.width() * s.below;
        self.supernodes.iter().map(of).sum()
    }

    /// Additions and multiplications of one factorization.
    pub fn flops(&self) -> f64 {
        self.flops
    }

    /// Number of dense fronts.
    pub fn fronts(&self) -> usize {
        self.supernodes.iter().filter(|s| s.width() > 0).count()
    }
}

/// Block rows and tree of every supernode, in postorder.
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
            scalars: 0..0,
            below: 0,
            parent,
            children: Vec::new(),
            subtree: supernodes.len(),
            panel: 0,
            runs: Vec::new(),
            entries: Vec::new(),
            pieces: Vec::new(),
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

/// Sizes of every front and the positions of its rows in its parent. Returns for each front where the
/// scalars of its block rows begin.
fn place_rows(scalars: &Scalars, supernodes: &mut [Supernode]) -> Vec<Vec<u32>> {
    let mut starts: Vec<Vec<u32>> = Vec::with_capacity(supernodes.len());
    for node in &mut *supernodes {
        node.scalars = scalars.of(node.columns.clone());
        let mut height = node.width();
        let mut of_node = Vec::with_capacity(node.rows.len());
        for &row in &node.rows {
            of_node.push(height as u32);
            height += scalars.places_of(row as usize).len();
        }
        starts.push(of_node);
        node.below = height - node.width();
    }
    for s in 0..supernodes.len() {
        let node = &supernodes[s];
        if node.parent != NO_PARENT {
            let p = node.parent as usize;
            let runs = runs(scalars, node, &starts[s], &supernodes[p], &starts[p]);
            supernodes[s].runs = runs;
        }
    }
    starts
}

fn runs(
    scalars: &Scalars,
    node: &Supernode,
    starts: &[u32],
    parent: &Supernode,
    parent_starts: &[u32],
) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut cursor = 0;
    for (&row, &start) in node.rows.iter().zip(starts) {
        let of_row = scalars.of(row as usize..row as usize + 1);
        let to = if (row as usize) < parent.columns.end {
            (of_row.start - parent.scalars.start) as u32
        } else {
            while parent.rows[cursor] < row {
                cursor += 1;
            }
            parent_starts[cursor]
        };
        let len = of_row.len() as u32;
        match runs.last_mut() {
            // A run does not cross from the columns of the parent into its rows.
            Some(run) if run.to + run.len == to && to as usize != parent.width() => run.len += len,
            _ => runs.push(Run {
                from: start - node.width() as u32,
                to,
                len,
            }),
        }
    }
    runs
}

/// Panel offsets and arithmetic; returns the totals.
fn sizes(supernodes: &mut [Supernode]) -> (usize, f64) {
    let mut offset = 0;
    let mut total = 0.0;
    for s in 0..supernodes.len() {
        supernodes[s].panel = offset;
        offset += supernodes[s].height() * supernodes[s].width();
        let (w, r) = (supernodes[s].width() as f64, supernodes[s].below as f64);
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

fn place_entries<const D: usize>(
    pattern: &BlockPattern,
    permutation: &Permutation,
    scalars: &Scalars,
    starts: &[Vec<u32>],
    supernodes: &mut [Supernode],
) {
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
            let (of_row, of_column) = (scalars.places_of(row), scalars.places_of(column));
            if of_row.is_empty() || of_column.is_empty() {
                continue;
            }
            let s = owner[column] as usize;
            let node = &mut supernodes[s];
            let in_columns = |j: usize| (scalars.of(j..j + 1).start - node.scalars.start) as u32;
            let entry = Entry {
                source: k as u32,
                row: if row < node.columns.end {
                    in_columns(row)
                } else {
                    starts[s][node.rows.partition_point(|&r| (r as usize) < row)]
                },
                column: in_columns(column),
                orientation,
            };
            if of_row.len() == D && of_column.len() == D {
                node.entries.push(entry);
            } else {
                let height = node.height();
                node.pieces
                    .extend(entry.pieces::<D>(height, of_row, of_column));
            }
        }
    }
}

impl Entry {
    /// The scalars of a block in a panel of this height, given the places of its rows and columns.
    fn pieces<const D: usize>(
        self,
        height: usize,
        rows: &[usize],
        columns: &[usize],
    ) -> impl Iterator<Item = Piece> {
        let corner = self.column as usize * height + self.row as usize;
        let of = move |r: usize, c: usize| {
            let (high, low) = match self.orientation {
                Orientation::AsStored => (rows[r] % D, columns[c] % D),
                Orientation::Transposed => (columns[c] % D, rows[r] % D),
            };
            Piece {
                source: (self.source as usize * D + high) * D + low,
                to: corner + c * height + r,
            }
        };
        (0..columns.len()).flat_map(move |c| (0..rows.len()).map(move |r| of(r, c)))
    }
}
