//! How long equilibria and fits take, for reports: the only clock in the libraries but the one that
//! seeds the conformance suite of `fem-materials`.

use std::time::Duration;

/// Time since [`Stopwatch::start`]. In a browser there is no clock to read, and it stays at zero.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    #[cfg(not(target_family = "wasm"))]
    begin: std::time::Instant,
}

impl Stopwatch {
    /// Now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            #[cfg(not(target_family = "wasm"))]
            begin: std::time::Instant::now(),
        }
    }

    /// Wall-clock time since the start.
    #[cfg(not(target_family = "wasm"))]
    pub fn elapsed(&self) -> Duration {
        self.begin.elapsed()
    }

    /// Zero: there is no clock.
    #[cfg(target_family = "wasm")]
    pub fn elapsed(&self) -> Duration {
        Duration::ZERO
    }
}
