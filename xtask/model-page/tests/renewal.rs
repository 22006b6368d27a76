//! What is written into a page, and what of the page stays.

use fem_materials::registry::Parameter;
use model_page::{NoMarker, Summary, at_a_glance, parameters, renewed, summaries};

const PAGE: &str = "by hand\n\
    <!-- models: written by `cargo xtask models` -->\n| old |\n<!-- end of the models -->\n\
    also by hand\n\
    <!-- parameters: written by `cargo xtask models` -->\n<!-- end of the parameters -->\nlast\n";

#[test]
fn only_what_stands_between_the_markers_is_written() {
    let page = renewed(PAGE).expect("a page with markers");
    assert!(page.starts_with("by hand\n<!--") && page.ends_with("-->\nlast\n"));
    assert!(page.contains("-->\nalso by hand\n<!--") && !page.contains("old"));
    for model in summaries() {
        assert!(page.contains(&format!("| `{}`", model.name)), "{page}");
    }
    assert_eq!(renewed(&page).as_deref(), Ok(page.as_str()));
    let cut = PAGE.replace("<!-- end of the models -->", "");
    assert_eq!(renewed(&cut), Err(NoMarker("<!-- end of the models -->")));
}

/// The lines below a table's head.
fn rows(table: &str) -> Vec<&str> {
    table.lines().skip(2).collect()
}

#[test]
fn a_row_says_what_the_registry_says() {
    const PARAMETERS: [Parameter; 3] = [
        Parameter::pascals("mu", "1e4", "shear modulus"),
        Parameter::pascals("K", "2e5", "bulk modulus").also(&["bulk"]),
        Parameter::plain("b", "1", "rate of |E|"),
    ];
    let first = Summary {
        name: "first",
        aliases: &["other"],
        about: "rubber",
        domain: "J > 0",
        parameters: &PARAMETERS,
        dimensions: vec![2, 3],
        decomposes: true,
    };
    const HARDER: [Parameter; 1] = [Parameter::pascals("mu", "3e4", "shear modulus")];
    let second = Summary {
        name: "second",
        aliases: &[],
        parameters: &HARDER,
        dimensions: vec![3],
        decomposes: false,
        ..first.clone()
    };
    let models = [first, second];
    assert_eq!(
        rows(&at_a_glance(&models)),
        [
            "| `first` (`other`) | `mu`, `K` (`bulk`) [Pa]; `b` | 2, 3 | J > 0 | SVD | rubber |",
            "| `second` | `mu` [Pa] | 3 | J > 0 | – | rubber |",
        ]
    );
    assert_eq!(
        rows(&parameters(&models)),
        [
            "| `b` | – | rate of \\|E\\| | `first` (1) |",
            "| `K` (`bulk`) | Pa | bulk modulus | `first` (2e5) |",
            "| `mu` | Pa | shear modulus | `first` (1e4), `second` (3e4) |",
        ]
    );
}
