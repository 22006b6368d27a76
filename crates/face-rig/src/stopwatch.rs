//! How long equilibria and fits take, for reports: the only clock in the libraries.

use std::time::Duration;

/// Time since [`Stopwatch::start`]. In a browser there is no clock to read, and it stays at zero.
pub(crate) struct Stopwatch {
    #[cfg(not(target_family = "wasm"))]
    begin: std::time::Instant,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self {
            #[cfg(not(target_family = "wasm"))]
            begin: std::time::Instant::now(),
        }
    }

    #[cfg(not(target_family = "wasm"))]
    pub fn elapsed(&self) -> Duration {
        self.begin.elapsed()
    }

    #[cfg(target_family = "wasm")]
    pub fn elapsed(&self) -> Duration {
        Duration::ZERO
    }
}
