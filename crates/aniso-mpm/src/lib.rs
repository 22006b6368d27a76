//! AnisoMPM: anisotropic damage, QR elasticity and inextensible fibers on a material-point host
#![allow(non_snake_case)]
// Comparisons are written so that NaN fails them: `!(a < b)` is not `a >= b`.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod binning;
mod blocks;
mod body;
pub mod damage;
mod dispatch;
mod error;
mod float;
mod host_damage;
mod host_fibers;
mod implicit;
pub mod inextensibility;
pub mod kernels;
pub mod kkt;
mod obstacle;
mod particles;
#[cfg(feature = "scenes")]
pub mod scenes;
mod simulation;
mod stencil;
mod step;
mod stresses;
mod transfer;
mod wave_speed;
mod window;

pub use binning::Binning;
pub use blocks::{BLOCK_NODES, BlockSet, block_side};
pub use body::{Body, Fiber};
pub use error::{MpmError, NewtonEnd, Rejection, SolveError};
pub use float::{Float, worse};
pub use implicit::ImplicitStep;
pub use kernels::{Cubic, Linear, Number, Quadratic, Spline, Stencil};
pub use obstacle::{Contact, ContactConstraint, Obstacle};
pub use particles::{Particle, Particles};
pub use simulation::{Energies, Integrator, Settings, Simulation};
pub use step::FrameInfo;
pub use transfer::{Apic, ConstantInertia, MlsMpm, Scheme};
pub use wave_speed::wave_speed;
pub use window::{Gather, Node, Scatter, Visit, rows, window_start};
