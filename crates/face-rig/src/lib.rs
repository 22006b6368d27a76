//! Muscle-driven faces: quasistatic expressions, exact rig derivatives and fitting.
//!
//! [`anatomy`] names what a face consists of: muscles with fibers, bones, the jaw's hinge. A
//! [`rig::Rig`] finds the shape x(θ) at which all forces vanish, for muscle activations and for the
//! frames of cranium and jaw, and the exact derivative dx/dθ, by columns or by adjoints. [`fit`]
//! turns that round: from points that are seen to θ.
//!
//! ```
//! use face_rig::rig::{Direction, Parameters, Rig, RigParams};
//! use fem_assembly::mesh::kuhn_grid;
//! use fem_assembly::{AssemblyBuilder, Dofs, Fiber};
//! use fem_materials::curves::PhysBam;
//! use fem_materials::{FiberLaw, StableNeoHookean, Stretch};
//!
//! // A bar of flesh from the cranium (z = 0) to the jaw (z = 8 cm), with one muscle along it.
//! let mesh = kuhn_grid(1, 1, 4, [0.02, 0.02, 0.08])?;
//! let nodes = mesh.nodes();
//! let at = |z: f64| move |n: &usize| (nodes[*n][2] - z).abs() < 1e-9;
//! let cranium: Vec<usize> = (0..mesh.num_nodes()).filter(at(0.0)).collect();
//! let jaw: Vec<usize> = (0..mesh.num_nodes()).filter(at(0.08)).collect();
//! let prescribed = [cranium, jaw.clone()].concat();
//! let fiber = |element| Fiber {
//!     element,
//!     control: 0,
//!     direction: [0.0, 0.0, 1.0],
//!     max_isometric_stress: 2e4,
//!     optimal_stretch: 1.0,
//! };
//! let fibers: Vec<Fiber> = (0..mesh.num_elements() / 2).map(fiber).collect();
//! let law = FiberLaw { curve: PhysBam::default(), stretch: Stretch::Total };
//! let flesh = AssemblyBuilder::new(&mesh, Dofs::with_prescribed_nodes(mesh.nodes(), &prescribed)?)?
//!     .material(StableNeoHookean { mu: 1e4, lambda: 9e4 })?
//!     .fibers(law, 1, &fibers)?
//!     .build()?;
//!
//! let mut rig = Rig::new(flesh, &jaw, RigParams::default())?;
//! let mut pose = Parameters::rest(1);
//! pose.activations[0] = 0.5;
//! rig.solve(&pose)?;
//!
//! // The muscle in the cranium's half pulls the middle toward the cranium, more so if it pulls more.
//! let middle = (0..mesh.num_nodes()).find(at(0.04)).unwrap();
//! let slope = &rig.sensitivity()?.columns(&[Direction::Activation(0)])?[0];
//! assert!(rig.equilibrium().positions()[middle][2] < 0.04 && slope[middle][2] < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Units are SI throughout: meters, pascals, newtons, radians.

pub mod anatomy;
pub mod fit;
pub mod rig;
mod stopwatch;

pub use stopwatch::Stopwatch;
