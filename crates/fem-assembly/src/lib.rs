//! Meshes, finite-volume nodal forces, sparse Hessians, constraints and penalties: everything
//! between a constitutive model and the equation f(x) = 0, for triangles and tetrahedra alike.
//!
//! A [`mesh::SimplexMesh`] is validated once; [`Dofs`] says which coordinates are prescribed; an
//! [`AssemblyBuilder`] adds materials per region, muscle fibers and obstacles; the resulting
//! [`Assembly`] evaluates energy, forces, Hessian and its products at any positions, eight elements
//! at a time in the widest registers of the processor, in parallel, and with the same bits for any
//! number of threads. [`Quasistatic`] presents it to `fem_solvers::Newton`; the example there is a
//! complete solve.
//!
//! ```
//! use fem_assembly::{AssemblyBuilder, Dofs};
//! use fem_materials::NeoHookean;
//!
//! let mesh = fem_assembly::mesh::kuhn_grid(2, 2, 2, [0.1; 3])?;
//! let dofs = Dofs::all_free(mesh.nodes())?;
//! let flesh = NeoHookean { mu: 1e4, lambda: 1e5 };
//! let assembly = AssemblyBuilder::new(&mesh, dofs)?.material(flesh)?.build()?;
//! let swollen: Vec<[f64; 3]> = mesh.nodes().iter().map(|p| p.map(|c| 1.1 * c)).collect();
//! let mut gradient = vec![0.0; assembly.dofs().unknowns()];
//! let energy = assembly.gradient(&swollen, &[], &mut gradient);
//! // Only volume was added: every force points back, and their sum is zero.
//! assert!(energy > 0.0 && gradient.iter().step_by(3).sum::<f64>().abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![allow(non_snake_case)]

mod assembly;
mod block;
mod builder;
mod dofs;
mod error;
mod fibers;
mod law;
pub mod mesh;
mod part;
mod penalty;
mod quasistatic;

pub use assembly::Assembly;
pub use builder::AssemblyBuilder;
pub use dofs::Dofs;
pub use error::AssemblyError;
pub use fibers::Fiber;
pub use penalty::{Obstacle, Penalty};
pub use quasistatic::Quasistatic;
