//! Solving with the factor, for one or many right-hand sides.

use super::dense::FactorScalar;
use super::elimination_tree::NO_PARENT;
use super::factor::CholeskyFactor;
use super::fronts::TASK_DEPTH;
use super::symbolic::Supernode;
use crate::parallel::map;
use faer::{MatMut, MatRef};

/// Panel scalars times columns below which a subtree is one task.
const TASK_SCALARS: usize = 400_000;

impl<T: FactorScalar, const D: usize> CholeskyFactor<T, D> {
    /// `x ← A⁻¹ x`; where a scalar is absent, 0 in place of anything.
    ///
    /// # Panics
    /// If `x` is not as long as the matrix.
    pub fn solve_in_place(&self, x: &mut [f64]) {
        self.solve_many(x, 1);
    }

    /// `X ← A⁻¹ X` for `ncols` right-hand sides, column-major, as one block solve; where a scalar is
    /// absent, 0 in place of anything.
    ///
    /// Parallel over the elimination tree; the bits do not depend on the number of threads.
    ///
    /// # Panics
    /// If `x` does not hold `ncols` columns as long as the matrix.
    pub fn solve_many(&self, x: &mut [f64], ncols: usize) {
        let n = self.symbolic.dim();
        assert!(
            x.len() == n * ncols,
            "{} values are not {ncols} columns of length {n}",
            x.len()
        );
        if n == 0 || ncols == 0 {
            return;
        }
        let sweep = Sweep {
            factor: self,
            ncols,
        };
        let mut y = vec![T::from_f64(0.0); self.symbolic.unknowns() * ncols];
        sweep.permute(&mut y, |y, at| *y = T::from_f64(x[at]));
        let roots: Vec<usize> = (0..self.symbolic.supernodes.len())
            .filter(|&s| self.symbolic.supernodes[s].parent == NO_PARENT)
            .collect();
        sweep.forward_children(&roots, &mut y, 0);
        sweep.backward_children(&roots, &mut y, None, 0);
        sweep.permute(&mut y, |y, at| x[at] = y.to_f64());
        x.chunks_exact_mut(n)
            .for_each(|column| self.symbolic.clear_absent(column));
    }
}

/// One pass over the tree. The vectors are stored front by front: the columns of a front, as a
/// column-major `width × ncols` matrix, then those of the next, so that a subtree is one slice.
struct Sweep<'a, T, const D: usize> {
    factor: &'a CholeskyFactor<T, D>,
    ncols: usize,
}

/// What a parent's front holds: its own unknowns and those of its rows, column-major.
#[derive(Clone, Copy)]
struct Front<'a, T> {
    node: &'a Supernode,
    own: &'a [T],
    rows: &'a [T],
}

