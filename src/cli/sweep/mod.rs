//! `clastic sweep`: makes the runs of a study, several at once, and collects their results.

mod collect;
mod jobs;
mod show;
mod slurm;
mod task;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use bevy_app::App;

use crate::output::OutputError;
use crate::output::directory::default_directory;
use crate::scene::format::Scene;
use crate::scene::{LoadedScene, load_with};
use crate::study::{Plan, Study, StudyError, Wanted, plan};

use super::SweepArgs;
use super::exit::{Exit, Failure, say};
use super::own_findings::own_findings;
use super::resolve::resolve;

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        Self::new(Exit::Scene, error)
    }
}

/// A study whose runs are known and sound.
pub(crate) struct Sweep {
    pub study: Study,
    pub plan: Plan,
    /// Directory of the runs and of the table.
    pub folder: PathBuf,
}

pub fn sweep(args: &SweepArgs, words: &[OsString], app: &App) -> Result<Exit, Failure> {
    let sweep = read(&args.study, args.out.as_deref(), app)?;
    if args.emit.is_some() {
        say(slurm::job_array(&args.study, &sweep, args.out.as_deref()))?;
        return Ok(Exit::Ok);
    }
    if let Some(n) = args.only.filter(|n| *n as usize > sweep.plan.runs.len()) {
        let message = format!("--only {n}: the study has {} runs", sweep.plan.runs.len());
        return Err(Failure::new(Exit::Usage, message));
    }
    fs::create_dir_all(&sweep.folder).map_err(OutputError::at(&sweep.folder))?;
    let wanted: Vec<usize> = match args.only {
        Some(n) => vec![n as usize - 1],
        None => (0..sweep.plan.runs.len()).collect(),
    };
    let interrupted =
        !args.collect && jobs::run_all(&sweep, words, &wanted, args.jobs, args.quiet)?;
    let exit = collect::collect(&sweep)?;
    Ok(if interrupted { Exit::Interrupted } else { exit })
}

/// Reads a study and checks each of its runs.
fn read(file: &Path, out: Option<&Path>, app: &App) -> Result<Sweep, Failure> {
    let text = fs::read_to_string(file).map_err(|error| {
        let file = file.display();
        Failure::new(Exit::Files, format_args!("{file}: cannot read the study: {error}"))
    })?;
    let study = Study::read(&text, file)?;
    let plan = plan(&study, file, &|wanted| load(wanted, file, app))?;
    let folder = out.map_or_else(|| default_directory(file), Path::to_owned);
    Ok(Sweep { study, plan, folder })
}

/// Reads a scene of a study: a file beside that of the study, or a scene that has a name.
fn load(wanted: Wanted<'_>, study: &Path, app: &App) -> Result<LoadedScene, String> {
    let beside = study.parent().unwrap_or(Path::new("")).join(wanted.scene);
    let resolved = if beside.is_file() { Ok(beside) } else { resolve(wanted.scene) };
    let path = resolved.map_err(|failure| failure.message)?;
    let further = |scene: &Scene| own_findings(scene, app);
    let loaded = load_with(&path, wanted.sets, !wanted.is_unprepared, further);
    loaded.map_err(|error| error.to_string())
}
