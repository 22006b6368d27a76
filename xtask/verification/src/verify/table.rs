//! The constitutive tables `<model>_<d>d.json` as they are written.

use crate::numbers::{Number, Numbers};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A table of one model.
#[derive(Clone, Debug, Deserialize)]
pub struct Table {
    /// The model's name.
    pub model: String,
    /// 2 or 3.
    pub dim: usize,
    /// Sets of parameters, as text.
    pub params: Vec<BTreeMap<String, String>>,
    /// One for each deformation.
    pub cases: Vec<Case>,
}

/// One deformation with its exact results.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "the names are those of the format")]
pub struct Case {
    pub id: usize,
    pub cat: String,
    #[serde(rename = "p")]
    pub parameters: usize,
    pub F: Numbers,
    /// det F.
    #[serde(default)]
    pub J: Number,
    pub psi: Number,
    pub P: Numbers,
    pub dPdF: Numbers,
    pub eig: Numbers,
    /// `None`: dP/dF has no negative eigenvalue.
    pub psd: Option<Numbers>,
    pub dP_dalpha: Option<Numbers>,
    pub invariants: Option<Numbers>,
    pub psi_I: Option<Numbers>,
    pub psi_II: Option<Numbers>,
    /// Normalized stretch of the fiber.
    pub l: Option<Number>,
    #[serde(default)]
    pub kink: bool,
    /// Change for one rounding of F.
    pub ulp: Indicators,
    /// Size of the terms that the energy is a sum of.
    pub mag: Indicators,
}

/// A number for each of ψ, P and dP/dF.
#[derive(Clone, Copy, Debug, Deserialize)]
#[allow(missing_docs, reason = "the names are those of the format")]
pub struct Indicators {
    pub psi: Number,
    pub P: Number,
    pub dPdF: Number,
}
