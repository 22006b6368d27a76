//! One file per constitutive model.

mod neo_hookean;

pub use neo_hookean::NeoHookean;
