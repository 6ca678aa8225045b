//! The runs of a sweep as processes, several at once.
//!
//! A run belongs to the process that holds the lock of its directory, `NAME.lock` beside it. Runs
//! of a killed sweep continue and hold the lock of their history. A run with either lock is left
//! alone until it is free, so that two sweeps in one folder share the runs.

use std::collections::BTreeSet;
use std::env;
use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::mem::take;
use std::num::NonZero;
use std::process::Child;
use std::thread;
use std::time::Duration;

use super::Sweep;
use super::show::Show;
use super::task::{Begun, Task};
use crate::cli::exit::{Exit, Failure};
use crate::cli::interrupt::Interrupt;

/// Time between two checks of the processes.
const PAUSE: Duration = Duration::from_millis(50);

struct Running {
    task: Task,
    child: Child,
    /// Held until the process has ended.
    _lock: File,
}

/// Makes the runs `wanted` and the preparations that they need, at most `jobs` at once, in processes
/// that `words` begin, or this executable where there are none. Returns whether it was interrupted.
/// The runs under way then write a checkpoint, from which the next sweep continues.
pub(crate) fn run_all(
    sweep: &Sweep,
    words: &[OsString],
    wanted: &[usize],
    jobs: Option<u32>,
    quiet: bool,
) -> Result<bool, Failure> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let jobs = jobs.map_or(cores, |jobs| jobs as usize);
    let program = match words {
        [] => {
            let itself = env::current_exe().map_err(|error| {
                Failure::new(Exit::Files, format_args!("cannot find the program itself: {error}"))
            })?;
            vec![itself.into_os_string()]
        }
        words => words.to_vec(),
    };
    let interrupt = Interrupt::listen();
    let mut waiting = tasks(sweep, wanted);
    let mut show = Show::new(quiet, waiting.len());
    let mut running: Vec<Running> = Vec::new();
    let mut asked = false;
    while !(waiting.is_empty() && running.is_empty()) {
        let interrupted = interrupt.requested();
        if interrupted && running.is_empty() {
            break;
        }
        if interrupted && !asked {
            // Ctrl-C reaches the runs by itself; SIGTERM may reach this process only.
            running.iter().for_each(|process| ask_to_stop(&process.child));
            asked = true;
        }
        let under_way = running.iter().map(|process| &process.task);
        let pending: Vec<Task> = under_way.chain(&waiting).copied().collect();
        for task in take(&mut waiting) {
            let start = sweep.planned(task).start.as_ref();
            let waits = start.is_some_and(|s| pending.contains(&Task::Prepare(s.preparation)));
            if interrupted || waits || running.len() >= jobs {
                waiting.push(task);
                continue;
            }
            match sweep.begin(task, &program)? {
                Begun::Done => show.done(sweep, task, None),
                Begun::Busy => waiting.push(task),
                Begun::Impossible(why) => show.done(sweep, task, Some(why)),
                Begun::Runs(child, lock) => running.push(Running { task, child, _lock: lock }),
            }
        }
        for mut process in take(&mut running) {
            match process.child.try_wait() {
                Ok(None) => running.push(process),
                Ok(Some(status)) if status.code() == Some(Exit::Interrupted as i32) => {}
                Ok(Some(status)) => {
                    let mut said = String::new();
                    if let Some(mut stderr) = process.child.stderr.take() {
                        let _ = stderr.read_to_string(&mut said);
                    }
                    show.done(sweep, process.task, (!status.success()).then_some(said));
                }
                Err(error) => {
                    let message = format_args!("cannot wait for a run: {error}");
                    return Err(Failure::new(Exit::Files, message));
                }
            }
        }
        show.state(sweep, running.iter().map(|process| process.task));
        thread::sleep(PAUSE);
    }
    show.end();
    Ok(interrupt.requested())
}

/// The runs, after the preparations that they need.
fn tasks(sweep: &Sweep, wanted: &[usize]) -> Vec<Task> {
    let starts = wanted.iter().filter_map(|run| sweep.plan.runs[*run].start.as_ref());
    let preparations: BTreeSet<_> = starts.map(|start| start.preparation).collect();
    let runs = wanted.iter().copied().map(Task::Run);
    preparations.into_iter().map(Task::Prepare).chain(runs).collect()
}

/// Asks a run to write a checkpoint and to stop.
fn ask_to_stop(child: &Child) {
    #[cfg(unix)]
    if let Some(id) = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw) {
        // A run that has ended meanwhile needs no signal.
        let _ = rustix::process::kill_process(id, rustix::process::Signal::TERM);
    }
    #[cfg(not(unix))]
    let _ = child;
}
