//! The library from outside.

mod builtin_muscles;
mod derivative;
mod motion;
