//! Runs rows and prints what came of them.

use crate::row::{Evidence, Expected, Row, Settings, Verdict};
use crate::{Failure, rows, table};
use std::any::Any;
use std::io::{IsTerminal, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::Instant;
use workbench::report::Style;

/// What can be typed.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Smaller bodies, and only the rows that end soon: under a minute
    #[arg(long)]
    pub quick: bool,
    /// Seed of all random numbers, decimal or hexadecimal after 0x
    #[arg(long, value_name = "N", default_value = "1", value_parser = seed)]
    pub seed: u64,
    /// Only rows with this in their name or family; repeatable
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Only say which rows there are
    #[arg(long)]
    pub list: bool,
    /// Write the table to this file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Print the table as Markdown
    #[arg(long)]
    pub markdown: bool,
    /// At most so many Newton steps in each solve: with 1 nearly every answer must turn red
    #[arg(long, value_name = "N")]
    pub newton_limit: Option<usize>,
}

fn seed(text: &str) -> Result<u64, String> {
    fem_materials::conformance::parse_seed(text)
        .ok_or_else(|| "a seed is a whole number, decimal or hexadecimal after 0x".to_owned())
}

/// A row that ran.
#[derive(Clone, Debug)]
pub struct Record {
    /// The rows it belongs to.
    pub family: &'static str,
    /// Its name.
    pub name: String,
    /// What was tried.
    pub what: String,
    /// What it had to give.
    pub expected: Expected,
    /// What it gave.
    pub result: Result<Evidence, Failure>,
    /// Whether that is the same.
    pub verdict: Verdict,
    /// How long it took.
    pub seconds: f64,
}

/// Runs rows one after the other; `done` sees each when it ends, `begun` when it starts. A panic is a
/// failure.
pub fn run_rows<'a>(
    rows: impl IntoIterator<Item = &'a Row>,
    settings: &Settings,
    begun: &mut dyn FnMut(&Row),
    done: &mut dyn FnMut(&Record),
) -> Vec<Record> {
    let one = |row: &Row| {
        begun(row);
        let start = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| (row.run)(settings)))
            .unwrap_or_else(|panic| Err(panicked(&*panic)));
        let record = Record {
            family: row.family,
            name: row.name.clone(),
            what: row.what.clone(),
            expected: row.expected,
            verdict: row.judge(&result),
            result,
            seconds: start.elapsed().as_secs_f64(),
        };
        done(&record);
        record
    };
    rows.into_iter().map(one).collect()
}

fn panicked(payload: &(dyn Any + Send)) -> Failure {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
    Failure::new("panic", text.unwrap_or("without a message"))
}

/// Runs the table; true if every row gave what it says.
///
/// # Errors
/// If no row has the name, or the file cannot be written.
pub fn run(options: &Options) -> Result<bool, String> {
    let settings = Settings {
        quick: options.quick,
        seed: options.seed,
        newton_limit: options.newton_limit,
    };
    let all = rows::all();
    let wanted: Vec<&Row> = all.iter().filter(|row| wanted(row, options)).collect();
    if wanted.is_empty() {
        let names = options.only.join(", ");
        return Err(format!("no row is named {names}; --list shows them"));
    }
    if options.list {
        table::list(&wanted);
        return Ok(true);
    }
    let records = shown(&wanted, &settings, options.markdown);
    if options.markdown {
        print!("{}", table::markdown(&records));
    }
    if let Some(path) = &options.csv {
        table::csv(&records, path).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(table::summary(&records, &settings))
}

fn wanted(row: &Row, options: &Options) -> bool {
    let named = |name: &String| row.name.contains(name.as_str()) || row.family == name;
    let named = options.only.is_empty() || options.only.iter().any(named);
    named && (row.quick || !options.quick)
}

fn shown(rows: &[&Row], settings: &Settings, silent: bool) -> Vec<Record> {
    let style = Style::of_stdout();
    let live = std::io::stderr().is_terminal();
    let (count, mut place, mut family) = (rows.len(), 0, "");
    let mut begun = |row: &Row| {
        place += 1;
        if live {
            eprint!("\r\x1b[K{place}/{count} {} …", row.name);
            let _ = std::io::stderr().flush();
        }
    };
    let mut done = |record: &Record| {
        if live {
            eprint!("\r\x1b[K");
        }
        if silent {
            return;
        }
        if record.family != family {
            family = record.family;
            println!("{}", style.bold(family));
        }
        table::line(record, style);
    };
    run_rows(rows.iter().copied(), settings, &mut begun, &mut done)
}
