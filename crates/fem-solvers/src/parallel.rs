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
        return spread(tasks, &run);
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
        return spread(0..count, &run);
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

/// A task and the place of its result.
#[cfg(feature = "rayon")]
struct Pending<'a, T, R, F> {
    task: Option<T>,
    result: Option<R>,
    run: &'a F,
}

/// Something to be run once, whatever its types.
#[cfg(feature = "rayon")]
trait Run: Send {
    fn run(&mut self);
}

#[cfg(feature = "rayon")]
impl<T: Send, R: Send, F: Fn(T) -> R + Sync> Run for Pending<'_, T, R, F> {
    fn run(&mut self) {
        self.result = self.task.take().map(self.run);
    }
}

#[cfg(feature = "rayon")]
fn spread<T: Send, R: Send, C: FromIterator<R>>(
    tasks: impl IntoIterator<Item = T>,
    run: &(impl Fn(T) -> R + Sync),
) -> C {
    let pending = |task| Pending {
        task: Some(task),
        result: None,
        run,
    };
    let mut pending: Vec<_> = tasks.into_iter().map(pending).collect();
    let all = pending.iter_mut().map(|task| task as &mut dyn Run);
    run_all(all.collect());
    pending.into_iter().filter_map(|done| done.result).collect()
}

/// Not generic: what rayon makes of its types is compiled once, here, and not for every kind of task.
#[cfg(feature = "rayon")]
fn run_all(tasks: Vec<&mut dyn Run>) {
    tasks.into_par_iter().for_each(|task| task.run());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_tasks() {
        for count in [0, 1, 2, 7, 1000] {
            let tasks: Vec<String> = (0..count).map(|k| k.to_string()).collect();
            let same: Vec<String> = map(tasks.clone(), |task| task);
            assert_eq!(same, tasks);
            let indices: Vec<usize> = indexed(count, |k| k);
            assert!(indices.into_iter().eq(0..count));
        }
    }

    #[test]
    fn the_first_error_is_that_of_the_first_task_that_fails() {
        let odd = |k: usize| if k.is_multiple_of(2) { Ok(k) } else { Err(k) };
        assert_eq!(indexed::<_, Result<Vec<_>, _>>(100, odd), Err(1));
        let tasks: Vec<usize> = (0..100).step_by(2).collect();
        let even: Result<Vec<usize>, usize> = map(tasks.clone(), odd);
        assert_eq!(even, Ok(tasks));
    }
}
