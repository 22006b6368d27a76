//! Isotropic elasticity in the frame of the singular vectors.
//!
//! For ψ(F R) = ψ(F) = ψ(R F) everything can be done at F̂ = diag(σ), F = U F̂ Vᵀ: P = U P̂ Vᵀ
//! with P̂ diagonal, and dP/dF there is block diagonal ([`DiagonalBlocks`]). An energy is given
//! either by the invariants of C ([`ByInvariants`]; no decomposition needed for ψ, P and dP/dF)
//! or by the principal stretches ([`ByStretches`]).

mod blocks;
mod by_invariants;
mod by_stretches;
mod first_invariant;
mod mooney_rivlin_blocks;

pub(crate) use blocks::reassembled;
pub use blocks::{AlphaBetaGamma, DiagonalBlocks, PAIRS, projected};
pub use by_invariants::{ByInvariants, Domain, InvariantEnergy};
pub use by_stretches::{ByStretches, StretchEnergy, positive_sum};
pub use first_invariant::{FirstInvariant, FirstInvariantEnergy, Volume};
pub use mooney_rivlin_blocks::{Eta, combined_stress, mooney_rivlin_alpha_beta_gamma};
