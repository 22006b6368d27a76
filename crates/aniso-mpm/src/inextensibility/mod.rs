//! Inextensible fibers: (a aᵀ) : d = 0 on every cell (document 001, section 4 and alg. 11).
//!
//! Velocities live on nodes with the quadratic kernel N_i, multipliers on cell centers h (z + ½)
//! with the linear kernel Γ_z. The constraint matrix couples each cell to the 4^D nodes around it:
//!
//! ```text
//! B_(z,iα) = Σ_p V_p Γ_z(x_p) a_α (a · ∇N_i(x_p))        M⁻¹ = Δt/m_i
//! L = B M⁻¹ Bᵀ      L λ = B M⁻¹ b      v = M⁻¹ (b − Bᵀ λ)
//! ```
//!
//! L is singular in general: there are more border cells than independent constraints. The
//! system is consistent, so conjugate gradients find a λ; λ is not unique, v is.

mod matrix;
mod matrix_free;
mod solve;

pub use matrix::ConstraintMatrix;
pub use matrix_free::FiberGrid;
pub use solve::{CollisionRow, InextensibleSolution, Projection};
