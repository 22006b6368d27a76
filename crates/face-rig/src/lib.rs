//! Muscle-driven faces: quasistatic expressions, exact rig derivatives and fitting to landmarks

pub mod anatomy;
pub mod builtin;
pub mod export;
pub mod fit;
pub mod pictures;
pub mod rig;
pub mod scene;
