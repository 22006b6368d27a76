//! The book of all comparisons: what was measured, how far off, and whether that is allowed.

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// All comparisons of one quantity of one group within one category.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// Model, scene or suite.
    pub group: String,
    /// What was compared: psi, P, dP/dF, …
    pub quantity: String,
    /// Kind of input: near_identity, flat, …
    pub category: String,
    /// How many comparisons.
    pub cases: usize,
    /// The largest error, in units of the tolerance's base (C for tables).
    pub worst: f64,
    /// Where it was reached.
    pub worst_id: String,
    /// The largest error that is allowed.
    pub bound: f64,
    /// The ids beyond the bound.
    pub failures: Vec<String>,
}

/// The book.
#[derive(Clone, Debug, Default)]
pub struct Report {
    entries: Vec<Entry>,
    index: BTreeMap<(String, String, String), usize>,
    /// What could not be compared at all, and why.
    pub broken: Vec<String>,
    /// What is not comparable by its nature, and how that was seen; no failure.
    pub notes: Vec<String>,
}

impl Report {
    /// Writes down one comparison. A NaN counts as worse than everything.
    pub fn record(
        &mut self,
        group: &str,
        quantity: &str,
        category: &str,
        id: &str,
        error: f64,
        bound: f64,
    ) {
        let key = (group.to_owned(), quantity.to_owned(), category.to_owned());
        let entries = &mut self.entries;
        let at = *self.index.entry(key).or_insert_with(|| {
            entries.push(Entry {
                group: group.to_owned(),
                quantity: quantity.to_owned(),
                category: category.to_owned(),
                cases: 0,
                worst: 0.0,
                worst_id: id.to_owned(),
                bound,
                failures: Vec::new(),
            });
            entries.len() - 1
        });
        let entry = &mut self.entries[at];
        entry.cases += 1;
        if error.is_nan() || error > entry.worst {
            entry.worst = if entry.worst.is_nan() {
                f64::NAN
            } else {
                error
            };
            entry.worst_id = id.to_owned();
        }
        let within = error <= bound;
        if !within {
            entry.failures.push(id.to_owned());
        }
    }

    /// Writes down, once, that something could not be compared, which fails the run.
    pub fn broken(&mut self, what: String) {
        if !self.broken.contains(&what) {
            self.broken.push(what);
        }
    }

    /// Writes down, once, that something is not comparable.
    pub fn note(&mut self, what: String) {
        if !self.notes.contains(&what) {
            self.notes.push(what);
        }
    }

    /// All entries, in the order of their first comparison.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The entries that failed.
    pub fn failures(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|e| !e.failures.is_empty())
    }

    /// Did everything hold?
    pub fn passed(&self) -> bool {
        self.broken.is_empty() && self.failures().next().is_none()
    }

    /// For use in a test.
    ///
    /// # Panics
    /// With the table of everything and the list of failures, when something did not hold.
    pub fn assert(&self) {
        assert!(
            self.passed(),
            "\n{}\n{}",
            self.tables(Style::Plain),
            self.summary(Style::Plain)
        );
    }

    fn groups(&self) -> Vec<&str> {
        let mut groups: Vec<&str> = Vec::new();
        for entry in &self.entries {
            if !groups.contains(&entry.group.as_str()) {
                groups.push(&entry.group);
            }
        }
        groups
    }

    /// One table for each group: categories down, quantities across, the worst error in the cells.
    pub fn tables(&self, style: Style) -> String {
        let mut out = String::new();
        for group in self.groups() {
            let own: Vec<&Entry> = self.entries.iter().filter(|e| e.group == group).collect();
            let (rows, columns) = (
                unique(own.iter().map(|e| e.category.as_str())),
                unique(own.iter().map(|e| e.quantity.as_str())),
            );
            let label = rows.iter().map(|r| width(r)).max().unwrap_or(0).max(14);
            let _ = writeln!(out, "{}", style.bold(group));
            let _ = write!(out, "  {}", pad_right("", label));
            for column in &columns {
                let _ = write!(out, "  {}", pad_left(column, cell_width(column)));
            }
            out.push('\n');
            for row in rows {
                let _ = write!(out, "  {}", pad_right(row, label));
                for column in &columns {
                    let found = own
                        .iter()
                        .find(|e| e.category == row && e.quantity == *column);
                    let text = found.map_or("·".to_owned(), |e| number(e.worst));
                    let padded = pad_left(&text, cell_width(column));
                    let failed = found.is_some_and(|e| !e.failures.is_empty());
                    let _ = write!(
                        out,
                        "  {}",
                        if failed { style.red(&padded) } else { padded }
                    );
                }
                out.push('\n');
            }
            out.push('\n');
        }
        out
    }

    /// One line for each group, then every failure by name.
    pub fn summary(&self, style: Style) -> String {
        let mut out = String::new();
        let groups = self.groups();
        let label = groups.iter().map(|g| width(g)).max().unwrap_or(0);
        for group in &groups {
            let own = || self.entries.iter().filter(|e| e.group == *group);
            let cases: usize = own().map(|e| e.cases).sum();
            let failed: usize = own().map(|e| e.failures.len()).sum();
            let tightest = own()
                .max_by(|a, b| share(a).total_cmp(&share(b)))
                .expect("a group has an entry");
            let verdict = if failed == 0 {
                style.green("ok    ")
            } else {
                style.red("FAILED")
            };
            let _ = writeln!(
                out,
                "  {}  {verdict}  {:>6} comparisons, worst {} of {} in {} ({}, id {})",
                pad_right(group, label),
                cases,
                number(tightest.worst),
                number(tightest.bound),
                tightest.quantity,
                tightest.category,
                tightest.worst_id,
            );
        }
        for entry in self.failures() {
            let ids = entry.failures.iter().take(6).cloned().collect::<Vec<_>>();
            let more = entry.failures.len().saturating_sub(ids.len());
            let tail = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            let _ = writeln!(
                out,
                "{} {} / {} / {}: {} of {} beyond {} (worst {}), id {}{tail}",
                style.red("FAILED"),
                entry.group,
                entry.quantity,
                entry.category,
                entry.failures.len(),
                entry.cases,
                number(entry.bound),
                number(entry.worst),
                ids.join(", "),
            );
        }
        for what in &self.notes {
            let _ = writeln!(out, "note   {what}");
        }
        for what in &self.broken {
            let _ = writeln!(out, "{} {what}", style.red("FAILED"));
        }
        out
    }
}

