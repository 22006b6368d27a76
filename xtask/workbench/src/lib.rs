//! What verification, stress tests and benchmarks share: the book of comparisons, the reference
//! scenes and the timed problems. In release it is compiled with full optimization, unlike
//! `verification`, because what it solves is timed.
#![allow(non_snake_case)]

pub mod bench;
pub mod numbers;
pub mod report;
pub mod scenes;
pub mod shared;
