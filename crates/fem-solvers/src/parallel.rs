//! Tasks on several threads with the feature `rayon`, one after the other without it. Results come in
//! the order of the tasks, so that sums of them have the same bits either way.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// Runs both.
#[cfg(feature = "rayon")]
pub fn join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    rayon::join(a, b);
}

/// Runs both.
#[cfg(not(feature = "rayon"))]
pub fn join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    a();
    b();
}

/// The result of every task; a single one runs on the calling thread.
pub fn map<T: Send, R: Send, C: FromIterator<R>>(
    tasks: Vec<T>,
    run: impl Fn(T) -> R + Send + Sync,
) -> C {
    #[cfg(feature = "rayon")]
    if tasks.len() > 1 {
        let results: Vec<R> = tasks.into_par_iter().map(run).collect();
        return results.into_iter().collect();
    }
    tasks.into_iter().map(run).collect()
}

/// The result for every index below `count`.
pub fn indexed<R: Send, C: FromIterator<R>>(
    count: usize,
    run: impl Fn(usize) -> R + Send + Sync,
) -> C {
    #[cfg(feature = "rayon")]
    if count > 1 {
        let results: Vec<R> = (0..count).into_par_iter().map(run).collect();
        return results.into_iter().collect();
    }
    (0..count).map(run).collect()
}

/// Runs every task.
pub fn each<T: Send>(tasks: impl IntoIterator<Item = T>, run: impl Fn(T) + Send + Sync) {
    map::<_, (), ()>(tasks.into_iter().collect(), run);
}

/// Threads that tasks are spread over.
pub fn threads() -> usize {
    #[cfg(feature = "rayon")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "rayon"))]
    1
}
