//! The table as text, Markdown and CSV.

use crate::row::{Expected, Row, Settings, Verdict};
use crate::runner::Record;
use std::path::Path;
use workbench::report::Style;

fn word(expected: Expected) -> &'static str {
    match expected {
        Expected::Answer => "answer",
        Expected::Property => "holds",
        Expected::Error(kind) | Expected::ErrorAfter(kind, _) => kind,
    }
}

/// Steps and what is left, as text; empty for an error.
fn numbers(record: &Record) -> [String; 3] {
    match &record.result {
        Ok(e) => [
            e.steps.to_string(),
            format!("{:.1e}", e.left),
            format!("{:.1e}", e.allowed),
        ],
        Err(_) => Default::default(),
    }
}

fn note(record: &Record) -> String {
    match (&record.verdict, &record.result) {
        (Verdict::Failed(reason) | Verdict::Skipped(reason), _) => reason.clone(),
        (_, Ok(evidence)) => evidence.note.clone(),
        (_, Err(failure)) => failure.message.clone(),
    }
}

/// Prints the names of rows.
pub fn list(rows: &[&Row]) {
    for row in rows {
        let quick = if row.quick { "" } else { " (long runs)" };
        let expected = word(row.expected);
        println!(
            "{}/{}: {}; {expected}{quick}",
            row.family, row.name, row.what
        );
    }
}

/// Prints one row.
pub fn line(record: &Record, style: Style) {
    let verdict = match record.verdict {
        Verdict::Passed => style.green("ok    "),
        Verdict::Failed(_) => style.red("FAILED"),
        Verdict::Skipped(_) => "skip  ".to_owned(),
    };
    let [steps, left, allowed] = numbers(record);
    let name = &record.name;
    let expected = word(record.expected);
    let seconds = record.seconds;
    println!(
        "  {verdict} {name:<44} {expected:<32} {steps:>5} {seconds:>7.2} s  {left:>8} {allowed:>8}  {}",
        note(record).lines().next().unwrap_or_default()
    );
}

/// The last line; true if nothing failed.
pub fn summary(records: &[Record], settings: &Settings) -> bool {
    let failed = |r: &&Record| matches!(r.verdict, Verdict::Failed(_));
    let skipped = records
        .iter()
        .filter(|r| matches!(r.verdict, Verdict::Skipped(_)))
        .count();
    let count = |f: fn(Expected) -> bool| records.iter().filter(|r| f(r.expected)).count();
    let seconds: f64 = records.iter().map(|r| r.seconds).sum();
    let bad = records.iter().filter(failed).count();
    eprintln!(
        "{} rows ({} answers, {} properties, {} errors by name), {skipped} skipped, {bad} FAILED, {seconds:.0} s, seed {:#x}",
        records.len(),
        count(|e| e == Expected::Answer),
        count(|e| e == Expected::Property),
        count(|e| matches!(e, Expected::Error(_) | Expected::ErrorAfter(..))),
        settings.seed
    );
    for record in records.iter().filter(failed) {
        eprintln!("FAILED {}: {}", record.name, note(record));
    }
    bad == 0
}

/// The table for a page.
pub fn markdown(records: &[Record]) -> String {
    let mut text = String::new();
    let mut family = "";
    for record in records {
        if record.family != family {
            family = record.family;
            text += &format!(
                "\n**{family}**\n\n| row | tried | gives | steps | seconds | left | allowed | |\n|---|---|---|---:|---:|---:|---:|---|\n"
            );
        }
        let [steps, left, allowed] = numbers(record);
        let verdict = match record.verdict {
            Verdict::Passed => "ok",
            Verdict::Failed(_) => "**FAILED**",
            Verdict::Skipped(_) => "not here",
        };
        text += &format!(
            "| `{}` | {} | {} | {steps} | {:.1} | {left} | {allowed} | {verdict} |\n",
            record.name,
            record.what.replace('|', "\\|"),
            word(record.expected),
            record.seconds,
        );
    }
    text
}

/// Writes all columns to a file.
pub fn csv(records: &[Record], path: &Path) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_path(path)?;
    writer.write_record([
        "family", "row", "tried", "gives", "verdict", "steps", "seconds", "left", "allowed", "note",
    ])?;
    for record in records {
        let verdict = match record.verdict {
            Verdict::Passed => "ok",
            Verdict::Failed(_) => "FAILED",
            Verdict::Skipped(_) => "skipped",
        };
        let [steps, left, allowed] = numbers(record);
        writer.write_record([
            record.family,
            &record.name,
            &record.what,
            word(record.expected),
            verdict,
            &steps,
            &format!("{:.3}", record.seconds),
            &left,
            &allowed,
            &note(record),
        ])?;
    }
    writer.flush()?;
    Ok(())
}
