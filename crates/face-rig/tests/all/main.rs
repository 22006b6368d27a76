//! One program: kernels of a model are compiled once for all tests that use it.

mod bones;
mod contact;
mod controls;
mod counted;
mod derivatives;
mod fits;
mod lengths;
mod limp;
mod multilevel;
mod promise;
mod weights;
