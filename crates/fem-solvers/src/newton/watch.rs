//! A program around a solve looks on, and may end it.

use super::NewtonIteration;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

/// What a program around a solver is asked after the start and after every Newton step: a place for
/// progress, and `Break` ends the solve with [`NewtonFailure::Cancelled`](super::NewtonFailure).
///
/// ```
/// use fem_solvers::Watch;
/// use std::ops::ControlFlow;
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// let cancelled = Arc::new(AtomicBool::new(false));
/// let button = cancelled.clone();
/// let watch = Watch::new(move |step| {
///     println!("step {}: gradient {:e}", step.iteration, step.gradient_norm);
///     match button.load(Ordering::Relaxed) {
///         true => ControlFlow::Break(()),
///         false => ControlFlow::Continue(()),
///     }
/// });
/// # let _ = watch;
/// ```
#[derive(Clone)]
pub struct Watch(Arc<Asked>);

type Asked = dyn Fn(&NewtonIteration) -> ControlFlow<()> + Send + Sync;

impl Watch {
    /// Asks `ask`.
    pub fn new(ask: impl Fn(&NewtonIteration) -> ControlFlow<()> + Send + Sync + 'static) -> Self {
        Self(Arc::new(ask))
    }

    pub(super) fn ends(&self, step: &NewtonIteration) -> bool {
        (self.0)(step).is_break()
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}
