//! `clastic sweep`: makes the runs of a study, several at once, and collects their results.

pub mod collect;
pub mod jobs;
mod slurm;

use std::fs;
use std::path::{Path, PathBuf};

use clastic::output::OutputError;
use clastic::output::directory::default_directory;
use clastic::scene::load_with;
use clastic::study::{Plan, Study, StudyError, plan};

use super::SweepArgs;
use super::exit::{Exit, Failure, say};
use super::own_findings::own_findings;
use super::resolve::resolve;

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        Self { exit: Exit::Scene, message: error.to_string() }
    }
}

/// A study whose runs are known and sound.
pub struct Sweep {
    /// Path of the scene.
    pub scene: PathBuf,
    /// Title of the study.
    pub title: String,
    /// The runs.
    pub plan: Plan,
    /// Directory of the runs and of the table.
    pub folder: PathBuf,
}

/// Makes the runs of a study.
pub fn sweep(args: &SweepArgs) -> Result<Exit, Failure> {
    let sweep = read(&args.study, args.out.as_deref())?;
    if args.emit.is_some() {
        say(slurm::job_array(&args.study, &sweep, args.out.as_deref()))?;
        return Ok(Exit::Ok);
    }
    if let Some(n) = args.only.filter(|n| *n as usize > sweep.plan.runs.len()) {
        let message = format!("--only {n}: the study has {} runs", sweep.plan.runs.len());
        return Err(Failure { exit: Exit::Usage, message });
    }
    fs::create_dir_all(&sweep.folder).map_err(OutputError::at(&sweep.folder))?;
    let wanted: Vec<usize> = match args.only {
        Some(n) => vec![n as usize - 1],
        None => (0..sweep.plan.runs.len()).collect(),
    };
    let interrupted =
        if args.collect { false } else { jobs::run_all(&sweep, wanted, args.jobs, args.quiet)? };
    let exit = collect::collect(&sweep)?;
    Ok(if interrupted { Exit::Interrupted } else { exit })
}

/// Reads a study and checks each of its runs.
fn read(file: &Path, out: Option<&Path>) -> Result<Sweep, Failure> {
    let text = fs::read_to_string(file).map_err(|error| Failure {
        exit: Exit::Files,
        message: format!("{}: cannot read the study: {error}", file.display()),
    })?;
    let study = Study::read(&text, file)?;
    let beside = file.parent().unwrap_or(Path::new("")).join(&study.scene);
    let scene = if beside.is_file() { beside } else { resolve(&study.scene)? };
    let plan = plan(&study, file, |sets| load_with(&scene, sets, own_findings))?;
    let folder = out.map_or_else(|| default_directory(file), Path::to_owned);
    Ok(Sweep { scene, title: study.title, plan, folder })
}
