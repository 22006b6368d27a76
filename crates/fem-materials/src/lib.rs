//! Constitutive models for simplex finite elements: energy ψ, first Piola-Kirchhoff stress P and
//! its derivative dP/dF.
//!
//! A model is a small `Copy` struct with its parameters in SI units. It implements
//! [`Material<D>`](Material) for triangles (D = 2), tetrahedra (D = 3) or both; every method is
//! generic over the scalar, so the same source runs on `f64`, on eight elements at once
//! ([`fem_kinematics::F64x8`]) and on dual numbers.
//!
//! ```
//! use fem_kinematics::Mat;
//! use fem_materials::{HessianProjection, Flesh, Material};
//!
//! let flesh = Flesh::new(6e4, 2e4, 6e4);
//! let F = Mat([[1.1, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, 0.2, 1.0]]);
//! let all = flesh.evaluate(&F, HessianProjection::Clamp);
//! assert!(all.energy > 0.0);
//! // P is the derivative of the energy
//! let (h, dF) = (1e-6_f64, Mat([[0.3, -0.2, 0.1], [0.5, 0.4, 0.0], [-0.1, 0.2, 0.6]]));
//! let slope = (flesh.energy(&(F + dF.scale(h))) - flesh.energy(&(F - dF.scale(h)))) / (2.0 * h);
//! assert!((slope - all.stress.dot(&dF)).abs() < 1e-3);
//! ```
//!
//! No mesh, no state and no solver lives here.
#![allow(non_snake_case)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(feature = "conformance")]
pub mod conformance;
pub mod curves;
mod damage;
mod fiber;
pub mod field;
pub mod inversion;
pub mod isotropic;
mod lame;
mod material;
pub mod models;
mod near_rest;
mod outlined;
pub mod presets;
pub mod qr;
pub mod registry;
mod sum;
mod tensor_terms;

pub use damage::DamageField;
pub use fem_kinematics::HessianProjection;
pub use fiber::{FiberLaw, FiberTerm, Stretch};
pub use lame::{Lame, LameDefect, LameError, Space};
pub use material::{Evaluation, Material, Symmetry};
pub use models::*;
pub use outlined::Outlined;
pub use sum::Sum;
