//! The threads that a command works on.

use std::num::NonZero;
use std::thread::available_parallelism;

use rayon::ThreadPoolBuilder;

use super::exit::{Exit, Failure};

/// Of a main thread; less is usual for others.
const STACK: usize = 8 << 20;

/// Runs a command on so many threads, and on no more than there are cores. It is one thread that runs
/// it: where the solver has work for several, the others help.
pub fn on_threads(
    threads: Option<u32>,
    command: impl FnOnce() -> Result<Exit, Failure> + Send,
) -> Result<Exit, Failure> {
    let cores = available_parallelism().map_or(1, NonZero::get);
    let threads = threads.map_or(cores, |threads| cores.min(threads as usize));
    match ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build() {
        Ok(pool) => pool.install(command),
        Err(error) => {
            let message = format!("cannot start {threads} threads: {error}");
            Err(Failure { exit: Exit::Files, message })
        }
    }
}
