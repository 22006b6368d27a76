//! Meshes, finite-volume nodal forces, sparse Hessians, constraints and penalties: everything
//! between a constitutive model and the equation f(x) = 0, for triangles and tetrahedra alike.
//!
//! A [`mesh::SimplexMesh`] is validated once; [`Dofs`] says which coordinates are prescribed; an
//! [`AssemblyBuilder`] adds the terms of the energy: materials per region, muscle fibers, obstacles,
//! [`NodalLoads`] (forces, tractions, dead pressures), [`Gravity`], [`Springs`], the pressure in a
//! [`Cavity`], or any [`Term`] of your own. The resulting [`Assembly`] evaluates
//! energy, forces, Hessian and its products in any [`Configuration`] of positions and controls,
//! eight elements at a time in the widest registers of the processor, in parallel, and with the same
//! bits for any number of threads. Controls are numbers in each of which the energy is affine: activations of
//! muscles, or factors of [`Scaled`] terms: loads, pressures, strengths, stiffnesses. [`Quasistatic`] presents it to `fem_solvers::Newton`; the example there is a
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
//! let mut gradient = vec![0.0; assembly.dofs().vector_len()];
//! let at = assembly.configuration(&swollen, &[])?;
//! let energy = assembly.gradient(at, &mut gradient)?;
//! // Only volume was added: every force points back, and their sum is zero.
//! assert!(energy > 0.0 && gradient.iter().step_by(3).sum::<f64>().abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![allow(non_snake_case)]

mod active;
mod assembly;
mod boxed;
mod builder;
mod checked;
mod configuration;
mod direction;
mod dofs;
mod element;
mod element_group;
mod error;
mod evaluations;
mod faces;
mod free_parts;
pub mod mesh;
mod patches;
mod plan;
#[cfg(test)]
extern crate self as fem_assembly; // as `promise.rs` of the tests calls it
#[cfg(test)]
mod portable_tests;
mod predictor;
mod quasistatic;
mod renewal;
mod renewing;
mod rest;
mod rigid_motions;
mod scales;
mod shape;
mod sink;
mod stiffness;
mod term;
mod terms;
mod walk;

pub use assembly::Assembly;
pub use builder::AssemblyBuilder;
pub use configuration::{Configuration, Positions};
pub use dofs::Dofs;
pub use error::AssemblyError;
pub use evaluations::{Evaluations, Passes, StencilCost, StencilKind};
pub use fem_kinematics::ImplicitSurface;
pub use free_parts::{FreePart, RigidMotion};
pub use patches::VolumePatches;
pub use quasistatic::Quasistatic;
pub use renewing::{RenewedSolution, RenewingError, solve_renewing};
pub use shape::{ElementShape, Linear, Quadratic};
pub use sink::{EnergySink, GradientSink, HessianSink};
pub use term::{Stencils, Term};
pub use terms::*;
pub use walk::{WalkError, WalkedSolution, solve_walking};
