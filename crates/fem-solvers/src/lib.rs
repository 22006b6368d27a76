//! Solvers on slices of `f64`: they know matrices, energies and residuals, and no mesh.
//!
//! | to solve | use |
//! |---|---|
//! | `A x = b`, `A` a block matrix | [`CholeskyFactor`], once per matrix, on a [`SymbolicCholesky`] made once per pattern |
//! | `A x = b`, `A` only known by its product | [`pcg()`], [`pcg_semidefinite`] with a [`Preconditioner`] |
//! | the same for a large block matrix with a known near kernel | [`pcg()`] on a [`Multigrid`] hierarchy |
//! | `min E(x)` | [`Newton`] on a [`NonlinearProblem`] |
//! | a way too long for one solve | [`follow_path`] along a [`Path`], [`walk_load`] for a load |
//! | `min ½‖r(θ)‖²`, bounds, priors, outliers | [`gauss_newton()`] on a [`LeastSquares`] problem |
//!
//! Matrices are symmetric, in D×D blocks, lower half stored ([`BlockSymmetric`]). What is claimed of
//! them is data ([`Structure`]), and solvers insist on it. Whatever fails is an error with the place,
//! the numbers reached and the reason, and the caller's vector holds the last good state; NaN never
//! passes. Sums are added in an order that does not depend on the number of threads: same input,
//! same bits.
//!
//! ```
//! use fem_solvers::*;
//! use std::sync::Arc;
//!
//! /// A chain of springs of rest length 1 between a wall at 0 and a force at the far end.
//! struct Chain(Arc<BlockPattern>);
//!
//! impl NonlinearProblem<1> for Chain {
//!     fn blocks(&self) -> usize { self.0.blocks() }
//!     fn pattern(&self) -> Option<Arc<BlockPattern>> { Some(self.0.clone()) }
//!     fn energy(&self, x: &[f64]) -> f64 {
//!         let stretch = |i: usize| x[i] - if i > 0 { x[i - 1] } else { 0.0 } - 1.0;
//!         (0..x.len()).map(|i| 0.5 * stretch(i).powi(2) + 0.25 * stretch(i).powi(4)).sum::<f64>() - 2.0 * x[x.len() - 1]
//!     }
//!     fn gradient(&self, x: &[f64], g: &mut [f64]) {
//!         g.fill(0.0);
//!         for i in 0..x.len() {
//!             let s = x[i] - if i > 0 { x[i - 1] } else { 0.0 } - 1.0;
//!             g[i] += s + s.powi(3);
//!             if i > 0 { g[i - 1] -= s + s.powi(3); }
//!         }
//!         g[x.len() - 1] -= 2.0;
//!     }
//!     fn hessian(&self, x: &[f64], _: HessianProjection, out: &mut BlockSymmetric<1>) {
//!         out.values_mut().fill([[0.0]]);
//!         for i in 0..x.len() {
//!             let s = x[i] - if i > 0 { x[i - 1] } else { 0.0 } - 1.0;
//!             let k = 1.0 + 3.0 * s * s;
//!             let d = self.0.diagonal(i);
//!             out.values_mut()[d][0][0] += k;
//!             if i > 0 {
//!                 out.values_mut()[d - 1][0][0] -= k;
//!                 let before = self.0.diagonal(i - 1);
//!                 out.values_mut()[before][0][0] += k;
//!             }
//!         }
//!     }
//! }
//!
//! let pattern = BlockPattern::from_adjacency(5, (1..5).map(|i| (i - 1, i)))?;
//! let chain = Chain(Arc::new(pattern));
//! let mut x = vec![1.0, 2.0, 3.0, 4.0, 5.0];
//! let info = Newton::new(&chain).solve(&chain, &mut x, &NewtonParams::default())?;
//! // Every spring carries s + s³ = 2, so s = 1.
//! assert!((x[4] - 10.0).abs() < 1e-6 && info.iterations < 10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// A comparison with NaN is false: `!(a < b)` sends NaN where failures go.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod block_matrix;
mod cholesky;
mod continuation;
mod dense_qr;
mod gauss_newton;
mod multigrid;
mod newton;
mod operator;
mod ordering;
pub mod parallel;
mod pcg;
mod preconditioner;
mod small;
mod tall_qr;
mod vector;

pub use block_matrix::{BlockPattern, BlockSymmetric, PatternError};
pub use cholesky::{
    CholeskyError, CholeskyFactor, FactorScalar, RefineError, RefineInfo, RefineParams,
    SymbolicCholesky,
};
pub use continuation::{
    ContinuationError, ContinuationInfo, ContinuationParams, Path, follow_path, walk_load,
};
pub use gauss_newton::{
    Bounds, Damping, GaussNewtonError, GaussNewtonFailure, GaussNewtonInfo, GaussNewtonIteration,
    GaussNewtonParams, GaussNewtonStop, LeastSquares, Loss, Prior, StepMethod, gauss_newton,
    gauss_newton_observed,
};
pub use multigrid::{
    LevelScalar, Multigrid, MultigridInfo, MultigridParams, NearKernel, NearKernelError,
    SolveManyInfo, SolveManyParams,
};
pub use newton::{
    Descent, DescentDirection, DescentOutcome, HessianProjection, LineSearchParams, LinearSolver,
    Merit, MultigridDirection, Newton, NewtonError, NewtonFailure, NewtonInfo, NewtonIteration,
    NewtonParams, NewtonSystem, NonlinearProblem, PcgDirection, PreconditionerChoice,
    ProjectionPolicy, StopReason, Tangent, Watch,
};
pub use operator::{
    AssumedPositiveDefinite, LinearOperator, MatrixPreconditioner, Preconditioner, Structure,
};
pub use ordering::{Permutation, nested_dissection};
pub use pcg::{PcgError, PcgInfo, PcgParams, pcg, pcg_semidefinite};
pub use preconditioner::{BlockIc0, BlockJacobi, Identity, PreconditionerError};
