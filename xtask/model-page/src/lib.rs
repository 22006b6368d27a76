//! The tables of `docs/models.md`: what every registered model says of itself.

mod summary;
mod tables;

pub use summary::{Summary, summaries};
pub use tables::{at_a_glance, parameters};

/// Before a table and after it. What stands between is written, the rest of the page is by hand.
const GLANCE: [&str; 2] = [
    "<!-- models: written by `cargo xtask models` -->",
    "<!-- end of the models -->",
];
const PARAMETERS: [&str; 2] = [
    "<!-- parameters: written by `cargo xtask models` -->",
    "<!-- end of the parameters -->",
];

/// The page has no place for a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the page has no line `{0}`, or not in its place")]
pub struct NoMarker(pub &'static str);

/// The page with the tables of the models as they are registered now.
///
/// # Errors
/// If the lines around a table are missing.
pub fn renewed(page: &str) -> Result<String, NoMarker> {
    let models = summaries();
    let page = replaced(page, GLANCE, &at_a_glance(&models))?;
    replaced(&page, PARAMETERS, &parameters(&models))
}

fn replaced(page: &str, [start, end]: [&'static str; 2], table: &str) -> Result<String, NoMarker> {
    let (before, rest) = page.split_once(start).ok_or(NoMarker(start))?;
    let (_, after) = rest.split_once(end).ok_or(NoMarker(end))?;
    Ok(format!("{before}{start}\n\n{table}\n{end}{after}"))
}
