//! Explicit damage (document 001, alg. 5 and section 2.1).

use super::parameters::DamageParameters;

/// D_c = d − l₀² Δd: the geometric resistance.
#[inline(always)]
pub fn geometric_resistance(d: f64, laplacian: f64, length_scale: f64) -> f64 {
    // ERRATUM: the minus sign is missing in print (alg. 5, line 3).
    d - length_scale * length_scale * laplacian
}

/// d^{n+1} = min(1, d + Δt/η ⟨(1 − d) D̃ − D_c⟩) for one particle (alg. 5, lines 12-15).
///
/// `driving_force` is D̃ after its history was taken into account, `laplacian` is Δd (1/m²),
/// `dt` in seconds. The condition of line 12 is the bracket of line 13.
#[inline(always)]
pub fn explicit_update(
    parameters: &DamageParameters,
    d: f64,
    driving_force: f64,
    laplacian: f64,
    dt: f64,
) -> f64 {
    let resistance = geometric_resistance(d, laplacian, parameters.length_scale);
    let excess = (1.0 - d) * driving_force - resistance;
    // Written so that NaN comes out as NaN.
    if excess <= 0.0 {
        return d;
    }
    let new = d + dt / parameters.eta * excess;
    if new > 1.0 { 1.0 } else { new }
}
