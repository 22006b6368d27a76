//! Approximate inverses for conjugate gradients.

mod block_ic0;
mod block_jacobi;
mod identity;

pub use block_ic0::BlockIc0;
pub use block_jacobi::{BlockJacobi, PreconditionerError};
pub use identity::Identity;
