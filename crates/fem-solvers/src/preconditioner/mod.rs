//! Approximate inverses for conjugate gradients.

mod block_ic0;
mod block_jacobi;
mod identity;

pub use block_ic0::BlockIc0;
pub use block_jacobi::{BlockJacobi, PreconditionerError};
pub use identity::Identity;

#[cfg(test)]
mod tests {
    use super::{BlockIc0, BlockJacobi};
    use crate::block_matrix::{BlockPattern, BlockSymmetric};
    use crate::operator::{MatrixPreconditioner, Preconditioner};
    use std::sync::Arc;

    /// A chain of 2×2 blocks; `pull` from 4 on makes it indefinite, and IC(0) shift.
    fn chain(blocks: usize, pull: f64) -> BlockSymmetric<2> {
        let pairs = (1..blocks).map(|i| (i - 1, i)).chain([(0, blocks - 1)]);
        let pattern = Arc::new(BlockPattern::from_adjacency(blocks, pairs).unwrap());
        let mut a = BlockSymmetric::zeros(pattern);
        a.values_mut().fill([[-pull, 0.5], [0.0, -pull]]);
        for i in 0..blocks {
            let d = a.pattern().diagonal(i);
            a.values_mut()[d] = [[6.0 + i as f64, 1.0], [1.0, 7.0]];
        }
        a
    }

    fn applied(m: &impl Preconditioner, n: usize) -> Vec<f64> {
        let r: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut z = vec![0.0; n];
        m.apply(&r, &mut z);
        z
    }

    #[test]
    fn an_update_is_a_new_one_in_the_same_memory() {
        let (mut ic, mut jacobi) = (BlockIc0::default(), BlockJacobi::default());
        let mut memory = None;
        for (blocks, pull) in [(9, 1.0), (9, 5.0), (9, 2.0), (5, 0.5), (9, 1.0)] {
            let a = chain(blocks, pull);
            ic.update(&a).unwrap();
            jacobi.update(&a).unwrap();
            let (new_ic, new_jacobi) = (BlockIc0::new(&a).unwrap(), BlockJacobi::new(&a).unwrap());
            assert_eq!(ic.shift(), new_ic.shift());
            assert_eq!(ic.shift() > 0.0, pull > 4.0, "{}", ic.shift());
            assert_eq!(applied(&ic, 2 * blocks), applied(&new_ic, 2 * blocks));
            assert_eq!(
                applied(&jacobi, 2 * blocks),
                applied(&new_jacobi, 2 * blocks)
            );
            let now = (ic.memory(), jacobi.memory());
            assert_eq!(*memory.get_or_insert(now), now);
        }
    }
}
