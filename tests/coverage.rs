//! `docs/coverage.md` cannot rot: every promise has a row, every place and test it names exists.
#![allow(missing_docs)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const PROMISES: [(&str, usize); 5] = [("S0", 66), ("S1", 53), ("S2", 21), ("S4", 14), ("U", 5)];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The cells of every row that starts with an id.
fn rows() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join("docs/coverage.md")).expect("the table exists");
    text.lines()
        .filter(|line| line.starts_with("| S") || line.starts_with("| U-"))
        .map(|line| {
            let inner = line.trim().trim_matches('|');
            inner
                .split('|')
                .map(|cell| cell.trim().to_owned())
                .collect()
        })
        .collect()
}

/// The pieces of a cell that stand between backticks.
fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

/// `path` or `path::name`; what is wrong with it, if anything.
fn problem(reference: &str) -> Option<String> {
    let (path, name) = match reference.split_once("::") {
        Some((path, name)) => (path, Some(name)),
        None => (reference, None),
    };
    let full = root().join(path);
    if !full.exists() {
        return Some(format!("{path} does not exist"));
    }
    let name = name?;
    let Ok(source) = std::fs::read_to_string(&full) else {
        return Some(format!("{path} is no text file"));
    };
    let defined = ["fn", "struct", "enum", "trait"].iter().any(|keyword| {
        source
            .match_indices(&format!("{keyword} {name}"))
            .any(|(at, found)| {
                let next = source[at + found.len()..].chars().next();
                next.is_none_or(|c| !c.is_alphanumeric() && c != '_')
            })
    });
    (!defined).then(|| format!("{path} defines no `{name}`"))
}

#[test]
fn every_promise_has_exactly_one_row() {
    let ids: Vec<String> = rows().iter().map(|cells| cells[0].clone()).collect();
    let unique: BTreeSet<&String> = ids.iter().collect();
    assert_eq!(unique.len(), ids.len(), "an id stands twice");
    for (group, count) in PROMISES {
        for number in 1..=count {
            let id = format!("{group}-{number:02}");
            assert!(unique.contains(&id), "{id} has no row");
        }
    }
    assert_eq!(ids.len(), PROMISES.iter().map(|p| p.1).sum::<usize>());
}

#[test]
fn every_place_and_every_test_exists() {
    let mut problems = Vec::new();
    for cells in rows() {
        assert_eq!(cells.len(), 4, "{}: id, promise, place, test", cells[0]);
        let (place, test) = (quoted(&cells[2]), quoted(&cells[3]));
        for reference in place.iter().chain(&test) {
            problems.extend(problem(reference).map(|p| format!("{}: {p}", cells[0])));
        }
        let open = cells[3].starts_with("open") || cells[3].starts_with("context");
        let named = !place.is_empty() && test.iter().any(|t| t.contains("::"));
        if !open && !named {
            problems.push(format!(
                "{}: neither open nor a place with a test",
                cells[0]
            ));
        }
    }
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

#[test]
fn a_name_that_does_not_exist_is_found() {
    assert!(problem("docs/nowhere.md").is_some());
    assert!(problem("tests/coverage.rs::no_such_test").is_some());
    assert!(problem("tests/coverage.rs::a_name_that_does_not").is_some());
    assert!(problem("tests/coverage.rs::a_name_that_does_not_exist_is_found").is_none());
}
