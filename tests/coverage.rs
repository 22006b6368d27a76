//! `docs/coverage.md` cannot rot: every promise has a row, every place and test it names exists.
#![allow(missing_docs)]

use fem_materials::Material;
use fem_materials::registry::{Entry, ModelVisitor, for_each_model};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const PROMISES: [(&str, usize); 6] = [
    ("S0", 66),
    ("S1", 53),
    ("S2", 21),
    ("S4", 14),
    ("U", 5),
    ("B", 25),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The cells of every row that starts with an id.
fn rows() -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join("docs/coverage.md")).expect("the table exists");
    text.lines()
        .filter(|line| {
            line.starts_with("| S") || line.starts_with("| U-") || line.starts_with("| B-")
        })
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
        let open = cells[3].contains("open") || cells[3].starts_with("context");
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

/// The functions of a source by name, from their first line to the next function.
fn functions(source: &str) -> Vec<(String, &str)> {
    let mut starts: Vec<usize> = source.match_indices("fn ").map(|(at, _)| at).collect();
    // Of a type or a comment.
    starts.retain(|&at| {
        let before = source[..at].rsplit('\n').next().unwrap_or("").trim_start();
        matches!(before, "" | "pub " | "pub(super) " | "pub(crate) ")
    });
    let ends = starts.iter().skip(1).copied().chain([source.len()]);
    let named = |(start, end): (&usize, usize)| {
        let text = &source[*start..end];
        let name = text[3..].split(|c: char| !c.is_alphanumeric() && c != '_');
        (name.take(1).collect(), text)
    };
    starts.iter().zip(ends).map(named).collect()
}

/// Does a test read reference data beside the repository, itself or by what it calls in its file?
fn needs_data(reference: &str) -> bool {
    let Some((path, name)) = reference.split_once("::") else {
        return false;
    };
    let Ok(source) = std::fs::read_to_string(root().join(path)) else {
        return false;
    };
    let functions = functions(&source);
    let reads = |text: &str| {
        ["FEM_SHARED", "../shared", "folder_or_skip("]
            .iter()
            .any(|word| text.contains(word))
    };
    let mut found: BTreeSet<&String> = functions
        .iter()
        .filter(|(_, text)| reads(text))
        .map(|(name, _)| name)
        .collect();
    loop {
        let calls = |text: &str| {
            let of = |name: &&String| {
                text.contains(&format!(" {name}(")) || text.contains(&format!(" {name}::<"))
            };
            found.iter().any(of)
        };
        let more = functions.iter().filter(|(_, text)| calls(text));
        let all: BTreeSet<&String> = more.map(|(name, _)| name).chain(found.clone()).collect();
        if all.len() == found.len() {
            return found.iter().any(|found| *found == name);
        }
        found = all;
    }
}

#[test]
fn a_test_that_needs_data_beside_the_repository_says_so_and_has_a_witness_that_does_not() {
    let mut problems = Vec::new();
    let mut marked = 0;
    for cells in rows() {
        let pieces: Vec<&str> = cells[3].split('`').collect();
        let tests = pieces.iter().zip(&pieces[1..]).skip(1).step_by(2);
        let tests: Vec<(&str, bool)> = tests
            .map(|(test, after)| (*test, after.starts_with('†')))
            .filter(|(test, _)| test.contains("::"))
            .collect();
        marked += tests.iter().filter(|(_, marked)| *marked).count();
        for (test, marked) in &tests {
            if needs_data(test) != *marked {
                problems.push(format!("{}: {test} and its mark do not agree", cells[0]));
            }
        }
        if !tests.is_empty() && tests.iter().all(|(_, marked)| *marked) {
            problems.push(format!("{}: no test without data beside it", cells[0]));
        }
    }
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
    // Marks are looked for where they are.
    assert!(marked > 60, "{marked}");
}

