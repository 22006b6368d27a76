//! Elasticity by the QR decomposition F = Q R (document 001, section 3): the anisotropic energy
//! in closed form, and the framework for any Ψ̂(R).

mod anisotropic_hat;
mod closed_form;
mod general;

pub(crate) use closed_form::Coefficients;
pub use general::{GeneralQr, QrEnergy};
