//! The two halves of every transfer: particles add to a window of nodes, particles read one.
//!
//! The particles of one block reach `side + WIDTH − 1` nodes per axis. Scattering gives each block
//! a window of its own, then every block of nodes sums its part of the 2^D windows above it in a
//! fixed order: no two threads write the same number, and the bits do not depend on how many
//! there are. Gathering copies the window from the field first, so that particles read from L1.

use crate::binning::{Binning, NONE, corner};
use crate::blocks::{BLOCK_NODES, BLOCKS, block_side};
use crate::float::Float;
use crate::kernels::Spline;
use fem_kinematics::{Quad, QuadKernel, dispatch_quads};
use fem_solvers::parallel;
use std::marker::PhantomData;
use std::ops::Range;

/// Four numbers on a node; what they mean is the transfer's business.
pub type Node<T> = [T; 4];

/// Sorted particles handled by one task when gathering.
pub(crate) const CHUNK: usize = 1024;

/// What a particle adds to the nodes under it.
pub trait Scatter<T, const D: usize>: Sync {
    /// Adds particle `particle` to a window whose first node is `origin`; mark `#[inline(always)]`.
    /// `Q` holds one node in the registers of this processor.
    fn scatter<Q: Quad<T>>(&self, particle: usize, origin: [i32; D], window: &mut [Node<T>]);
}

/// What a particle does with the nodes under it.
pub trait Visit<T, const D: usize> {
    /// Particle `particle`, number `rank` in sorted order; mark `#[inline(always)]`.
    fn visit<Q: Quad<T>>(
        &mut self,
        rank: usize,
        particle: usize,
        origin: [i32; D],
        window: &[Node<T>],
    );
}

/// Position in a window of the first stencil node.
#[inline(always)]
pub fn window_start<K: Spline, const D: usize>(base: [i32; D], origin: [i32; D]) -> usize {
    let mut at = 0;
    for a in 0..D {
        at = at * Binning::<K, D>::reach() + (base[a] - origin[a]) as usize;
    }
    at
}

/// Position in a window of the row of stencil nodes along the last axis that is number `i` (and in
/// 3D `j`) on the other axes, for a stencil that begins at `start`.
#[inline(always)]
pub(crate) fn row_start<K: Spline, const D: usize>(start: usize, i: usize, j: usize) -> usize {
    let reach = Binning::<K, D>::reach();
    if D == 2 {
        start + i * reach
    } else {
        start + (i * reach + j) * reach
    }
}

/// The rows of stencil nodes along the last axis, for a stencil that begins at `start`: each
/// row's place in the window, and its place `i` (and in 3D `j`) in the stencil on the other axes.
///
/// An iterator and not a function that takes a closure: the body of a `for` loop is compiled with
/// the instructions of the kernel around it, a closure that is not inlined is not.
#[inline(always)]
pub fn rows<K: Spline, const D: usize>(start: usize) -> Rows<K, D> {
    Rows {
        start,
        i: 0,
        j: 0,
        kernel: PhantomData,
    }
}

/// See [`rows`].
#[derive(Clone, Debug)]
pub struct Rows<K, const D: usize> {
    start: usize,
    i: usize,
    j: usize,
    kernel: PhantomData<K>,
}
impl<K: Spline, const D: usize> Iterator for Rows<K, D> {
    type Item = (usize, usize, usize);
    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let (i, j) = (self.i, self.j);
        if i >= K::WIDTH {
            return None;
        }
        self.j += 1;
        if D == 2 || self.j == K::WIDTH {
            (self.i, self.j) = (i + 1, 0);
        }
        Some((row_start::<K, D>(self.start, i, j), i, j))
    }
}

struct FillWindow<'a, S, T, const D: usize> {
    task: &'a S,
    particles: &'a [u32],
    origin: [i32; D],
    window: &'a mut [Node<T>],
}
impl<T: Float, S: Scatter<T, D>, const D: usize> QuadKernel<T> for FillWindow<'_, S, T, D> {
    type Output = ();
    #[inline(always)]
    fn run<Q: Quad<T>>(self) {
        self.window.fill([T::zero(); 4]);
        for &p in self.particles {
            self.task.scatter::<Q>(p as usize, self.origin, self.window);
        }
    }
}

struct ReadWindow<'a, V, T, const D: usize> {
    visitor: &'a mut V,
    order: &'a [u32],
    ranks: Range<usize>,
    origin: [i32; D],
    window: &'a [Node<T>],
}
impl<T: Float, V: Visit<T, D>, const D: usize> QuadKernel<T> for ReadWindow<'_, V, T, D> {
    type Output = ();
    #[inline(always)]
    fn run<Q: Quad<T>>(self) {
        for rank in self.ranks {
            let p = self.order[rank] as usize;
            self.visitor.visit::<Q>(rank, p, self.origin, self.window);
        }
    }
}

impl<K: Spline, const D: usize> Binning<K, D> {
    fn window_len() -> usize {
        Self::reach().pow(D as u32)
    }

    fn origin(&self, home: usize) -> [i32; D] {
        self.homes.block(home).map(|b| b * block_side(D) as i32)
    }

    /// Entries of a field on the node blocks.
    pub fn field_len(&self) -> usize {
        self.nodes.len() * BLOCK_NODES
    }

