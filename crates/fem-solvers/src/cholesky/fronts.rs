//! Assembly and elimination of fronts, from the leaves of the tree to its roots.

use super::dense::FactorScalar;
use super::factor::CholeskyError;
use super::half::{Half, STRIP};
use super::pool::{Memory, Pool};
use super::symbolic::{Orientation, Supernode, SymbolicCholesky};
use crate::block_matrix::BlockSymmetric;
use crate::parallel::{each, map};
use fem_kinematics::{Kernel, dispatch};
use std::ops::Range;

/// Arithmetic below which a subtree is one task.
const TASK_FLOPS: f64 = 2e6;
/// Deepest nesting of tasks; below, a subtree is done in a loop.
pub(super) const TASK_DEPTH: usize = 48;
/// Numbers of a front from which its strips are tasks.
const LARGE: usize = 500_000;

/// A factorization under way.
pub(super) struct Fronts<'a, T, const D: usize> {
    pub symbolic: &'a SymbolicCholesky<D>,
    pub matrix: &'a BlockSymmetric<D>,
    pub pool: &'a Pool<T>,
}

impl<'a, T: FactorScalar, const D: usize> Fronts<'a, T, D> {
    /// The update matrices of several subtrees, which are neighbors in storage.
    pub fn children(
        &self,
        nodes: &[usize],
        panels: &mut [T],
        depth: usize,
    ) -> Result<Vec<Memory<'a, T>>, CholeskyError> {
        let mut tasks = Vec::with_capacity(nodes.len());
        let mut rest = panels;
        for &s in nodes {
            let (own, tail) = rest.split_at_mut(self.subtree_scalars(s));
            tasks.push((s, own));
            rest = tail;
        }
        map(tasks, |(s, own)| self.subtree(s, own, depth))
    }

    fn subtree_scalars(&self, s: usize) -> usize {
        let node = &self.symbolic.supernodes[s];
        let end = self
            .symbolic
            .supernodes
            .get(s + 1)
            .map_or(self.symbolic.panel_scalars, |next| next.panel);
        end - self.symbolic.supernodes[node.subtree].panel
    }

    /// Factors the subtree of `s`, whose panels are `panels`, and returns the update matrix of `s`.
    fn subtree(
        &self,
        s: usize,
        panels: &mut [T],
        depth: usize,
    ) -> Result<Memory<'a, T>, CholeskyError> {
        let nodes = &self.symbolic.supernodes;
        let node = &nodes[s];
        let own_size = node.height() * node.width();
        let (below, own) = panels.split_at_mut(panels.len() - own_size);
        let updates = if node.subtree_flops < TASK_FLOPS || depth >= TASK_DEPTH {
            self.subtree_loop(node.subtree..s, below)?
        } else {
            let children: Vec<usize> = node.children.iter().map(|&c| c as usize).collect();
            self.children(&children, below, depth + 1)?
        };
        self.front(node, own, &updates)
    }

    /// Factors fronts that come in postorder, and returns the updates that wait for a parent.
    fn subtree_loop(
        &self,
        nodes: Range<usize>,
        panels: &mut [T],
    ) -> Result<Vec<Memory<'a, T>>, CholeskyError> {
        // The updates of the children are the last ones on the stack.
        let mut stack: Vec<Memory<'a, T>> = Vec::new();
        let mut rest = panels;
        for node in &self.symbolic.supernodes[nodes] {
            let (own, tail) = rest.split_at_mut(node.height() * node.width());
            rest = tail;
            let first = stack.len() - node.children.len();
            let update = self.front(node, own, &stack[first..])?;
            stack.truncate(first);
            stack.push(update);
        }
        Ok(stack)
    }

    /// Assembles and eliminates one front. What the children add to its update matrix comes last, so that
    /// the matrix is made and not first cleared.
    fn front(
        &self,
        node: &Supernode,
        panel: &mut [T],
        updates: &[Memory<'a, T>],
    ) -> Result<Memory<'a, T>, CholeskyError> {
        let (height, columns) = (node.height(), node.width());
        self.assemble(node, panel, updates);
        let mut update = self.pool.take(Half { rows: node.below }.len());
        T::eliminate(panel, height, columns, &mut update, self.pool).map_err(|column| {
            let place = self.symbolic.places[node.scalars.start + column];
            CholeskyError::NotPositiveDefinite {
                block_row: place / D,
                axis: place % D,
            }
        })?;
        self.add_children(node, strips_below(node, &mut update), updates, |_| {});
        Ok(update)
    }

    /// What of the matrix and of the children enters the columns of a front.
    fn assemble(&self, node: &Supernode, panel: &mut [T], updates: &[Memory<'a, T>]) {
        let (height, width) = (node.height(), node.width());
        if width == 0 {
            return;
        }
        let strips = panel
            .chunks_mut(height * STRIP)
            .enumerate()
            .map(|(at, values)| Strip {
                columns: at * STRIP..width.min((at + 1) * STRIP),
                top: 0,
                height,
                values,
            })
            .collect();
        self.add_children(node, strips, updates, |values| {
            values.fill(T::from_f64(0.0));
        });
        for entry in &node.entries {
            let block = &self.matrix.values()[entry.source as usize];
            let corner = entry.column as usize * height + entry.row as usize;
            for c in 0..D {
                for r in 0..D {
                    let value = match entry.orientation {
                        Orientation::AsStored => block[r][c],
                        Orientation::Transposed => block[c][r],
                    };
                    panel[corner + c * height + r] += T::from_f64(value);
                }
            }
        }
        let stored = self.matrix.values().as_flattened().as_flattened();
        for piece in &node.pieces {
            panel[piece.to] += T::from_f64(stored[piece.source]);
        }
    }

    /// Adds the children's updates to strips of their parent's front, which are prepared first.
    fn add_children(
        &self,
        node: &Supernode,
        strips: Vec<Strip<'_, T>>,
        updates: &[Memory<'a, T>],
        prepare: impl Fn(&mut [T]) + Send + Sync,
    ) {
        let fill = |mut strip: Strip<'_, T>| {
            prepare(strip.values);
            for (&child, update) in node.children.iter().zip(updates) {
                dispatch(Add {
                    child: &self.symbolic.supernodes[child as usize],
                    update,
                    strip: &mut strip,
                });
            }
        };
        let size: usize = strips.iter().map(|strip| strip.values.len()).sum();
        if size > LARGE {
            each(strips, fill);
        } else {
            strips.into_iter().for_each(fill);
        }
    }
}

