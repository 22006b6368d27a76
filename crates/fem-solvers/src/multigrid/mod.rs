//! Smoothed-aggregation multigrid (Vaněk, Mandel and Brezina 1996) as a preconditioner.
//!
//! Rows that are strongly coupled are gathered in aggregates. On each aggregate the vectors that the
//! matrix nearly takes to zero, made orthonormal, are the unknowns of a coarser matrix; one damped
//! Jacobi step makes them smooth, and `Pᵀ A P` is the coarser matrix, of which the same is done again.

mod aggregation;
mod entry;
mod galerkin;
mod hierarchy;
mod level;
mod matrix;
mod near_kernel;
mod precision;
mod prolongator;
mod rows;
mod several;
mod smoother;
mod spectrum;
mod tentative;

pub use hierarchy::{Multigrid, MultigridInfo, MultigridParams};
pub use near_kernel::{NearKernel, NearKernelError};
pub use precision::LevelScalar;
pub use several::{SolveManyInfo, SolveManyParams};
