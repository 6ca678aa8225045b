//! Work on several threads, with results that do not depend on how many there are.
//!
//! Threads are those of the rayon pool that the solver is called in, or of rayon's own.

use std::ops::Range;

use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Does the same for all, in no order, and returns what comes of it in theirs.
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

/// Does it on a thread of the pool, if it is `worth` the way there: work is handed out more quickly from
/// there.
pub fn in_pool<R: Send>(worth: bool, f: impl FnOnce() -> R + Send) -> R {
    if worth && rayon::current_num_threads() > 1 { rayon::scope(|_| f()) } else { f() }
}

/// The pieces of a slice at ranges that lie one after the other from its start on, and the rest.
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
