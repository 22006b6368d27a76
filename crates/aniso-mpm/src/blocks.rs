//! Sparse sets of grid blocks: memory follows the material, not the box around it.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Nodes in a block: 8×8 in 2D, 4×4×4 in 3D.
pub const BLOCK_NODES: usize = 64;

/// Blocks of nodes that one task handles.
pub(crate) const BLOCKS: usize = 4;

/// Nodes per axis of a block.
#[inline(always)]
pub const fn block_side(dimension: usize) -> usize {
    if dimension == 2 { 8 } else { 4 }
}

/// Blocks are numbered from `-REACH` to `REACH` on every axis; beyond lies no grid.
pub(crate) const REACH: i32 = 1 << 20;

/// The block that holds a node.
#[inline(always)]
pub(crate) fn block_of<const D: usize>(node: [i32; D]) -> [i32; D] {
    node.map(|i| i.div_euclid(block_side(D) as i32))
}

/// One number per block, in lexicographic order of the coordinates; `None` out of reach.
#[inline(always)]
pub(crate) fn key<const D: usize>(block: [i32; D]) -> Option<u64> {
    let mut key = 0;
    let mut inside = true;
    for a in 0..D {
        inside &= block[a] > -REACH && block[a] < REACH;
        key = (key << 21) | u64::from((block[a].wrapping_add(REACH) as u32) & 0x1f_ffff);
    }
    inside.then_some(key)
}

/// The inverse of [`key`].
#[inline(always)]
pub(crate) fn coordinates<const D: usize>(key: u64) -> [i32; D] {
    core::array::from_fn(|a| ((key >> (21 * (D - 1 - a))) & 0x1f_ffff) as i32 - REACH)
}

/// Fibonacci hashing; keys are already distinct integers.
#[derive(Clone, Copy, Default)]
pub(crate) struct KeyHasher(u64);
impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u64(u64::from(b));
        }
    }
    fn write_u64(&mut self, value: u64) {
        let mixed = (self.0 ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 29);
    }
}
pub(crate) type KeyMap = HashMap<u64, u32, BuildHasherDefault<KeyHasher>>;

/// A sorted set of blocks with a position for each.
#[derive(Clone, Debug, Default)]
pub struct BlockSet<const D: usize> {
    keys: Vec<u64>,
    slots: KeyMap,
}

impl<const D: usize> BlockSet<D> {
    /// The set of these keys, in any order and with repetitions; whether it is another than before.
    pub(crate) fn rebuild(&mut self, keys: impl Iterator<Item = u64>) -> bool {
        let mut keys: Vec<u64> = keys.collect();
        keys.sort_unstable();
        keys.dedup();
        if keys == self.keys {
            return false;
        }
        self.keys = keys;
        self.slots.clear();
        self.slots
            .extend(self.keys.iter().zip(0..).map(|(&k, slot)| (k, slot)));
        true
    }
    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.keys.len()
    }
    /// No block at all?
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }
    /// Coordinates of the block at a position.
    #[inline(always)]
    pub fn block(&self, slot: usize) -> [i32; D] {
        coordinates(self.keys[slot])
    }
    /// Position of a block in the set.
    #[inline(always)]
    pub fn slot(&self, block: [i32; D]) -> Option<usize> {
        key(block)
            .and_then(|k| self.slots.get(&k))
            .map(|&s| s as usize)
    }
    /// Position in a field (64 entries per block) of a node.
    pub fn node_index(&self, node: [i32; D]) -> Option<usize> {
        let side = block_side(D);
        let slot = self.slot(block_of(node))?;
        let mut local = 0;
        for a in 0..D {
            local = local * side + node[a].rem_euclid(side as i32) as usize;
        }
        Some(slot * BLOCK_NODES + local)
    }
    /// The node at a position in a field; inverse of [`BlockSet::node_index`].
    pub fn node(&self, index: usize) -> [i32; D] {
        let side = block_side(D);
        let block = self.block(index / BLOCK_NODES);
        let mut local = index % BLOCK_NODES;
        let mut node = [0; D];
        for a in (0..D).rev() {
            node[a] = block[a] * side as i32 + (local % side) as i32;
            local /= side;
        }
        node
    }
}
