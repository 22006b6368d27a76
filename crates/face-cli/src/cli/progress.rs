//! Bars and spinners on the error stream; silent where that is no terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A spinner with a message, for work of unknown length.
pub fn spinner(message: impl Into<String>) -> ProgressBar {
    let bar = ProgressBar::new_spinner().with_message(message.into());
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// A bar over `count` things of a kind.
pub fn bar(count: usize, kind: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(count as u64).with_prefix(kind);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix} {pos}/{len} {bar:30} {msg} ({elapsed})")
    {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
