//! `cargo xtask stress`: what happens at the edge. A right answer or a clear error, never a lie.

mod materials;
mod solves;

use crate::report::Style;

/// How something ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The answer that it should be.
    Right(String),
    /// No answer, and it says so.
    ClearError(String),
    /// A wrong answer, a NaN, or a failure that passes for a success.
    Fail(String),
}

/// One row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Model or solve.
    pub subject: String,
    /// What it was put through.
    pub trial: &'static str,
    /// How it ended.
    pub outcome: Outcome,
}

/// All trials.
pub fn rows() -> Vec<Row> {
    let mut rows = materials::rows();
    rows.extend(solves::rows());
    rows
}

/// Prints the table; true if nothing failed.
pub fn run() -> bool {
    let style = Style::of_stdout();
    let rows = rows();
    let mut subject = "";
    for row in &rows {
        if row.subject != subject {
            println!("{}", style.bold(&row.subject));
            subject = &row.subject;
        }
        let (word, text) = match &row.outcome {
            Outcome::Right(text) => (style.green("right answer"), text),
            Outcome::ClearError(text) => ("clear error ".to_owned(), text),
            Outcome::Fail(text) => (style.red("FAIL        "), text),
        };
        println!("  {:<28} {word}  {text}", row.trial);
    }
    let count = |f: fn(&Outcome) -> bool| rows.iter().filter(|r| f(&r.outcome)).count();
    let failed = count(|o| matches!(o, Outcome::Fail(_)));
    println!(
        "\n{} trials: {} right answers, {} clear errors, {failed} failures",
        rows.len(),
        count(|o| matches!(o, Outcome::Right(_))),
        count(|o| matches!(o, Outcome::ClearError(_))),
    );
    failed == 0
}
