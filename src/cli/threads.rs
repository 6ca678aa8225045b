//! Threads of a command.

use std::num::NonZero;
use std::thread::available_parallelism;

use rayon::ThreadPoolBuilder;

use super::exit::{Exit, Failure};

/// Stack size of the thread, bytes: that of a main thread. The default of other threads is smaller.
const STACK: usize = 8 << 20;

/// Runs a command with this number of threads, and with no more than the number of cores. One
/// thread runs the command. The others help with parallel parts of the solver.
pub(crate) fn on_threads(
    threads: Option<u32>,
    command: impl FnOnce() -> Result<Exit, Failure> + Send,
) -> Result<Exit, Failure> {
    let cores = available_parallelism().map_or(1, NonZero::get);
    let threads = threads.map_or(cores, |threads| cores.min(threads as usize));
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
    let pool = pool.map_err(|error| {
        Failure::new(Exit::Files, format_args!("cannot start {threads} threads: {error}"))
    })?;
    pool.install(command)
}
