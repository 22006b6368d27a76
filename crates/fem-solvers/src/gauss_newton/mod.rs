//! Nonlinear least squares: Gauss-Newton and Levenberg-Marquardt (document 000, sections 1 and 5.3).

mod damper;
mod linear_step;
mod loss;
mod params;
mod solve;
mod stop;

pub use loss::Loss;
pub use params::{
    Bounds, Damping, GaussNewtonError, GaussNewtonFailure, GaussNewtonInfo, GaussNewtonIteration,
    GaussNewtonParams, GaussNewtonStop, LeastSquares, Prior, StepMethod,
};
pub use solve::{gauss_newton, gauss_newton_observed};
