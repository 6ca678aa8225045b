//! A run of a sweep as a process: what is to be done for it, and its start.

use std::ffi::OsString;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::Sweep;
use crate::cli::exit::{Exit, Failure};
use crate::output::directory::{self, lock, open_lock};
use crate::study::plan::state_at;
use crate::study::planned::{PlannedRun, Start};

/// Number of increments between two checkpoints of a run.
const CHECKPOINT_EVERY: &str = "20";

/// A run of a plan, by its index among the preparations or the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    Prepare(usize),
    Run(usize),
}

/// Result of an attempt to begin a task.
pub(crate) enum Begun {
    /// The run is there already.
    Done,
    /// Another process makes it.
    Busy,
    /// It cannot begin, and why.
    Impossible(String),
    /// It runs. The file is its lock.
    Runs(Child, File),
}

/// How the run in a directory ended, as `run.json` has it.
fn status(directory: &Path) -> String {
    let record = directory::record(directory).unwrap_or_default();
    record["outcome"]["status"].as_str().unwrap_or_default().to_owned()
}

impl Sweep {
    pub fn planned(&self, task: Task) -> &PlannedRun {
        match task {
            Task::Prepare(k) => &self.plan.preparations[k],
            Task::Run(k) => &self.plan.runs[k],
        }
    }

    pub fn directory(&self, task: Task) -> PathBuf {
        self.folder.join(&self.planned(task).directory)
    }

    /// A run in one line.
    pub fn label(&self, task: Task) -> String {
        let label = self.planned(task).label(&self.plan.names);
        match task {
            Task::Prepare(_) if label.is_empty() => "preparation".to_owned(),
            Task::Prepare(_) => format!("preparation, {label}"),
            Task::Run(_) => label,
        }
    }

    /// Path of a state that a preparation has left, from the directory of the scene that starts
    /// from it.
    fn state(&self, start: &Start, scene: &Path) -> PathBuf {
        let state = self.directory(Task::Prepare(start.preparation)).join(&start.file);
        let from = scene.parent().unwrap_or(Path::new(""));
        let from = if from.as_os_str().is_empty() { Path::new(".") } else { from };
        match (from.canonicalize(), state.canonicalize()) {
            (Ok(from), Ok(state)) => relative(&from, &state),
            // The directory of a shipped scene exists in no file system.
            (_, absolute) => absolute.unwrap_or(state),
        }
    }

    /// Begins a run, unless it is there, or another process makes it. The preparation that it needs
    /// must have ended.
    pub fn begin(&self, task: Task, program: &[OsString]) -> Result<Begun, Failure> {
        let planned = self.planned(task);
        let directory = self.directory(task);
        let guard = open_lock(&self.folder.join(format!("{}.lock", planned.directory)))?;
        let history = || File::open(directory.join(directory::HISTORY));
        if !lock(&guard) || history().is_ok_and(|history| !lock(&history)) {
            return Ok(Begun::Busy);
        }
        // The same run would end in the same way.
        if ["completed", "collapsed", "undecided", "refused"].contains(&&*status(&directory)) {
            return Ok(Begun::Done);
        }
        let mut command = Command::new(&program[0]);
        command.args(&program[1..]);
        if directory.join(directory::CHECKPOINT).exists() {
            command.arg("resume").arg(&directory);
        } else {
            command.arg("run").arg(scene(&planned.scene));
            command.args(["--force", "--out"]).arg(&directory);
            for set in &planned.sets {
                command.arg("--set").arg(set);
            }
            if let Some(start) = &planned.start {
                let preparation = Task::Prepare(start.preparation);
                let (what, from) = (self.label(preparation), self.directory(preparation));
                if !["completed", "collapsed"].contains(&&*status(&from)) {
                    return Ok(Begun::Impossible(format!("{what} was not completed")));
                }
                if !from.join(&start.file).exists() {
                    let message = format!("{what} has left no `{}`", start.file);
                    return Ok(Begun::Impossible(message));
                }
                command.arg("--set").arg(state_at(&self.state(start, &planned.scene)));
            }
        }
        command
            .args(["--quiet", "--threads", "1", "--checkpoint-every", CHECKPOINT_EVERY])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let child = command.spawn().map_err(|error| {
            Failure::new(Exit::Files, format_args!("cannot begin a run: {error}"))
        })?;
        Ok(Begun::Runs(child, guard))
    }
}

/// The scene as an argument: a shipped scene by its name.
fn scene(path: &Path) -> PathBuf {
    if path.exists() { path.to_owned() } else { path.file_stem().unwrap_or_default().into() }
}

/// Path that leads from a directory to a file, if both are absolute. It stays the same where a
/// folder that holds both is moved, and so do the settings of a run.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|_| Path::new(".."));
    let down = to.components().skip(common).map(|part| Path::new(part.as_os_str()));
    up.chain(down).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_leads_from_a_directory_to_a_file() {
        let path = |from: &str, to: &str| relative(Path::new(from), Path::new(to));
        assert_eq!(path("/a/b", "/a/runs/x.npz"), Path::new("../runs/x.npz"));
        assert_eq!(path("/a", "/a/x.npz"), Path::new("x.npz"));
        assert_eq!(path("/", "/x.npz"), Path::new("x.npz"));
    }
}
