//! Comparison with reference solutions kept as JSON: kernels (c1), damage (c2), inextensible
//! fibers (c3) and the relaxed KKT system (c4).
//!
//! [`compare`] takes the parsed file and returns every error with its tolerance; what to do with
//! them is the caller's business.

mod damage;
mod inextensibility;
mod kernels;
mod kkt;
mod read;

use serde_json::Value;

/// One number compared with the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// What was compared.
    pub name: String,
    /// How far off it is, relative to the size of the reference.
    pub error: f64,
    /// How far off it may be.
    pub tolerance: f64,
}

impl Deviation {
    /// Within its tolerance? False for NaN.
    pub fn is_good(&self) -> bool {
        self.error <= self.tolerance
    }
}

/// Compares with the reference file of the scene `name`: `c1_kernels`, `c2_damage_2d`,
/// `c2_damage_3d`, `c3_inextensibility_2d`, `c3_inextensibility_3d` or `c4_kkt`.
///
/// # Errors
/// A scene that is not known here, an entry that is missing, or a solve that failed.
pub fn compare(name: &str, file: &Value) -> Result<Vec<Deviation>, String> {
    match name {
        "c1_kernels" => kernels::compare(file),
        "c2_damage_2d" => damage::compare::<2>(file),
        "c2_damage_3d" => damage::compare::<3>(file),
        "c3_inextensibility_2d" => inextensibility::compare::<2>(file),
        "c3_inextensibility_3d" => inextensibility::compare::<3>(file),
        "c4_kkt" => kkt::compare(file),
        _ => Err(format!("no scene called {name}")),
    }
}

/// The scenes known here.
pub const NAMES: [&str; 6] = [
    "c1_kernels",
    "c2_damage_2d",
    "c2_damage_3d",
    "c3_inextensibility_2d",
    "c3_inextensibility_3d",
    "c4_kkt",
];
