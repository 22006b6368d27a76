//! The suite that proves a material, the built-in ones and yours (feature `conformance`).
//!
//! ```
//! use fem_materials::{NeoHookean, conformance};
//!
//! let material = NeoHookean { mu: 1.0e5, lambda: 4.0e5 };
//! conformance::check::<3, _>(&material).assert();
//! ```
//!
//! Every run draws fresh deformations near rest, moderate, large, inverted and with repeated
//! singular values, and prints the seed where something fails; `FEM_SEED=0x…` in the environment
//! or [`Suite::seed`] draws the same ones again. The derivatives are compared with dual numbers,
//! which are exact to rounding, and with central differences, which share no code with them.
//!
//! What only some materials promise is a [`Claim`]; isotropy is read from
//! [`Material::SYMMETRY`]:
//!
//! ```
//! use fem_materials::{NeoHookean, conformance::{Claim, Suite}};
//!
//! let suite = Suite {
//!     claims: &[Claim::Objective, Claim::StressFreeRest],
//!     ..Suite::default()
//! };
//! suite.check::<2, _>(&NeoHookean { mu: 1.0, lambda: 1.5 }).assert();
//! ```

mod definiteness;
mod derivatives;
mod domain;
mod invariance;
mod packs;
mod random;
mod report;
mod sample;
mod size;

pub use random::{Random, fresh_seed, parse_seed};
pub use report::{Finding, Property, Report};

use crate::{Material, Outlined, Symmetry};

/// A promise that not every material makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Claim {
    /// Rotating the deformed body changes nothing. All but linear elasticity.
    Objective,
    /// P(I) = 0.
    StressFreeRest,
    /// The energy is +∞ wherever det F ≤ 0.
    PositiveDeterminant,
    /// The projection works on the terms of a sum one by one: cheaper than on their
    /// total, just as definite, but stiffer than the nearest definite tensor.
    ProjectedByTerms,
}

/// What to try, and with which random numbers.
#[derive(Clone, Copy, Debug)]
pub struct Suite<'a> {
    /// Seed of the random deformations.
    pub seed: u64,
    /// How many deformations of each of the five kinds.
    pub rounds: usize,
    /// What the material promises.
    pub claims: &'a [Claim],
}

impl Default for Suite<'_> {
    /// A fresh seed, 16 rounds, and objectivity as the only claim.
    fn default() -> Self {
        Self {
            seed: fresh_seed(),
            rounds: 16,
            claims: &[Claim::Objective],
        }
    }
}

/// Tries an objective material with a fresh seed: [`Suite::check`] of [`Suite::default`].
pub fn check<const D: usize, M: Material<D>>(material: &M) -> Report {
    Suite::default().check(material)
}

impl Suite<'_> {
    /// Tries the material at random deformations and returns the worst error of each property.
    pub fn check<const D: usize, M: Material<D>>(&self, material: &M) -> Report {
        let material = &Outlined(*material);
        let mut random = Random::new(self.seed);
        let mut report = Report {
            material: short_type_name::<M>(),
            dimension: D,
            seed: self.seed,
            findings: Vec::new(),
        };
        let samples = sample::samples(&mut random, self.rounds);
        let mut directions = derivatives::Directions::default();
        for sample in &samples {
            derivatives::check(material, sample, &mut directions, &mut report);
            definiteness::check(material, sample, self.claims, &mut report);
            packs::single(material, sample, &mut report);
            if self.claims.contains(&Claim::Objective) {
                invariance::objectivity(material, sample, &mut random, &mut report);
            }
            if M::SYMMETRY == Symmetry::Isotropic {
                invariance::isotropy(material, sample, &mut random, &mut report);
            }
        }
        directions.record::<D>(&mut report);
        packs::lanes(material, &samples, &mut report);
        domain::extreme(material, &mut random, &mut report);
        if self.claims.contains(&Claim::StressFreeRest) {
            domain::rest(material, &mut report);
        }
        if self.claims.contains(&Claim::PositiveDeterminant) {
            domain::positive_determinant(material, &mut random, &mut report);
        }
        report
    }
}

/// `a::b::Model<c::d::Inner>` as `Model<Inner>`.
fn short_type_name<M>() -> String {
    let full = core::any::type_name::<M>();
    let mut short = String::new();
    let mut word = String::new();
    for c in full.chars() {
        match c {
            ':' => word.clear(),
            c if c.is_alphanumeric() || c == '_' => word.push(c),
            c => {
                short.push_str(&word);
                word.clear();
                short.push(c);
            }
        }
    }
    short + &word
}

#[cfg(test)]
mod tests;
