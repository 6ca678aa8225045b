//! The arithmetic of one front by several threads.

use pulp::{Arch, Simd, WithSimd};
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use super::super::parallel::is_alone;

/// Minimum number of multiplications of a piece that another thread may take. They last some ten
/// microseconds, a few times as long as it takes to hand them out.
const MIN_PIECE: usize = 100_000;

/// Who works on a front: [`Alone`] one thread, [`Arch`] the threads of the pool with these
/// instructions. It is a type because the loops of one thread are slower where the compiler has to
/// provide for both.
pub trait Share: Copy + Sync {
    /// The instructions for the other threads; `None` for one thread.
    fn instructions(self) -> Option<Arch>;
}

/// One thread works on a front.
#[derive(Clone, Copy)]
pub(crate) struct Alone;

impl Share for Alone {
    #[inline(always)]
    fn instructions(self) -> Option<Arch> {
        None
    }
}

impl Share for Arch {
    #[inline(always)]
    fn instructions(self) -> Option<Arch> {
        Some(self)
    }
}

/// Work on fronts, and who does it.
pub struct By<H, W>(pub H, pub W);

/// Does the work, with the threads of the pool on large fronts if it is `shared`.
pub(crate) fn dispatch<W, R>(instructions: Arch, shared: bool, work: W) -> R
where
    By<Alone, W>: WithSimd<Output = R>,
    By<Arch, W>: WithSimd<Output = R>,
{
    if !shared || is_alone() {
        instructions.dispatch(By(Alone, work))
    } else {
        instructions.dispatch(By(instructions, work))
    }
}

/// Evaluates what `operation` makes of consecutive units of `data`, given the number of the first:
/// all at once, or in pieces on the threads of the pool, as `share` says. A unit has `len` numbers
/// and takes about `work` multiplications.
#[inline(always)]
pub(crate) fn in_pieces<'a, S: Simd, O: WithSimd<Output = ()>>(
    simd: S,
    share: impl Share,
    data: &'a mut [f64],
    len: usize,
    work: usize,
    operation: impl Fn(usize, &'a mut [f64]) -> O + Sync,
) {
    let units = MIN_PIECE.div_ceil(work.max(1));
    match share.instructions() {
        Some(instructions) if data.len() > units * len => {
            let pieces = data.par_chunks_mut(units * len).enumerate();
            pieces.for_each(|(k, piece)| instructions.dispatch(operation(k * units, piece)));
        }
        _ => operation(0, data).with_simd(simd),
    }
}
