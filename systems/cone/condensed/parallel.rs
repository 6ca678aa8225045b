//! Work on several threads, with results that do not depend on the number of threads.
//!
//! The threads are those of the rayon pool in which the solver is called, or of the global pool.

use std::ops::Range;

use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Calls `f` for all items, in any order, and returns the results in the order of the items.
pub fn in_parallel<T: Send, R: Send>(
    items: impl Iterator<Item = T>,
    f: impl Fn(T) -> R + Sync + Send,
) -> Vec<R> {
    let items: Vec<T> = items.collect();
    if items.len() < 2 || rayon::current_num_threads() == 1 {
        items.into_iter().map(f).collect()
    } else {
        items.into_par_iter().map(f).collect()
    }
}

/// Calls `f` on a thread of the pool if `worth` it: a thread of the pool hands out work more
/// quickly.
pub fn in_pool<R: Send>(worth: bool, f: impl FnOnce() -> R + Send) -> R {
    if worth && rayon::current_num_threads() > 1 { rayon::scope(|_| f()) } else { f() }
}

/// The pieces of a slice at consecutive ranges from its start, and the rest.
pub fn split<T>(
    slice: &mut [T],
    ranges: impl Iterator<Item = Range<usize>>,
) -> (Vec<&mut [T]>, &mut [T]) {
    let (mut pieces, mut rest) = (Vec::new(), slice);
    for range in ranges {
        let (piece, after) = rest.split_at_mut(range.len());
        pieces.push(piece);
        rest = after;
    }
    (pieces, rest)
}
