//! Multigrid for the near kernel of what moves in space, its translations and rotations, behind a `dyn`.

use super::{DescentDirection, MultigridDirection};
use crate::multigrid::MultigridParams;
use std::any::Any;

/// The direction for `motions` vectors of near kernel, where these are the rigid motions of space. In the
/// plane a factor moves less than a hierarchy up to millions of nodes.
///
/// It is made by a function without type parameters: its hierarchies are compiled with this crate, once,
/// not for whatever problem Newton's method meets.
pub(super) fn multigrid<const D: usize>(motions: usize) -> Option<Box<dyn DescentDirection<D>>> {
    if (D, motions) != (3, 6) {
        return None;
    }
    // `D` is 3, as the compiler cannot know.
    let made: Box<dyn Any> = Box::new(in_space());
    made.downcast().ok().map(|boxed| *boxed)
}

fn in_space() -> Box<dyn DescentDirection<3>> {
    let params = MultigridParams::default();
    Box::new(MultigridDirection::<3, 6>::new(params))
}

#[cfg(test)]
mod tests {
    use super::multigrid;

    #[test]
    fn rigid_motions_of_space_have_a_hierarchy() {
        assert!(multigrid::<3>(6).is_some());
        assert!(multigrid::<3>(3).is_none());
        assert!(multigrid::<2>(3).is_none());
        assert!(multigrid::<6>(6).is_none());
    }
}