    /// Sums what every particle adds into `field` (64 nodes per node block). `windows` is
    /// workspace. The same bits for any number of threads.
    pub fn scatter<T: Float, S: Scatter<T, D>>(
        &self,
        task: &S,
        windows: &mut Vec<Node<T>>,
        field: &mut Vec<Node<T>>,
    ) {
        let len = Self::window_len();
        windows.resize(self.homes.len() * len, [T::zero(); 4]);
        parallel::each(windows.chunks_mut(len).enumerate(), |(home, window)| {
            let ranks = self.starts[home] as usize..self.starts[home + 1] as usize;
            dispatch_quads(FillWindow {
                task,
                particles: &self.order[ranks],
                origin: self.origin(home),
                window,
            });
        });
        field.resize(self.field_len(), [T::zero(); 4]);
        let windows = &windows[..];
        let sources = self.sources.chunks(BLOCKS);
        let tasks = field.chunks_mut(BLOCKS * BLOCK_NODES).zip(sources);
        parallel::each(tasks, |(blocks, sources)| {
            for (block, sources) in blocks.chunks_mut(BLOCK_NODES).zip(sources) {
                block.fill([T::zero(); 4]);
                for (n, &home) in sources.iter().enumerate().take(1 << D) {
                    if home != NONE {
                        let window = &windows[home as usize * len..(home as usize + 1) * len];
                        Self::overlap(n, |from, to, count| {
                            for (sum, add) in block[to..to + count]
                                .iter_mut()
                                .zip(&window[from..from + count])
                            {
                                for c in 0..4 {
                                    sum[c] += add[c];
                                }
                            }
                        });
                    }
                }
            }
        });
    }

    /// Rows that the window of a block shares with the node block at its corner `n`:
    /// `row(start in the window, start in the block, length)`.
    #[inline(always)]
    fn overlap(n: usize, mut row: impl FnMut(usize, usize, usize)) {
        let side = block_side(D);
        let reach = Self::reach();
        let shift: [usize; D] = corner::<D>(n).map(|c| c as usize * side);
        let extent: [usize; D] = shift.map(|s| side.min(reach - s));
        if D == 2 {
            for i in 0..extent[0] {
                row((i + shift[0]) * reach + shift[1], i * side, extent[1]);
            }
        } else {
            for i in 0..extent[0] {
                for j in 0..extent[1] {
                    row(
                        ((i + shift[0]) * reach + j + shift[1]) * reach + shift[D - 1],
                        (i * side + j) * side,
                        extent[D - 1],
                    );
                }
            }
        }
    }

    /// Shows each of the sorted particles in `ranks` its window of `field`.
    pub(crate) fn visit<T: Float, V: Visit<T, D>>(
        &self,
        field: &[Node<T>],
        ranks: Range<usize>,
        visitor: &mut V,
    ) {
        let len = Self::window_len();
        let mut window = vec![[T::zero(); 4]; len];
        let mut home = self.starts.partition_point(|&s| s as usize <= ranks.start) - 1;
        let mut rank = ranks.start;
        while rank < ranks.end {
            let end = (self.starts[home + 1] as usize).min(ranks.end);
            for (n, &slot) in self.neighbors[home].iter().enumerate().take(1 << D) {
                let block = &field[slot as usize * BLOCK_NODES..(slot as usize + 1) * BLOCK_NODES];
                Self::overlap(n, |to, from, count| {
                    window[to..to + count].copy_from_slice(&block[from..from + count]);
                });
            }
            dispatch_quads(ReadWindow {
                visitor,
                order: &self.order,
                ranks: rank..end,
                origin: self.origin(home),
                window: &window,
            });
            rank = end;
            home += 1;
        }
    }

    /// One value for every particle, read from the nodes under it; in the particles' own order.
    pub fn gather<T: Float, R, G>(&self, field: &[Node<T>], read: &G) -> Vec<R>
    where
        R: Copy + Default + Send,
        G: Gather<T, D, Output = R>,
    {
        let mut sorted = vec![R::default(); self.order.len()];
        parallel::each(sorted.chunks_mut(CHUNK).enumerate(), |(chunk, out)| {
            let first = chunk * CHUNK;
            let ranks = first..first + out.len();
            self.visit(field, ranks, &mut Collect { read, first, out });
        });
        let mut result = vec![R::default(); sorted.len()];
        for (&p, value) in self.order.iter().zip(sorted) {
            result[p as usize] = value;
        }
        result
    }
}

/// What a particle reads from the nodes under it.
pub trait Gather<T, const D: usize>: Sync {
    /// The value read.
    type Output;
    /// Reads for particle `particle` from a window whose first node is `origin`; mark
    /// `#[inline(always)]`.
    fn gather<Q: Quad<T>>(
        &self,
        particle: usize,
        origin: [i32; D],
        window: &[Node<T>],
    ) -> Self::Output;
}

struct Collect<'a, G, R> {
    read: &'a G,
    first: usize,
    out: &'a mut [R],
}
impl<T: Copy, R, G: Gather<T, D, Output = R>, const D: usize> Visit<T, D> for Collect<'_, G, R> {
    #[inline(always)]
    fn visit<Q: Quad<T>>(
        &mut self,
        rank: usize,
        particle: usize,
        origin: [i32; D],
        window: &[Node<T>],
    ) {
        self.out[rank - self.first] = self.read.gather::<Q>(particle, origin, window);
    }
}
