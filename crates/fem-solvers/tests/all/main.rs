//! The crate's tests, in one program: what they share is compiled once.
mod cholesky;
mod common;
mod continuation;
mod gauss_newton;
mod least_squares_stop;
mod matrix_free;
mod multigrid;
mod newton;
mod one_sided;
mod pcg;
mod rosenbrock;
mod rounded_energy;
mod scales;
mod strangers;
mod walled;
mod watch;
mod wrong_hessians;
