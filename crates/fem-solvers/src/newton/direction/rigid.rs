//! Multigrid for bodies, whose near kernel are the motions that strain nothing, behind a `dyn`.

use super::{DescentDirection, MultigridDirection};
use crate::multigrid::MultigridParams;
use std::any::Any;

/// The direction for `motions` vectors of near kernel, where these are the rigid motions of the plane or
/// of space.
///
/// Both are made by functions without type parameters: their hierarchies are compiled with this crate,
/// once, not for whatever problem Newton's method meets.
pub(super) fn multigrid<const D: usize>(motions: usize) -> Option<Box<dyn DescentDirection<D>>> {
    let made: Box<dyn Any> = match (D, motions) {
        (2, 3) => Box::new(in_the_plane()),
        (3, 6) => Box::new(in_space()),
        _ => return None,
    };
    // `D` is the one that the arm above says.
    made.downcast().ok().map(|boxed| *boxed)
}

fn in_the_plane() -> Box<dyn DescentDirection<2>> {
    let params = MultigridParams::default();
    Box::new(MultigridDirection::<2, 3>::new(params))
}

fn in_space() -> Box<dyn DescentDirection<3>> {
    let params = MultigridParams::default();
    Box::new(MultigridDirection::<3, 6>::new(params))
}

#[cfg(test)]
mod tests {
    use super::multigrid;

    #[test]
    fn the_rigid_motions_of_the_plane_and_of_space_have_hierarchies() {
        assert!(multigrid::<2>(3).is_some());
        assert!(multigrid::<3>(6).is_some());
        assert!(multigrid::<1>(1).is_none());
        assert!(multigrid::<2>(2).is_none());
        assert!(multigrid::<2>(6).is_none());
        assert!(multigrid::<3>(3).is_none());
    }
}
