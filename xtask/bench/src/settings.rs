//! How large a run is.

use crate::failure::Failure;

/// How large a run is.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Smaller bodies.
    pub quick: bool,
    /// Also bars and faces of 300,000 and a million tetrahedra.
    pub large: bool,
    /// Cells along the short side, in place of a scene's own, for scenes that are grids.
    pub sizes: Option<Vec<usize>>,
    /// Most repetitions of a measurement; the fastest counts.
    pub repetitions: usize,
}

impl Settings {
    /// Bodies that take seconds even without optimization, each measured once.
    pub fn smallest() -> Self {
        Self {
            quick: true,
            large: false,
            sizes: Some(vec![2, 4]),
            repetitions: 1,
        }
    }

    /// The sizes that were asked for, or else those of a quick or a whole run.
    pub fn sizes(&self, quick: &[usize], whole: &[usize]) -> Vec<usize> {
        match &self.sizes {
            Some(sizes) => sizes.clone(),
            None => if self.quick { quick } else { whole }.to_vec(),
        }
    }

    /// One of two, by the length of the run.
    pub fn pick<T>(&self, quick: T, whole: T) -> T {
        if self.quick { quick } else { whole }
    }
}

/// Does something on so many threads.
///
/// # Errors
/// If there can be no such threads, or as `work`.
pub fn on_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool?.install(work)
}
