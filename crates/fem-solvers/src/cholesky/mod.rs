//! Sparse Cholesky factorization of symmetric positive definite block matrices.
//!
//! A node-block multifrontal method (Duff & Reid 1983, Liu 1992): the elimination tree of the block
//! graph is cut into supernodes, each owns a dense front, and all arithmetic happens in dense kernels.
//! Ordering and tree know blocks; fronts hold the scalars that are there, so that an absent scalar
//! ([`BlockPattern::with_absent`](crate::BlockPattern::with_absent)) costs neither memory nor arithmetic.

mod amalgamation;
mod dense;
mod eliminate;
mod elimination_tree;
mod factor;
mod fronts;
mod half;
mod pool;
mod refine;
mod scalars;
mod solve;
mod symbolic;

pub use dense::FactorScalar;
pub use factor::{CholeskyError, CholeskyFactor};
pub use refine::{RefineError, RefineInfo, RefineParams};
pub use symbolic::SymbolicCholesky;
