//! Memory of fronts that are done with, for the next ones.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Fronts take their memory here and give it back, so that the system neither clears nor maps it again:
/// it does both on one thread at a time.
pub struct Pool<T>(Mutex<Vec<Vec<T>>>);

impl<T: Copy + Default> Pool<T> {
    pub fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// So many numbers, whatever they are.
    pub fn take(&self, len: usize) -> Memory<'_, T> {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |memory: &Vec<T>| memory.len() >= len && memory.len() <= 2 * len;
        let best = (0..idle.len())
            .filter(|&k| fits(&idle[k]))
            .min_by_key(|&k| idle[k].len());
        let memory = best.map(|k| idle.swap_remove(k));
        drop(idle);
        Memory {
            memory: memory.unwrap_or_else(|| vec![T::default(); len + len / 8]),
            len,
            pool: self,
        }
    }
}

/// Goes back where it came from.
pub struct Memory<'a, T> {
    memory: Vec<T>,
    len: usize,
    pool: &'a Pool<T>,
}

impl<T> Deref for Memory<'_, T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.memory[..self.len]
    }
}

impl<T> DerefMut for Memory<'_, T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.memory[..self.len]
    }
}

impl<T> Drop for Memory<'_, T> {
    fn drop(&mut self) {
        let memory = std::mem::take(&mut self.memory);
        let mut idle = self.pool.0.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(memory);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_comes_back_where_it_fits() {
        let pool = Pool::<f64>::new();
        let (small, large) = (pool.take(10), pool.take(1000));
        let (at, far) = (small.as_ptr(), large.as_ptr());
        drop((small, large));
        assert_eq!(pool.take(9).as_ptr(), at);
        assert_eq!(pool.take(900).as_ptr(), far);
        // Most of it would lie idle.
        let other = pool.take(100);
        assert!(other.len() == 100 && other.as_ptr() != far);
    }
}
