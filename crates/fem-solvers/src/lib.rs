//! Newton, preconditioned conjugate gradients, sparse Cholesky and Gauss-Newton on slices; knows no mesh

// A comparison with NaN is false: `!(a < b)` sends NaN where failures go.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod block_matrix;
mod cholesky;
mod dense_qr;
mod gauss_newton;
mod load_stepping;
mod newton;
mod operator;
mod ordering;
mod pcg;
mod preconditioner;
mod small;
mod vector;

pub use block_matrix::{BlockPattern, BlockSymmetric, PatternError};
pub use cholesky::{
    CholeskyError, CholeskyFactor, FactorScalar, RefineError, RefineInfo, RefineParams,
    SymbolicCholesky,
};
pub use gauss_newton::{
    Bounds, Damping, GaussNewtonError, GaussNewtonFailure, GaussNewtonInfo, GaussNewtonIteration,
    GaussNewtonParams, GaussNewtonStop, LeastSquares, Loss, Prior, StepMethod, gauss_newton,
    gauss_newton_observed,
};
pub use load_stepping::{LoadSteppingError, LoadSteppingInfo, LoadSteppingParams, walk_load};
pub use newton::{
    Definiteness, DefinitenessPolicy, LineSearchParams, LinearSolver, Merit, Newton, NewtonError,
    NewtonFailure, NewtonInfo, NewtonIteration, NewtonParams, NonlinearProblem,
    PreconditionerChoice, StopReason,
};
pub use operator::{AssumedPositiveDefinite, LinearOperator, Preconditioner, Structure};
pub use ordering::{Permutation, nested_dissection};
pub use pcg::{PcgError, PcgInfo, PcgParams, pcg, pcg_semidefinite};
pub use preconditioner::{BlockIc0, BlockJacobi, Identity, PreconditionerError};
