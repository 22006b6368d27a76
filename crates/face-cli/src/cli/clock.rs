//! How long the phases of a run take, from the start of the program on.

use std::time::{Duration, Instant};

/// Counts all time to some phase: what no phase is entered for belongs to the one before, so that the
/// phases add up to the whole.
pub struct Clock {
    /// The time since the clock was made.
    now: Box<dyn Fn() -> Duration + Send>,
    phases: Vec<(String, Duration)>,
    /// The phase that is running, and when it was entered.
    running: (usize, Duration),
}

impl Clock {
    /// A clock whose first phase, `start`, begins now.
    pub fn start() -> Self {
        let begin = Instant::now();
        Self::reading(move || begin.elapsed())
    }

    fn reading(now: impl Fn() -> Duration + Send + 'static) -> Self {
        Self {
            running: (0, now()),
            now: Box::new(now),
            phases: vec![("start".into(), Duration::ZERO)],
        }
    }

    /// From now on time counts to this phase; one that was entered before goes on.
    pub fn enter(&mut self, name: &str) {
        let now = (self.now)();
        let (last, entered) = self.running;
        self.phases[last].1 += now.saturating_sub(entered);
        let known = self.phases.iter().position(|(known, _)| known == name);
        let next = known.unwrap_or_else(|| {
            self.phases.push((name.into(), Duration::ZERO));
            self.phases.len() - 1
        });
        self.running = (next, now);
    }

    /// All phases in the order in which they were first entered, seconds; the last one until now.
    pub fn seconds(&self) -> Vec<(&str, f64)> {
        let (running, entered) = self.running;
        let since = (self.now)().saturating_sub(entered);
        let phases = self.phases.iter().enumerate();
        let seconds = phases.map(|(k, (name, counted))| {
            let more = if k == running { since } else { Duration::ZERO };
            (name.as_str(), (*counted + more).as_secs_f64())
        });
        seconds.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    #[test]
    fn every_second_counts_to_the_phase_that_was_entered_last() {
        let time = Arc::new(AtomicU64::new(100));
        let wait = |seconds| time.fetch_add(seconds, Relaxed);
        let read = time.clone();
        let mut clock = Clock::reading(move || Duration::from_secs(read.load(Relaxed)));
        wait(1);
        clock.enter("scene");
        wait(2);
        clock.enter("fit");
        wait(4);
        clock.enter("files");
        wait(8);
        clock.enter("fit");
        wait(16);
        let all = [
            ("start", 1.0),
            ("scene", 2.0),
            ("fit", 20.0),
            ("files", 8.0),
        ];
        assert_eq!(clock.seconds(), all);
        // Asking stops nothing.
        wait(32);
        assert_eq!(clock.seconds()[2], ("fit", 52.0));
        clock.enter("files");
        wait(64);
        assert_eq!(clock.seconds()[2..], [("fit", 52.0), ("files", 72.0)]);
    }
}
