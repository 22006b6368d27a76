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
    /// Adds these particles in their order; to be written anew where something serves all of them.
    #[inline(always)]
    fn scatter_all<Q: Quad<T>>(&self, particles: &[u32], origin: [i32; D], window: &mut [Node<T>]) {
        for &p in particles {
            self.scatter::<Q>(p as usize, origin, window);
        }
    }
}

/// What particles do with the nodes under them.
pub trait Visit<T, const D: usize> {
    /// The particles of one block in sorted order, the first of them number `rank`; mark
    /// `#[inline(always)]`.
    fn visit<Q: Quad<T>>(
        &mut self,
        rank: usize,
        particles: &[u32],
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
        self.task
            .scatter_all::<Q>(self.particles, self.origin, self.window);
    }
}

struct SumWindows<'a, T, K, const D: usize> {
    blocks: &'a mut [Node<T>],
    sources: &'a [[u32; 8]],
    windows: &'a [Node<T>],
    kernel: PhantomData<K>,
}
impl<T: Float, K: Spline, const D: usize> QuadKernel<T> for SumWindows<'_, T, K, D> {
    type Output = ();
    #[inline(always)]
    fn run<Q: Quad<T>>(self) {
        let (side, reach) = (block_side(D), Binning::<K, D>::reach());
        let len = Binning::<K, D>::window_len();
        for (block, sources) in self.blocks.chunks_mut(BLOCK_NODES).zip(self.sources) {
            block.fill([T::zero(); 4]);
            for (n, &home) in sources.iter().enumerate().take(1 << D) {
                if home == NONE {
                    continue;
                }
                let window = &self.windows[home as usize * len..][..len];
                let overlap = Overlap::<D>::new::<K>(n);
                for i in 0..overlap.planes {
                    let (of_window, of_block) = overlap.plane::<K>(i);
                    let rows = block[of_block].chunks_exact_mut(side);
                    for (sums, add) in rows.zip(window[of_window].chunks_exact(reach)) {
                        if overlap.far {
                            add_row::<Q, T>(&mut sums[..reach - side], &add[side..]);
                        } else {
                            add_row::<Q, T>(sums, &add[..side]);
                        }
                    }
                }
            }
        }
    }
}

struct ReadWindow<'a, V, T, K, const D: usize> {
    visitor: &'a mut V,
    binning: &'a Binning<K, D>,
    field: &'a [Node<T>],
    home: usize,
    ranks: Range<usize>,
    /// Workspace.
    window: &'a mut [Node<T>],
}
impl<T: Float, V: Visit<T, D>, K: Spline, const D: usize> QuadKernel<T>
    for ReadWindow<'_, V, T, K, D>
{
    type Output = ();
    #[inline(always)]
    fn run<Q: Quad<T>>(self) {
        let (window, binning) = (self.window, self.binning);
        let (side, reach) = (block_side(D), Binning::<K, D>::reach());
        let neighbors = &binning.neighbors[self.home];
        for (n, &slot) in neighbors.iter().enumerate().take(1 << D) {
            let block = &self.field[slot as usize * BLOCK_NODES..][..BLOCK_NODES];
            let overlap = Overlap::<D>::new::<K>(n);
            for i in 0..overlap.planes {
                let (of_window, of_block) = overlap.plane::<K>(i);
                let rows = window[of_window].chunks_exact_mut(reach);
                for (nodes, from) in rows.zip(block[of_block].chunks_exact(side)) {
                    if overlap.far {
                        copy_row::<Q, T>(&mut nodes[side..], &from[..reach - side]);
                    } else {
                        copy_row::<Q, T>(&mut nodes[..side], from);
                    }
                }
            }
        }
        let origin = binning.origin(self.home);
        let (first, particles) = (self.ranks.start, &binning.order[self.ranks]);
        self.visitor.visit::<Q>(first, particles, origin, window);
    }
}

/// Both halves of a row have a length that the compiler knows, and no loop is left.
#[inline(always)]
fn add_row<Q: Quad<T>, T: Float>(to: &mut [Node<T>], from: &[Node<T>]) {
    for (to, from) in to.iter_mut().zip(from) {
        (Q::load(to) + Q::load(from)).store(to);
    }
}

#[inline(always)]
fn copy_row<Q: Quad<T>, T: Float>(to: &mut [Node<T>], from: &[Node<T>]) {
    for (to, from) in to.iter_mut().zip(from) {
        Q::load(from).store(to);
    }
}

/// The rows that the window of a block shares with the node block at one of its corners.
struct Overlap<const D: usize> {
    /// Rows in a plane (in 2D the planes are the rows).
    lines: usize,
    planes: usize,
    /// Number of the first row in the window.
    first: usize,
    /// Beyond the window's own block on the last axis: rows have not a whole side of nodes, but what the
    /// kernel reaches.
    far: bool,
}

impl<const D: usize> Overlap<D> {
    /// At corner number n.
    #[inline(always)]
    fn new<K: Spline>(n: usize) -> Self {
        let (side, reach) = (block_side(D), Binning::<K, D>::reach());
        let corner = corner::<D>(n);
        let extent = |far: i32| if far == 0 { side } else { reach - side };
        let shift = |far: i32| if far == 0 { 0 } else { side };
        let (mut lines, mut first) = (1, shift(corner[0]));
        if D == 3 {
            lines = extent(corner[1]);
            first = first * reach + shift(corner[1]);
        }
        Self {
            lines,
            planes: extent(corner[0]),
            first,
            far: corner[D - 1] != 0,
        }
    }

    /// Nodes of the window and of the block that hold the shared rows of plane number i: whole rows of
    /// either.
    #[inline(always)]
    fn plane<K: Spline>(&self, i: usize) -> (Range<usize>, Range<usize>) {
        let (side, reach) = (block_side(D), Binning::<K, D>::reach());
        let (mut in_window, mut in_block) = (i, i);
        if D == 3 {
            (in_window, in_block) = (i * reach, i * side);
        }
        let (from, to) = ((self.first + in_window) * reach, in_block * side);
        (from..from + self.lines * reach, to..to + self.lines * side)
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
            dispatch_quads(SumWindows::<T, K, D> {
                blocks,
                sources,
                windows,
                kernel: PhantomData,
            });
        });
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
            dispatch_quads(ReadWindow {
                visitor,
                binning: self,
                field,
                home,
                ranks: rank..end,
                window: &mut window,
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
        particles: &[u32],
        origin: [i32; D],
        window: &[Node<T>],
    ) {
        for (out, &p) in self.out[rank - self.first..].iter_mut().zip(particles) {
            *out = self.read.gather::<Q>(p as usize, origin, window);
        }
    }
}
