//! Conformance, benchmarks and stress tests of the workspace.
fn main() {}
