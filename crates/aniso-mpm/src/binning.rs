//! Particles sorted by grid block: the order in which every transfer runs.
//!
//! A counting sort, stable, so that the order (and with it every sum on the grid) depends on the
//! particles alone and not on the number of threads.

use crate::blocks::{self, BlockSet, block_of, block_side};
use crate::error::MpmError;
use crate::float::{Float, all_finite};
use crate::kernels::{Spline, locate};
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
    keys: Vec<u64>,
    slots: Vec<u32>,
    kernel: PhantomData<K>,
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
            keys: Vec::new(),
            slots: Vec::new(),
            kernel: PhantomData,
        }
    }

    /// Sorts the particles at `x` (m), keeping the allocations of the last call.
    ///
    /// # Errors
    /// A position that is not finite or farther than 2²⁰ blocks from the origin.
    pub fn rebuild<T: Float>(&mut self, x: &[[T; D]]) -> Result<(), MpmError> {
        self.find_keys(x);
        let seen = self.find_blocks(x)?;
        self.homes.rebuild(seen.iter().copied());
        let rank: Vec<u32> = seen
            .iter()
            .map(|&k| {
                self.homes
                    .slot(blocks::coordinates(k))
                    .map_or(NONE, |s| s as u32)
            })
            .collect();
        self.sort(&rank);
        self.link();
        Ok(())
    }

    /// The key of every particle's block; `u64::MAX` for one that has none.
    fn find_keys<T: Float>(&mut self, x: &[[T; D]]) {
        const CHUNK: usize = 4096;
        let h = T::from_f64(self.h);
        self.keys.resize(x.len(), 0);
        parallel::each(
            self.keys.chunks_mut(CHUNK).zip(x.chunks(CHUNK)),
            |(keys, x)| {
                for (key, x) in keys.iter_mut().zip(x) {
                    let block = block_of(locate::<K, T, D>(x, h).0);
                    *key = if all_finite(x) {
                        blocks::key(block).unwrap_or(u64::MAX)
                    } else {
                        u64::MAX
                    };
                }
            },
        );
    }

    /// The keys of all blocks in the order in which particles name them; `slots` gets the place of each
    /// particle's block among them.
    fn find_blocks<T: Float>(&mut self, x: &[[T; D]]) -> Result<Vec<u64>, MpmError> {
        // Neighbors in memory are mostly neighbors in space: look a block up when it changes.
        let mut found = blocks::KeyMap::default();
        let mut seen = Vec::new();
        self.slots.clear();
        self.slots.reserve(x.len());
        let mut last = (u64::MAX, NONE);
        for (p, &key) in self.keys.iter().enumerate() {
            if key != last.0 {
                let next = seen.len() as u32;
                let slot = *found.entry(key).or_insert_with(|| {
                    seen.push(key);
                    next
                });
                last = (key, slot);
            }
            if key == u64::MAX {
                return Err(MpmError::ParticleOffGrid {
                    particle: p,
                    position: x[p].iter().map(|v| v.to_f64()).collect(),
                });
            }
            self.slots.push(last.1);
        }
        Ok(seen)
    }

    /// Sorts the particles by home, given the home of each block that was found.
    fn sort(&mut self, rank: &[u32]) {
        self.starts.clear();
        self.starts.resize(self.homes.len() + 1, 0);
        for slot in &mut self.slots {
            *slot = rank[*slot as usize];
            self.starts[*slot as usize + 1] += 1;
        }
        for b in 0..self.homes.len() {
            self.starts[b + 1] += self.starts[b];
        }
        let mut cursor = self.starts.clone();
        self.order.resize(self.slots.len(), 0);
        for (p, &slot) in self.slots.iter().enumerate() {
            let at = &mut cursor[slot as usize];
            self.order[*at as usize] = p as u32;
            *at += 1;
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
