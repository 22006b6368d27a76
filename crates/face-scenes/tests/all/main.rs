//! The library from outside.

mod builtin_muscles;
mod motion;