#[test]
fn the_counts_that_the_page_states_are_those_of_its_table() {
    let page = std::fs::read_to_string(root().join("docs/coverage.md")).expect("the page exists");
    let readme = std::fs::read_to_string(root().join("README.md")).expect("the page exists");
    let rows = rows();
    let count = |word: &str| rows.iter().filter(|row| row[3].starts_with(word)).count();
    let open = rows.iter().filter(|row| row[3].contains("open")).count();
    let context = count("context");
    let is_are = |n: usize| if n == 1 { "is" } else { "are" };
    let sentence = format!(
        "{} of {} rows have a test, {open} {} open, {context} {} context.",
        rows.len() - open - context,
        rows.len(),
        is_are(open),
        is_are(context)
    );
    assert!(page.contains(&sentence), "docs/coverage.md: {sentence}");
    assert_eq!(readme.contains("open rows"), open > 0, "README.md");
}

/// Every Rust source below a folder of the project.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the project") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("sources are text");
                found.push((path, text));
            }
        }
    }
    found
}

#[test]
fn every_mistake_of_the_documents_has_a_test_that_exists() {
    let errata = std::fs::read_to_string(root().join("docs/errata.md")).expect("the list exists");
    let all: String = ["crates", "tests"]
        .iter()
        .flat_map(|folder| sources(folder))
        .map(|(_, text)| text)
        .collect();
    let rows = errata
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| where"));
    let (mut count, mut previous) = (0, false);
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let test = cells.last().expect("a row has cells");
        let exists = |name: &&str| all.contains(&format!("fn {name}()"));
        let (found, other): (Vec<&str>, Vec<&str>) = quoted(test).into_iter().partition(exists);
        // What else stands there is the name of a model or of its table.
        let lost = other.iter().find(|name| name.matches('_').count() > 2);
        assert!(lost.is_none(), "{row}: no test {lost:?}");
        assert!(
            !found.is_empty() || (previous && *test == "the same"),
            "{row}"
        );
        (count, previous) = (count + 1, true);
    }
    assert!(count > 50, "{count} rows");
}

/// Every model by name, with its lines for people.
#[derive(Default)]
struct Models(Vec<(&'static str, [&'static str; 2])>);

impl ModelVisitor for Models {
    fn visit<M: Material<D>, const D: usize>(&mut self, entry: &Entry<M>) {
        self.0.push((entry.name, [entry.about, entry.domain]));
        for parameter in entry.parameters {
            let texts = [parameter.about, parameter.default];
            assert!(texts.iter().all(|t| !t.is_empty()), "{}", entry.name);
        }
    }
}

#[test]
fn every_model_is_explained_with_its_parameters_units_domain_and_purpose() {
    let mut models = Models::default();
    for_each_model(&mut models);
    for (name, texts) in models.0 {
        assert!(texts.iter().all(|t| !t.is_empty()), "{name}: {texts:?}");
    }
    let page = std::fs::read_to_string(root().join("docs/models.md")).expect("the page exists");
    let renewed = model_page::renewed(&page).expect("the page has its markers");
    let changed: Vec<&str> = renewed
        .lines()
        .filter(|line| !page.lines().any(|known| known == *line))
        .collect();
    assert!(
        renewed == page,
        "docs/models.md is not as the models say; `cargo xtask models` writes it\n{}",
        changed.join("\n")
    );
}

#[test]
fn a_model_is_one_file_that_no_other_file_names() {
    let mut models = Models::default();
    for_each_model(&mut models);
    let all = sources("crates/fem-materials/src");
    for (name, _) in models.0 {
        let literal = format!("\"{name}\"");
        let homes: Vec<_> = all
            .iter()
            // A preset is a model's name with numbers.
            .filter(|(path, text)| !path.ends_with("presets.rs") && text.contains(&literal))
            .map(|(path, _)| path)
            .collect();
        assert_eq!(homes.len(), 1, "`{name}` stands in {homes:?}");
        assert!(
            homes[0].parent().is_some_and(|p| p.ends_with("models")),
            "{homes:?}"
        );
    }
    for (path, text) in all {
        let in_models = path.parent().is_some_and(|p| p.ends_with("models"));
        let calls = text.matches("register(visitor").count();
        assert!(
            in_models || calls == 0,
            "{path:?} registers a model by hand"
        );
    }
}

#[test]
fn a_name_that_does_not_exist_is_found() {
    assert!(problem("docs/nowhere.md").is_some());
    assert!(problem("tests/coverage.rs::no_such_test").is_some());
    assert!(problem("tests/coverage.rs::a_name_that_does_not").is_some());
    assert!(problem("tests/coverage.rs::a_name_that_does_not_exist_is_found").is_none());
}