/// Some columns of a front with the rows from `top` on, column-major.
struct Strip<'a, T> {
    columns: Range<usize>,
    top: usize,
    /// Rows stored.
    height: usize,
    values: &'a mut [T],
}

/// The strips of the update matrix of a front.
fn strips_below<'a, T>(node: &Supernode, mut update: &'a mut [T]) -> Vec<Strip<'a, T>> {
    let (height, columns) = (node.height(), node.width());
    let of = |strip: Range<usize>| {
        let top = columns + strip.start;
        let (values, rest) = std::mem::take(&mut update).split_at_mut(strip.len() * (height - top));
        update = rest;
        Strip {
            columns: top..columns + strip.end,
            top,
            height: height - top,
            values,
        }
    };
    Half { rows: node.below }.strips().map(of).collect()
}

/// Adds to a strip what of a child's update belongs there, lower half.
struct Add<'a, 'b, T> {
    child: &'a Supernode,
    update: &'a [T],
    strip: &'a mut Strip<'b, T>,
}

impl<T: FactorScalar> Kernel for Add<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            child,
            update,
            strip,
        } = self;
        let half = Half { rows: child.below };
        let runs = &child.runs;
        let first = runs.partition_point(|run| (run.to + run.len) as usize <= strip.columns.start);
        for at in first..runs.len() {
            let own = runs[at];
            let begin = (own.to as usize).max(strip.columns.start);
            let end = ((own.to + own.len) as usize).min(strip.columns.end);
            if begin >= strip.columns.end {
                break;
            }
            for column in begin..end {
                let skip = column - own.to as usize;
                let from = own.from as usize + skip;
                // From the diagonal on.
                let source = &update[half.diagonal(from)..][..child.below - from];
                let target = &mut strip.values[(column - strip.columns.start) * strip.height..]
                    [column - strip.top..strip.height];
                let len = own.len as usize - skip;
                add(&mut target[..len], &source[..len]);
                for run in &runs[at + 1..] {
                    let len = run.len as usize;
                    let target = &mut target[run.to as usize - column..][..len];
                    add(target, &source[run.from as usize - from..][..len]);
                }
            }
        }
    }
}

#[inline(always)]
fn add<T: FactorScalar>(target: &mut [T], source: &[T]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t += *s;
    }
}
