//! Constitutive models for simplex finite elements: energy ψ, first Piola-Kirchhoff stress P and
//! its derivative dP/dF.
#![allow(non_snake_case)]

#[cfg(feature = "conformance")]
pub mod conformance;
mod material;
pub mod models;

pub use material::Material;
pub use models::NeoHookean;