/// How much of the bound is used up; NaN counts as all and more.
fn share(entry: &Entry) -> f64 {
    let share = entry.worst / entry.bound;
    match (share.is_nan(), entry.worst == 0.0) {
        (_, true) => 0.0,
        (true, _) => f64::INFINITY,
        _ => share,
    }
}

/// Colors or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// For files and tests.
    Plain,
    /// For terminals.
    Color,
}

impl Style {
    /// Color on a terminal, unless `NO_COLOR` is set.
    pub fn of_stdout() -> Self {
        use std::io::IsTerminal;
        let wanted = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        if wanted { Self::Color } else { Self::Plain }
    }

    fn paint(self, code: &str, text: &str) -> String {
        match self {
            Self::Plain => text.to_owned(),
            Self::Color => format!("\x1b[{code}m{text}\x1b[0m"),
        }
    }

    /// Bold.
    pub fn bold(self, text: &str) -> String {
        self.paint("1", text)
    }

    /// Red and bold, for failures.
    pub fn red(self, text: &str) -> String {
        self.paint("1;31", text)
    }

    /// Green.
    pub fn green(self, text: &str) -> String {
        self.paint("32", text)
    }
}

fn unique<'a>(items: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all = Vec::new();
    for item in items {
        if !all.contains(&item) {
            all.push(item);
        }
    }
    all
}

fn width(text: &str) -> usize {
    text.chars().count()
}

fn cell_width(column: &str) -> usize {
    width(column).max(8)
}

fn pad_left(text: &str, to: usize) -> String {
    " ".repeat(to.saturating_sub(width(text))) + text
}

fn pad_right(text: &str, to: usize) -> String {
    text.to_owned() + &" ".repeat(to.saturating_sub(width(text)))
}

/// Short and readable: `0`, `3.42`, `1.2e-9`.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".to_owned()
    } else if !x.is_finite() {
        format!("{x}")
    } else if (0.01..1000.0).contains(&size) {
        format!("{x:.2}")
    } else {
        format!("{x:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_name_group_quantity_category_and_id() {
        let mut report = Report::default();
        report.record("model", "P", "flat", "7", 1.0, 32.0);
        report.record("model", "P", "flat", "8", f64::NAN, 32.0);
        report.record("model", "P", "flat", "9", 3.0, 32.0);
        assert!(!report.passed());
        let failed: Vec<_> = report.failures().collect();
        assert_eq!(failed[0].failures, ["8"]);
        assert!(failed[0].worst.is_nan());
        let summary = report.summary(Style::Plain);
        assert!(summary.contains("model / P / flat") && summary.contains("id 8"));
        assert!(report.tables(Style::Plain).contains("NaN"));
    }

    #[test]
    fn what_is_broken_fails_the_run() {
        let mut report = Report::default();
        assert!(report.passed());
        report.broken("no table".to_owned());
        assert!(!report.passed());
    }
}
