//! One file per constitutive model.
//!
//! Every `*.rs` file in this folder is a model: it holds the material, its [`Material`] code, a
//! function `register` that says how to build it by name, and its special tests. `build.rs`
//! lists the folder, so nothing else has to be touched.
//!
//! [`Material`]: crate::Material

include!(concat!(env!("OUT_DIR"), "/models.rs"));
