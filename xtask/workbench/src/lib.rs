//! What verification, stress tests and benchmarks share: the book of comparisons and the reference
//! scenes. In release it is compiled with full optimization, unlike `verification`, because of what it
//! solves.
#![allow(non_snake_case)]

pub mod numbers;
pub mod promise;
pub mod report;
pub mod scenes;
pub mod shared;
