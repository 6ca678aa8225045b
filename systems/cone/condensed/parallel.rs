//! Work on several threads, with results that do not depend on the number of threads.
//!
//! The threads are those of the rayon pool in which the solver is called, or of the global pool.

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Whether the pool has one thread.
pub fn is_alone() -> bool {
    rayon::current_num_threads() == 1
}

/// Calls `f` for all items, in any order, and returns the results in the order of the items.
pub(crate) fn in_parallel<T: Send, R: Send>(
    items: impl Iterator<Item = T>,
    f: impl Fn(T) -> R + Sync + Send,
) -> Vec<R> {
    let items: Vec<T> = items.collect();
    if items.len() < 2 || is_alone() {
        items.into_iter().map(f).collect()
    } else {
        items.into_par_iter().map(f).collect()
    }
}

/// Calls `f` on a thread of the pool if `worth` it: a thread of the pool hands out work more
/// quickly.
pub(crate) fn in_pool<R: Send>(worth: bool, f: impl FnOnce() -> R + Send) -> R {
    if worth && !is_alone() { rayon::scope(|_| f()) } else { f() }
}

/// Calls two functions, on two threads if `worth` it.
pub fn join<A: Send, B: Send>(
    worth: bool,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if worth && !is_alone() { rayon::join(a, b) } else { (a(), b()) }
}

/// The pieces of a slice at ascending ranges.
pub fn split<T>(slice: &mut [T], ranges: impl Iterator<Item = Range<usize>>) -> Vec<&mut [T]> {
    let (mut pieces, mut rest, mut at) = (Vec::new(), slice, 0);
    for range in ranges {
        let (piece, after) = rest.split_at_mut(range.end - at);
        pieces.push(&mut piece[range.start - at..]);
        (rest, at) = (after, range.end);
    }
    pieces
}

/// Working memory of threads. A thread that waits for others may begin other work in between, so that
/// the memory belongs to the work, not to the thread.
#[derive(Default)]
pub struct Memory(Mutex<Vec<Vec<f64>>>);

impl Memory {
    fn free(&self) -> MutexGuard<'_, Vec<Vec<f64>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// At least `len` numbers of any value: those that fit best. If none fit, the longest make room
    /// for new ones, so that no more pieces are kept than were ever in use at once.
    pub fn take(&self, len: usize) -> Vec<f64> {
        let mut free = self.free();
        let fits = (0..free.len()).filter(|k| free[*k].len() >= len);
        if let Some(best) = fits.min_by_key(|k| free[*k].len()) {
            return free.swap_remove(best);
        }
        if let Some(longest) = (0..free.len()).max_by_key(|k| free[*k].len()) {
            free.swap_remove(longest);
        }
        drop(free);
        vec![0.0; len]
    }

    /// Takes numbers back.
    pub fn give(&self, numbers: Vec<f64>) {
        if !numbers.is_empty() {
            self.free().push(numbers);
        }
    }
}
