//! Particles sorted by grid block: the order in which every transfer runs.
//!
//! A counting sort, stable, so that the order (and with it every sum on the grid) depends on the
//! particles alone and not on the number of threads.

use crate::blocks::{self, BlockSet, block_of, block_side};
use crate::error::MpmError;
use crate::float::{Float, all_finite};
use crate::kernels::{Spline, locate};
use crate::stencil::load_axes;
use fem_kinematics::{Quad, QuadKernel, dispatch_quads};
use fem_solvers::parallel;
use std::marker::PhantomData;

/// No block at this place.
pub(crate) const NONE: u32 = u32::MAX;

/// Which particle lies in which block, and which blocks of nodes they touch.
#[derive(Clone, Debug)]
pub struct Binning<K, const D: usize> {
    /// Cell size h, m.
    pub(crate) h: f64,
    /// Particles, block after block.
    pub(crate) order: Vec<u32>,
    /// Where each block's particles begin in `order`; one more entry than blocks.
    pub(crate) starts: Vec<u32>,
    /// Blocks that hold the first stencil node of some particle.
    pub(crate) homes: BlockSet<D>,
    /// Blocks that hold a node under some particle.
    pub(crate) nodes: BlockSet<D>,
    /// For each home its 2^D node blocks.
    pub(crate) neighbors: Vec<[u32; 8]>,
    /// For each node block the 2^D homes that reach into it, or [`NONE`].
    pub(crate) sources: Vec<[u32; 8]>,
    kernel: PhantomData<K>,
}

/// Particles in a row that lie in one block. A step leaves the particles in the order of their blocks,
/// so that most of them do not begin a run, and what is done for each run is done rarely.
struct Run {
    /// The block's key; `u64::MAX` where there is none.
    key: u64,
    count: u32,
    /// The place of the block among those found.
    slot: u32,
}

/// The block offset number `n` of 2^D: bit a of n (from the top axis) on axis a.
#[inline(always)]
pub(crate) fn corner<const D: usize>(n: usize) -> [i32; D] {
    core::array::from_fn(|a| ((n >> (D - 1 - a)) & 1) as i32)
}

impl<K: Spline, const D: usize> Binning<K, D> {
    /// An empty binning on a grid of cell size `h` (m).
    pub fn new(h: f64) -> Self {
        Self {
            h,
            order: Vec::new(),
            starts: vec![0],
            homes: BlockSet::default(),
            nodes: BlockSet::default(),
            neighbors: Vec::new(),
            sources: Vec::new(),
            kernel: PhantomData,
        }
    }

    /// Sorts the particles at `x` (m), keeping the allocations of the last call.
    ///
    /// # Errors
    /// A position that is not finite or farther than 2²⁰ blocks from the origin.
    pub fn rebuild<T: Float>(&mut self, x: &[[T; D]]) -> Result<(), MpmError> {
        let mut runs = self.find_runs(x);
        let seen = Self::find_blocks(x, &mut runs)?;
        let other_homes = self.homes.rebuild(seen.iter().copied());
        let rank: Vec<u32> = seen
            .iter()
            .map(|&k| {
                self.homes
                    .slot(blocks::coordinates(k))
                    .map_or(NONE, |s| s as u32)
            })
            .collect();
        self.sort(&runs, &rank, x.len());
        // Most steps move particles between blocks that others are in already.
        if other_homes {
            self.link();
        }
        Ok(())
    }

    /// The particles' blocks, run by run.
    fn find_runs<T: Float>(&self, x: &[[T; D]]) -> Vec<Vec<Run>> {
        const CHUNK: usize = 4096;
        let h = T::from_f64(self.h);
        let kernel = self.kernel;
        parallel::map(x.chunks(CHUNK).collect(), |x| {
            dispatch_quads(FindRuns { x, h, kernel })
        })
    }

    /// The keys of all blocks in the order in which particles name them; each run gets the place of its
    /// block among them.
    fn find_blocks<T: Float>(x: &[[T; D]], runs: &mut [Vec<Run>]) -> Result<Vec<u64>, MpmError> {
        let mut found = blocks::KeyMap::default();
        let mut seen = Vec::new();
        let mut first = 0;
        for run in runs.iter_mut().flatten() {
            if run.key == u64::MAX {
                return Err(MpmError::ParticleOffGrid {
                    particle: first,
                    position: x[first].iter().map(|v| v.to_f64()).collect(),
                });
            }
            first += run.count as usize;
            let next = seen.len() as u32;
            run.slot = *found.entry(run.key).or_insert_with(|| {
                seen.push(run.key);
                next
            });
        }
        Ok(seen)
    }

