//! What to do with elements that are flat or turned inside out, where ln J and F⁻¹ do not exist.
//!
//! [`Thresholded`] is what document 000, 5.5 describes; its stress is not the gradient of its
//! energy, so a line search on the energy cannot trust it. [`continued`] gives any isotropic
//! model an energy, with its exact derivatives, that goes on smoothly below a threshold. A model
//! that is finite everywhere (stable neo-Hookean, fixed corotated, QR) needs neither to be solved; so
//! that its elements do not end inside out, [`VolumeBarrier`] adds a wall that acts late.

mod barrier;
mod continued;
mod thresholded;

pub use barrier::VolumeBarrier;
pub use continued::{Continuation, Continued, Smoothness, continued};
pub use thresholded::{Threshold, Thresholded};

use crate::registry::ParameterError;

/// A threshold ≤ 0 or NaN leaves 1/0 in every evaluation.
fn positive_threshold(value: f64) -> Result<(), ParameterError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ParameterError::OutOfRange {
        name: "threshold",
        value,
        range: "finite and greater than 0",
    })
}
