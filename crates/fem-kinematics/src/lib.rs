//! Deformation gradients, signed decompositions, strains and invariants with exact derivatives,
//! in 2D and 3D.
//!
//! Everything is generic over a scalar [`Real`] and the dimension `D` (2 or 3), without branches on
//! values: one source serves `f64`, `f32`, eight elements side by side and [`Dual`] numbers.
//!
//! ```
//! use fem_kinematics::{Dual, Mat, RestShape, deformation_gradient, log_determinant, polar,
//!     shape_matrix};
//! // A tetrahedron at rest, and turned inside out.
//! let rest = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let shape = RestShape::from_vertices(&rest)?;
//! let mirrored = rest.map(|[x, y, z]| [x, y, -z]);
//! let F = deformation_gradient(&shape_matrix(&mirrored), &shape.inverse);
//! assert_eq!(polar(&F).R.determinant(), 1.0); // a rotation, never a reflection
//!
//! // Exact derivatives of anything: ln det at the identity, in direction dF = I.
//! let F = Mat::<Dual<f64>, 3>::from_diagonal([Dual::variable(1.0); 3]);
//! assert_eq!(log_determinant(&F).derivative, 3.0);
//! # Ok::<(), fem_kinematics::RestShapeError>(())
//! ```
//!
//! | | |
//! |---|---|
//! | numbers | [`Real`], [`Lanes`], [`Dual`]; [`dispatch`], [`dispatch_packed`] and [`dispatch_quads`] choose the processor's instructions |
//! | small algebra | [`Mat`], [`Tensor4`] (dP/dF), [`to_flat`] and [`from_flat`] (9×9 orders), [`Tensor4::project`] |
//! | elements | [`RestShape`], [`shape_matrix`], [`deformation_gradient`], [`deformation_gradient_at`], [`flatten_triangle`] |
//! | decompositions | [`signed_svd`], [`polar`], [`signed_qr`], [`symmetric_eigen`], each with its derivatives |
//! | measures | [`green_strain`], [`corotated_strain`], [`Invariants`], [`IsochoricInvariants`], [`log_determinant`] |
//! | obstacles | [`ImplicitSurface`]: signed distances of convex solids with normals and curvatures |
//! | stresses | [`cauchy_from_piola`] and its kin |
//!
//! Derivatives that do not exist everywhere come as [`Checked`]. Feature `nalgebra`: conversions
//! between [`Mat`] and `nalgebra::SMatrix`.
#![allow(non_snake_case)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod checked;
#[cfg(feature = "nalgebra")]
mod convert;
mod dispatch;
mod dual;
mod flattening;
mod frame;
mod hessian_projection;
mod implicit_surface;
mod invariants;
mod jacobi;
mod lanes;
mod mat;
mod math;
mod polar;
mod qr;
mod scalar;
mod simplex;
mod strain;
mod stress_measures;
mod svd;
mod tensor4;
mod tensor4_projection;

pub use checked::Checked;
pub use dispatch::{
    Kernel, Pack, PackedKernel, Quad, QuadKernel, QuadScalar, dispatch, dispatch_packed,
    dispatch_quads, dispatch_registers, portable_only,
};
pub use dual::Dual;
pub use flattening::{
    BLOCK_ORDER_2D, BLOCK_ORDER_3D, ROW_MAJOR_2D, ROW_MAJOR_3D, from_flat, to_flat,
};
pub use hessian_projection::HessianProjection;
pub use implicit_surface::{ImplicitSurface, UnusableSurface};
pub use invariants::{
    Invariants, IsochoricInvariants, determinant_minus_one, left_cauchy_green, log_determinant,
    right_cauchy_green,
};
pub use jacobi::{SymmetricEigen, jacobi_eigen, symmetric_eigen};
pub use lanes::{F32x16, F64x8, LaneMask, Lanes};
pub use mat::{Mat, Vector, dot, vector};
pub use polar::{Polar, polar};
pub use qr::{Qr, multiply_by_skew, signed_qr};
pub use scalar::Real;
pub use simplex::{
    RestShape, RestShapeError, deformation_gradient, deformation_gradient_at, flatten_triangle,
    shape_matrix, simplex_volume,
};
pub use strain::{corotated_strain, green_strain, green_strain_differential, infinitesimal_strain};
pub use stress_measures::{
    cauchy_from_piola, kirchhoff_from_piola, piola_from_cauchy, piola_from_kirchhoff,
    piola_from_second_piola, second_piola_from_piola,
};
pub use svd::{Svd, SvdDifferential, signed_svd};
pub use tensor4::Tensor4;
