//! A row of the table: what is tried, what it must give, and how it is judged.

use crate::Failure;
use fem_solvers::NewtonParams;

/// What holds for all rows of a run.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Smaller bodies, and only the rows that end soon.
    pub quick: bool,
    /// Of all random numbers.
    pub seed: u64,
    /// At most so many Newton steps in each solve: with few of them the table must turn red.
    pub newton_limit: Option<usize>,
}

impl Settings {
    /// Newton's settings with at most so many steps, or as few as the run allows.
    pub fn newton(&self, steps: usize) -> NewtonParams {
        NewtonParams {
            max_iterations: self.newton_limit.map_or(steps, |limit| limit.min(steps)),
            ..NewtonParams::default()
        }
    }
}

/// What a row gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// A solve that converges, with a residual, summed independently, below what the solver promised.
    Answer,
    /// A property of something that is not solved.
    Property,
    /// Exactly this error, as `Type::Variant`.
    Error(&'static str),
    /// The same, of a solve that did not give up before so many steps.
    ErrorAfter(&'static str, usize),
}

/// What was measured of something that succeeded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Steps of Newton's method, or what else was counted.
    pub steps: usize,
    /// The worst that was found: a force left (N), a distance (m), a relative error.
    pub left: f64,
    /// What of it is allowed.
    pub allowed: f64,
    /// What else is worth a line.
    pub note: String,
}

impl Evidence {
    /// Of something that either holds or not.
    pub fn holds(note: impl Into<String>) -> Self {
        Self {
            note: note.into(),
            ..Self::default()
        }
    }

    /// The one of two that is nearer to its bound; steps add up.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let steps = self.steps + other.steps;
        let note = match (self.note.as_str(), other.note.as_str()) {
            ("", note) | (note, "") => note.to_owned(),
            (a, b) => format!("{a}; {b}"),
        };
        let worse = if self.share() >= other.share() || self.share().is_nan() {
            self
        } else {
            other
        };
        Self {
            steps,
            note,
            ..worse
        }
    }

    fn share(&self) -> f64 {
        if self.left == 0.0 {
            0.0
        } else {
            self.left / self.allowed
        }
    }
}

/// Whether a row gave what it says.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It did.
    Passed,
    /// It did not: why.
    Failed(String),
    /// What it needs is not here: what.
    Skipped(String),
}

/// What a row runs.
pub type Run = Box<dyn Fn(&Settings) -> Result<Evidence, Failure> + Send + Sync>;

/// One row.
pub struct Row {
    /// The rows that belong together.
    pub family: &'static str,
    /// Its name, unique in the table.
    pub name: String,
    /// What is tried, for a reader.
    pub what: String,
    /// What it must give.
    pub expected: Expected,
    /// Is it part of a quick run?
    pub quick: bool,
    /// The trial.
    pub run: Run,
}

impl Row {
    /// A row of quick and long runs.
    pub fn new(
        family: &'static str,
        name: impl Into<String>,
        what: impl Into<String>,
        expected: Expected,
        run: impl Fn(&Settings) -> Result<Evidence, Failure> + Send + Sync + 'static,
    ) -> Self {
        Self {
            family,
            name: name.into(),
            what: what.into(),
            expected,
            quick: true,
            run: Box::new(run),
        }
    }

    /// The same for long runs only.
    #[must_use]
    pub fn long(self) -> Self {
        Self {
            quick: false,
            ..self
        }
    }

    /// Judges what came of it.
    pub fn judge(&self, result: &Result<Evidence, Failure>) -> Verdict {
        let failed = |reason: String| Verdict::Failed(reason);
        match (self.expected, result) {
            (_, Err(failure)) if failure.kind == Failure::SKIPPED => {
                Verdict::Skipped(failure.message.clone())
            }
            (Expected::Answer | Expected::Property, Ok(evidence)) => {
                if evidence.left <= evidence.allowed {
                    Verdict::Passed
                } else {
                    let Evidence { left, allowed, .. } = evidence;
                    failed(format!("{left:.1e} left, {allowed:.1e} allowed"))
                }
            }
            (Expected::Error(kind), _) => judge_error(kind, 0, result),
            (Expected::ErrorAfter(kind, steps), _) => judge_error(kind, steps, result),
            (_, Err(failure)) => failed(format!("{}: {}", failure.kind, failure.message)),
        }
    }
}

fn judge_error(kind: &str, steps: usize, result: &Result<Evidence, Failure>) -> Verdict {
    let reason = match result {
        Ok(_) => format!("a success, {kind} expected"),
        Err(failure) if failure.kind != kind => {
            let Failure {
                kind: other,
                message,
                ..
            } = failure;
            format!("{other}, {kind} expected: {message}")
        }
        Err(failure) if failure.message.trim().is_empty() => format!("{kind} without a word"),
        Err(failure) if failure.steps < steps => {
            format!("{kind} after {} steps, {steps} expected", failure.steps)
        }
        Err(_) => return Verdict::Passed,
    };
    Verdict::Failed(reason)
}
