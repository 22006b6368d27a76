//! Deformation gradients, signed decompositions, strains and invariants with exact derivatives,
//! in 2D and 3D.
#![allow(non_snake_case)]

mod checked;
mod dispatch;
mod dual;
mod frame;
mod invariants;
mod jacobi;
mod lanes;
mod mat;
mod polar;
mod qr;
mod scalar;
mod simplex;
mod strain;
mod stress_measures;
mod svd;
mod tensor4;
mod tensor4_projection;
mod voigt9;

pub use checked::Checked;
pub use dispatch::{Kernel, dispatch};
pub use dual::Dual;
pub use invariants::{
    DeviatoricInvariants, Invariants, determinant_minus_one, left_cauchy_green, log_determinant,
    right_cauchy_green,
};
pub use jacobi::{SymmetricEigen, jacobi_eigen, symmetric_eigen};
pub use lanes::{F32x16, F64x8, LaneMask, Lanes};
pub use mat::{Mat, Vector, dot};
pub use polar::{Polar, polar};
pub use qr::{Qr, multiply_by_skew, signed_qr};
pub use scalar::Real;
pub use simplex::{
    RestShape, RestShapeError, deformation_gradient, flatten_triangle, shape_matrix,
};
pub use strain::{corotated_strain, green_strain, green_strain_differential, infinitesimal_strain};
pub use stress_measures::{
    cauchy_from_piola, kirchhoff_from_piola, piola_from_cauchy, piola_from_kirchhoff,
    piola_from_second_piola, second_piola_from_piola,
};
pub use svd::{Svd, signed_svd};
pub use tensor4::Tensor4;
pub use voigt9::{BLOCK_ORDER_2D, BLOCK_ORDER_3D, ROW_MAJOR_2D, ROW_MAJOR_3D, from_flat, to_flat};
