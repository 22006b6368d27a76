//! One file per constitutive model.
//!
//! Every `*.rs` file in this folder is a model: it holds the material, its [`Material`] code, a
//! function `register` that shows it to a [`ModelVisitor`], and its special tests. `build.rs`
//! lists the folder, so nothing else has to be touched.
//!
//! [`Material`]: crate::Material
//! [`ModelVisitor`]: crate::registry::ModelVisitor

include!(concat!(env!("OUT_DIR"), "/models.rs"));
