//! Materials and solves at the edge.
#![allow(missing_docs)]

use xtask::stress::{Outcome, rows};

/// Called converged 2.6e6 m from rest. The tolerance relative to the gradient at the start, huge there,
/// is suspected. `cargo xtask stress` reports this as the failure that it is.
const OPEN: [&str; 1] = ["start 1000 km away, any F"];

#[test]
fn nothing_lies_at_the_edge() {
    let failed: Vec<_> = rows()
        .into_iter()
        .filter(|row| matches!(row.outcome, Outcome::Fail(_)))
        .inspect(|row| println!("{row:?}"))
        .filter(|row| !OPEN.contains(&row.trial))
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