impl<'a, T: FactorScalar, const D: usize> Sweep<'a, T, D> {
    fn node(&self, s: usize) -> &'a Supernode {
        &self.factor.symbolic.supernodes[s]
    }

    fn panel(&self, node: &Supernode) -> &'a [T] {
        &self.factor.panels[node.panel..node.panel + node.height() * node.width()]
    }

    /// Calls `f(entry of y, index into the caller's columns)` for every entry.
    fn permute(&self, y: &mut [T], mut f: impl FnMut(&mut T, usize)) {
        let n = self.factor.symbolic.dim();
        let places = &self.factor.symbolic.places;
        let mut y = y.iter_mut();
        for node in &self.factor.symbolic.supernodes {
            for c in 0..self.ncols {
                let own = places[node.scalars.clone()].iter();
                for (place, y) in own.zip(y.by_ref()) {
                    f(y, c * n + place);
                }
            }
        }
    }

    /// Scalars of `y` that belong to the subtree of `s`.
    fn subtree_len(&self, s: usize) -> usize {
        let first = self.node(self.node(s).subtree).scalars.start;
        self.ncols * (self.node(s).scalars.end - first)
    }

    fn is_one_task(&self, s: usize, depth: usize) -> bool {
        let node = self.node(s);
        let end = node.panel + node.height() * node.width();
        (end - self.node(node.subtree).panel) * self.ncols < TASK_SCALARS || depth >= TASK_DEPTH
    }

    fn split<'b>(&self, nodes: &[usize], y: &'b mut [T]) -> Vec<(usize, &'b mut [T])> {
        let mut rest = y;
        let mut parts = Vec::with_capacity(nodes.len());
        for &s in nodes {
            let (own, tail) = rest.split_at_mut(self.subtree_len(s));
            parts.push((s, own));
            rest = tail;
        }
        parts
    }

    /// Solves with `L` in several subtrees; returns what each subtracts from the rows above it.
    fn forward_children(&self, nodes: &[usize], y: &mut [T], depth: usize) -> Vec<Vec<T>> {
        map(self.split(nodes, y), |(s, y)| {
            self.forward_subtree(s, y, depth)
        })
    }

    fn forward_subtree(&self, s: usize, y: &mut [T], depth: usize) -> Vec<T> {
        let node = self.node(s);
        if self.is_one_task(s, depth) {
            let mut stack: Vec<Vec<T>> = Vec::new();
            let mut rest = y;
            for t in node.subtree..=s {
                let node = self.node(t);
                let (own, tail) = rest.split_at_mut(self.ncols * node.width());
                rest = tail;
                let first = stack.len() - node.children.len();
                let rows = self.forward_front(node, own, &stack[first..]);
                stack.truncate(first);
                stack.push(rows);
            }
            return stack.pop().unwrap_or_default();
        }
        let (below, own) = y.split_at_mut(y.len() - self.ncols * node.width());
        let children: Vec<usize> = node.children.iter().map(|&c| c as usize).collect();
        let updates = self.forward_children(&children, below, depth + 1);
        self.forward_front(node, own, &updates)
    }

    fn forward_front(&self, node: &Supernode, own: &mut [T], updates: &[Vec<T>]) -> Vec<T> {
        let (width, height) = (node.width(), node.below);
        let mut rows = vec![T::from_f64(0.0); height * self.ncols];
        for (&child, update) in node.children.iter().zip(updates) {
            let child = self.node(child as usize);
            let child_height = child.below;
            for c in 0..self.ncols {
                for run in &child.runs {
                    let (from, to, len) = (run.from as usize, run.to as usize, run.len as usize);
                    let source = &update[c * child_height + from..][..len];
                    let target = if to < width {
                        &mut own[c * width + to..][..len]
                    } else {
                        &mut rows[c * height + to - width..][..len]
                    };
                    for (t, s) in target.iter_mut().zip(source) {
                        *t += *s;
                    }
                }
            }
        }
        let x = MatMut::from_column_major_slice_mut(own, width, self.ncols);
        let z = MatMut::from_column_major_slice_mut(&mut rows, height, self.ncols);
        T::forward(self.panel(node), width + height, width, x, z);
        rows
    }

    /// Solves with `Lᵀ` in several subtrees below a front that is solved.
    fn backward_children(
        &self,
        nodes: &[usize],
        y: &mut [T],
        parent: Option<Front<'_, T>>,
        depth: usize,
    ) {
        map(self.split(nodes, y), |(s, y)| {
            self.backward_subtree(s, y, parent, depth);
        })
    }

    fn backward_subtree(&self, s: usize, y: &mut [T], parent: Option<Front<'_, T>>, depth: usize) {
        let node = self.node(s);
        let (below, own) = y.split_at_mut(y.len() - self.ncols * node.width());
        let rows = self.backward_front(node, own, parent);
        if !self.is_one_task(s, depth) {
            let children: Vec<usize> = node.children.iter().map(|&c| c as usize).collect();
            self.backward_children(
                &children,
                below,
                Some(Front {
                    node,
                    own,
                    rows: &rows,
                }),
                depth + 1,
            );
            return;
        }
        // Parents before children: reverse postorder, every front's rows kept for its children.
        let first = node.subtree;
        let mut kept: Vec<Vec<T>> = vec![Vec::new(); s + 1 - first];
        kept[s - first] = rows;
        let start = self.node(first).scalars.start;
        for t in (first..s).rev() {
            let node = self.node(t);
            let above = self.node(node.parent as usize);
            let (head, tail) = y.split_at_mut(self.ncols * (node.scalars.end - start));
            let own_len = self.ncols * node.width();
            let own_begin = head.len() - own_len;
            let above_begin = self.ncols * (above.scalars.start - node.scalars.end);
            let front = Front {
                node: above,
                own: &tail[above_begin..above_begin + self.ncols * above.width()],
                rows: &kept[node.parent as usize - first],
            };
            let rows = self.backward_front(node, &mut head[own_begin..], Some(front));
            kept[t - first] = rows;
        }
    }

    fn backward_front(
        &self,
        node: &Supernode,
        own: &mut [T],
        parent: Option<Front<'_, T>>,
    ) -> Vec<T> {
        let (width, height) = (node.width(), node.below);
        let mut rows = vec![T::from_f64(0.0); height * self.ncols];
        if let Some(parent) = parent {
            let (parent_width, parent_height) = (parent.node.width(), parent.node.below);
            for c in 0..self.ncols {
                for run in &node.runs {
                    let (from, to, len) = (run.from as usize, run.to as usize, run.len as usize);
                    let source = if to < parent_width {
                        &parent.own[c * parent_width + to..][..len]
                    } else {
                        &parent.rows[c * parent_height + to - parent_width..][..len]
                    };
                    rows[c * height + from..][..len].copy_from_slice(source);
                }
            }
        }
        let x = MatMut::from_column_major_slice_mut(own, width, self.ncols);
        let z = MatRef::from_column_major_slice(&rows, height, self.ncols);
        T::backward(self.panel(node), width + height, width, x, z);
        rows
    }
}
