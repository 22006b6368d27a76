//! The fastest of several runs, and how much memory it took.

use crate::failure::Failure;
use std::fs;
use std::time::Instant;

/// What came of something, and what it cost.
#[derive(Clone, Debug)]
pub struct Timed<T> {
    /// What the last run gave.
    pub value: T,
    /// The fastest run, seconds.
    pub seconds: f64,
    /// The most memory that the process held, MiB, where the system tells.
    pub memory: Option<f64>,
}

/// No repetition begins after so many seconds.
const ENOUGH: f64 = 1.5;

/// Repeats something that takes what `prepare` makes; its time is not counted.
///
/// # Errors
/// As `prepare` and `work`.
pub fn fastest_with<P, T>(
    repetitions: usize,
    mut prepare: impl FnMut() -> Result<P, Failure>,
    mut work: impl FnMut(&mut P) -> Result<T, Failure>,
) -> Result<Timed<T>, Failure> {
    let (mut best, mut spent) = (f64::INFINITY, 0.0);
    let mut count = 0;
    forget_peak();
    loop {
        let mut prepared = prepare()?;
        let begin = Instant::now();
        let value = work(&mut prepared)?;
        let seconds = begin.elapsed().as_secs_f64();
        best = best.min(seconds);
        spent += seconds;
        count += 1;
        if count >= repetitions || spent > ENOUGH {
            return Ok(Timed {
                value,
                seconds: best,
                memory: peak_memory(),
            });
        }
    }
}

/// Repeats something.
///
/// # Errors
/// As `work`.
pub fn fastest<T>(
    repetitions: usize,
    mut work: impl FnMut() -> Result<T, Failure>,
) -> Result<Timed<T>, Failure> {
    fastest_with(repetitions, || Ok(()), |()| work())
}

/// The peak that Linux keeps starts anew; elsewhere nothing happens.
fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

fn peak_memory() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}
