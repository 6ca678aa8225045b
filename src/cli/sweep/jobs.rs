//! The runs of a sweep as processes, several at once.
//!
//! A run belongs to the process that holds the lock of its directory, `NAME.lock` beside it. A
//! sweep that was killed leaves its runs behind, which hold the lock of their history; a run with
//! either lock is left alone until it is free. Two sweeps in one folder therefore share the runs.

use std::env;
use std::fs::{self, File, OpenOptions};
use std::io::{IsTerminal, Read};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::output::OutputError;
use crate::output::directory::{self, lock};
use indicatif::{ProgressBar, ProgressStyle};

use super::Sweep;
use crate::cli::exit::{Exit, Failure, complain};
use crate::cli::interrupt::Interrupt;

/// Number of increments between two checkpoints of a run.
const CHECKPOINT_EVERY: &str = "20";

/// Time between two looks at the processes.
const PAUSE: Duration = Duration::from_millis(50);

/// What is to be done for a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Todo {
    /// It is done.
    Nothing,
    /// It begins.
    Begin,
    /// It continues from its checkpoint.
    Resume,
    /// Another process runs it.
    Wait,
}

/// What is to be done for the run in a directory.
fn todo(directory: &Path) -> Todo {
    let history = directory.join(directory::HISTORY);
    if File::open(history).is_ok_and(|history| !lock(&history)) {
        return Todo::Wait;
    }
    let record = directory::record(directory).unwrap_or_default();
    match record["outcome"]["status"].as_str() {
        // The same run would end in the same way.
        Some("completed" | "collapsed" | "undecided" | "refused") => Todo::Nothing,
        _ if directory.join(directory::CHECKPOINT).exists() => Todo::Resume,
        _ => Todo::Begin,
    }
}

/// A run under way.
struct Running {
    run: usize,
    child: Child,
    /// Held until the process has ended.
    _lock: File,
}

/// Makes the runs `wanted`, at most `jobs` at once. Returns whether it was interrupted. The runs
/// under way then write a checkpoint, from which the next sweep continues.
pub fn run_all(
    sweep: &Sweep,
    wanted: Vec<usize>,
    jobs: Option<u32>,
    quiet: bool,
) -> Result<bool, Failure> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let jobs = jobs.map_or(cores, |jobs| jobs as usize);
    let program = env::current_exe()
        .map_err(|error| files(format!("cannot find the program itself: {error}")))?;
    let interrupt = Interrupt::listen();
    let mut show = Show::new(quiet, wanted.len());
    let mut waiting = wanted;
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
        let mut later = Vec::new();
        for run in waiting.drain(..) {
            if interrupted || running.len() >= jobs {
                later.push(run);
                continue;
            }
            match begin(sweep, run, &program)? {
                Begun::Done => show.done(sweep, run, None),
                Begun::Busy => later.push(run),
                Begun::Runs(child, lock) => running.push(Running { run, child, _lock: lock }),
            }
        }
        waiting = later;
        let mut still = Vec::new();
        for mut process in running {
            match process.child.try_wait() {
                Ok(None) => still.push(process),
                Ok(Some(status)) if status.code() == Some(Exit::Interrupted as i32) => {}
                Ok(Some(status)) => {
                    let mut said = String::new();
                    if let Some(mut stderr) = process.child.stderr.take() {
                        let _ = stderr.read_to_string(&mut said);
                    }
                    show.done(sweep, process.run, (!status.success()).then_some(said));
                }
                Err(error) => return Err(files(format!("cannot wait for a run: {error}"))),
            }
        }
        running = still;
        show.state(sweep, &running);
        thread::sleep(PAUSE);
    }
    show.end();
    Ok(interrupt.requested())
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

enum Begun {
    /// The run is there already.
    Done,
    /// Another process makes it.
    Busy,
    /// It runs.
    Runs(Child, File),
}

fn begin(sweep: &Sweep, run: usize, program: &Path) -> Result<Begun, Failure> {
    let planned = &sweep.plan.runs[run];
    let directory = sweep.folder.join(&planned.directory);
    let path = sweep.folder.join(format!("{}.lock", planned.directory));
    let guard = OpenOptions::new()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path)
        .map_err(OutputError::at(&path))?;
    if !lock(&guard) {
        return Ok(Begun::Busy);
    }
    let mut command = Command::new(program);
    match todo(&directory) {
        Todo::Nothing => return Ok(Begun::Done),
        Todo::Wait => return Ok(Begun::Busy),
        Todo::Resume => {
            command.arg("resume").arg(&directory);
        }
        Todo::Begin => {
            command.arg("run").arg(scene(&sweep.scene)).args(["--force", "--out"]).arg(&directory);
            for set in &planned.sets {
                command.arg("--set").arg(set);
            }
        }
    }
    command
        .args(["--quiet", "--threads", "1", "--checkpoint-every", CHECKPOINT_EVERY])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let child = command.spawn().map_err(|error| files(format!("cannot begin a run: {error}")))?;
    Ok(Begun::Runs(child, guard))
}

/// The scene as an argument: a shipped scene by its name.
fn scene(path: &Path) -> PathBuf {
    if path.exists() { path.to_owned() } else { path.file_stem().unwrap_or_default().into() }
}

fn files(message: String) -> Failure {
    Failure { exit: Exit::Files, message }
}

/// Progress of a sweep: a bar on a terminal, a line per run otherwise.
struct Show {
    bar: Option<ProgressBar>,
    quiet: bool,
    done: usize,
    total: usize,
}

impl Show {
    fn new(quiet: bool, total: usize) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(total as u64);
            if let Ok(style) =
                ProgressStyle::with_template("[{bar:24}] {pos}/{len} runs, {elapsed}{msg}")
            {
                bar.set_style(style.progress_chars("=> "));
            }
            bar
        });
        Self { bar, quiet, done: 0, total }
    }

    /// Shows the end of a run; `failed` is what it said if it failed.
    fn done(&mut self, sweep: &Sweep, run: usize, failed: Option<String>) {
        self.done += 1;
        let planned = &sweep.plan.runs[run];
        let label = planned.label(&sweep.plan.names);
        let line = match &failed {
            Some(said) => format!("{label}: failed: {}", said.trim()),
            None => format!("{label}: done"),
        };
        match &self.bar {
            Some(bar) => {
                bar.set_position(self.done as u64);
                if failed.is_some() {
                    bar.suspend(|| complain(&line));
                }
            }
            None if !self.quiet || failed.is_some() => {
                complain(format_args!("{}/{} {line}", self.done, self.total));
            }
            None => {}
        }
    }

    /// Shows the last row of each run under way.
    fn state(&self, sweep: &Sweep, running: &[Running]) {
        let Some(bar) = &self.bar else { return };
        let lines = running.iter().map(|process| {
            let planned = &sweep.plan.runs[process.run];
            let rows = rows(&sweep.folder.join(&planned.directory));
            format!("\n  {}: {rows} increments", planned.label(&sweep.plan.names))
        });
        bar.set_message(lines.collect::<String>());
        bar.tick();
    }

    fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Number of rows of the history so far.
fn rows(directory: &Path) -> usize {
    let history = fs::read(directory.join(directory::HISTORY)).unwrap_or_default();
    history.iter().filter(|byte| **byte == b'\n').count().saturating_sub(1)
}
