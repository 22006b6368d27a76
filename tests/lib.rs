//! Tests that cross crates; see the `*.rs` files beside this one.