    /// Sorts the particles by home, given the home of each block that was found.
    fn sort(&mut self, runs: &[Vec<Run>], rank: &[u32], count: usize) {
        self.starts.clear();
        self.starts.resize(self.homes.len() + 1, 0);
        for run in runs.iter().flatten() {
            self.starts[rank[run.slot as usize] as usize + 1] += run.count;
        }
        for b in 0..self.homes.len() {
            self.starts[b + 1] += self.starts[b];
        }
        let mut cursor = self.starts.clone();
        self.order.resize(count, 0);
        let mut first = 0;
        for run in runs.iter().flatten() {
            let at = &mut cursor[rank[run.slot as usize] as usize];
            let places = &mut self.order[*at as usize..][..run.count as usize];
            for (p, place) in (first..).zip(places) {
                *place = p;
            }
            *at += run.count;
            first += run.count;
        }
    }

    /// Finds the node blocks of every home and the homes of every node block.
    fn link(&mut self) {
        let corners = 1 << D;
        let shifted = |block: [i32; D], n: usize, sign: i32| -> [i32; D] {
            let c = corner::<D>(n);
            core::array::from_fn(|a| block[a] + sign * c[a])
        };
        let homes = &self.homes;
        self.nodes.rebuild((0..homes.len()).flat_map(|s| {
            (0..corners).filter_map(move |n| blocks::key(shifted(homes.block(s), n, 1)))
        }));
        let slot_of = |set: &BlockSet<D>, block| set.slot(block).map_or(NONE, |s| s as u32);
        self.neighbors.clear();
        self.neighbors.extend((0..self.homes.len()).map(|s| {
            let block = self.homes.block(s);
            core::array::from_fn(|n| {
                if n < corners {
                    slot_of(&self.nodes, shifted(block, n, 1))
                } else {
                    NONE
                }
            })
        }));
        self.sources.clear();
        self.sources.extend((0..self.nodes.len()).map(|s| {
            let block = self.nodes.block(s);
            core::array::from_fn(|n| {
                if n < corners {
                    slot_of(&self.homes, shifted(block, n, -1))
                } else {
                    NONE
                }
            })
        }));
    }

    /// Cell size h, m.
    pub fn cell_size(&self) -> f64 {
        self.h
    }
    /// Particle indices, block after block.
    pub fn order(&self) -> &[u32] {
        &self.order
    }
    /// The blocks that carry grid fields.
    pub fn node_blocks(&self) -> &BlockSet<D> {
        &self.nodes
    }
    /// Nodes per axis that the particles of one block reach.
    #[inline(always)]
    pub(crate) const fn reach() -> usize {
        block_side(D) + K::WIDTH - 1
    }
}

struct FindRuns<'a, T, K, const D: usize> {
    x: &'a [[T; D]],
    h: T,
    kernel: PhantomData<K>,
}
impl<T: Float, K: Spline, const D: usize> QuadKernel<T> for FindRuns<'_, T, K, D> {
    type Output = Vec<Run>;
    #[inline(always)]
    fn run<Q: Quad<T>>(self) -> Vec<Run> {
        let (zero, h) = (Q::splat(T::zero()), Q::splat(self.h));
        let shift = Q::splat(T::from_f64(K::SHIFT));
        let per_side = Q::splat(T::from_f64(1.0 / block_side(D) as f64));
        let mut runs: Vec<Run> = Vec::new();
        // No block is equal to NaN.
        let none = Q::splat(T::from_f64(f64::NAN));
        let (mut last, mut key, mut count) = (none, u64::MAX, 0);
        for x in self.x {
            // The block of `kernels::locate`: a product with a power of two is exact.
            let node = (load_axes::<Q, T, D>(x) / h - shift).floor();
            let block = (node * per_side).floor();
            if !(block - last).abs().all_at_most(zero) {
                let slot = NONE;
                if count > 0 {
                    runs.push(Run { key, count, slot });
                }
                key = key_of::<K, T, D>(x, self.h);
                // Nothing joins what has no block.
                last = if key == u64::MAX { none } else { block };
                count = 0;
            }
            count += 1;
        }
        let slot = NONE;
        runs.push(Run { key, count, slot });
        runs
    }
}

/// The key of the block of a particle; `u64::MAX` for one that has none.
fn key_of<K: Spline, T: Float, const D: usize>(x: &[T; D], h: T) -> u64 {
    if all_finite(x) {
        blocks::key(block_of(locate::<K, T, D>(x, h).0)).unwrap_or(u64::MAX)
    } else {
        u64::MAX
    }
}
