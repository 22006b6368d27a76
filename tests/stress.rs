//! Materials and solves at the edge.
#![allow(missing_docs)]

use verification::stress::{Outcome, rows};

#[test]
fn nothing_lies_at_the_edge() {
    let failed: Vec<_> = rows()
        .into_iter()
        .filter(|row| matches!(row.outcome, Outcome::Fail(_)))
        .inspect(|row| println!("{row:?}"))
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
