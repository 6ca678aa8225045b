//! The arithmetic of one front by several threads.

use pulp::{Arch, Simd, WithSimd};
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

/// Minimum number of multiplications of a piece that another thread may take. They last some ten
/// microseconds, a few times as long as it takes to hand them out.
const MIN_PIECE: usize = 100_000;

/// Evaluates what `operation` makes of consecutive units of `data`, given the number of the first:
/// all at once, or in pieces on the threads of the pool if `share` has the instructions of the
/// machine. A unit has `len` numbers and takes about `work` multiplications.
#[inline(always)]
pub fn in_pieces<'a, S: Simd, O: WithSimd<Output = ()>>(
    simd: S,
    share: Option<Arch>,
    data: &'a mut [f64],
    len: usize,
    work: usize,
    operation: impl Fn(usize, &'a mut [f64]) -> O + Sync,
) {
    let units = MIN_PIECE.div_ceil(work.max(1));
    match share {
        Some(instructions) if data.len() > units * len => {
            let pieces = data.par_chunks_mut(units * len).enumerate();
            pieces.for_each(|(k, piece)| instructions.dispatch(operation(k * units, piece)));
        }
        _ => operation(0, data).with_simd(simd),
    }
}
