//! Deformation gradients, signed decompositions, strains and invariants with exact derivatives,
//! in 2D and 3D.
#![allow(non_snake_case)]

mod dispatch;
mod dual;
mod lanes;
mod mat;
mod scalar;
mod tensor4;

pub use dispatch::{Kernel, dispatch};
pub use dual::Dual;
pub use lanes::{F32x16, F64x8, LaneMask, Lanes};
pub use mat::{Mat, Vector, dot};
pub use scalar::Real;
pub use tensor4::Tensor4;
