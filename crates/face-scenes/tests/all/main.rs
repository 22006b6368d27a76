//! The library from outside.

mod builtin_muscles;
mod derivative;
mod motion;
#[path = "../../../face-rig/tests/all/promise.rs"]
mod promise;
