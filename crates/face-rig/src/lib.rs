//! Muscle-driven faces: quasistatic expressions, exact rig derivatives and fitting.
//!
//! A [`scene::Scene`] holds a tetrahedral face with its bones, muscles and landmarks, read from files
//! or made by the program ([`builtin`]). Its [`rig::Rig`] finds the shape x(θ) at which all forces
//! vanish, for muscle activations and for the frames of cranium and jaw, and the exact derivative
//! dx/dθ, by columns or by adjoints. [`fit`] turns that round: from landmarks, or a dense target, to
//! θ. [`pictures`] and [`export`] show the result.
//!
//! ```
//! use face_rig::rig::{Direction, Parameters, RigParams};
//! use face_rig::scene::Scene;
//!
//! let scene = Scene::builtin(5_000)?;
//! let mut rig = scene.rig(RigParams::default())?;
//! let mut pose = Parameters::rest(rig.muscles());
//! let smile = scene.muscles.iter().position(|m| m.name == "zygomaticus_major_L").unwrap();
//! pose.activations[smile] = 0.3;
//! rig.solve(&pose)?;
//!
//! // The left corner of the mouth (landmark 54) rises, and would rise further with more tension.
//! let corner = scene.carried_landmarks([54]).0[0];
//! let risen = corner.position(&rig.solved().positions())[1] - corner.position(scene.mesh.nodes())[1];
//! let slope = &rig.sensitivity()?.columns(&[Direction::Activation(smile)])[0];
//! assert!(risen > 0.0 && corner.position(slope)[1] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Units are SI throughout: meters, pascals, newtons, radians. The command line is behind the default
//! feature `cli`; a library user turns it off.

pub mod anatomy;
pub mod builtin;
pub mod export;
pub mod fit;
pub mod pictures;
pub mod rig;
pub mod scene;
mod stopwatch;
