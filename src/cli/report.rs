//! `clastic report`: one or several runs, or those of a study, as a page for a browser.

use std::fs;
use std::path::{Path, PathBuf};

use crate::output::{OutputError, directory, report};

use crate::study::table;

use super::compare::names;
use super::exit::{Exit, Failure, say};

/// Default page of several runs.
const OF_SEVERAL: &str = "runs/report.html";

/// Writes the page of runs.
pub fn report(directories: &[PathBuf], out: Option<PathBuf>) -> Result<Exit, Failure> {
    let out = out.unwrap_or_else(|| match directories {
        [one] => one.join(directory::REPORT),
        _ => PathBuf::from(OF_SEVERAL),
    });
    let mut runs = Vec::new();
    for (name, directory) in names(directories).into_iter().zip(directories) {
        runs.extend(runs_of(name, directory)?);
    }
    if let (true, [first, ..]) = (runs.is_empty(), directories) {
        return Err(OutputError::NoRun(first.clone()).into());
    }
    if let Some(folder) = out.parent().filter(|folder| *folder != Path::new("")) {
        fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
    }
    report::write(&runs, &out)?;
    say(format_args!("written: {}", out.display()))?;
    Ok(Exit::Ok)
}

/// The run in a directory, or all runs of the study there, by their values.
fn runs_of(name: String, directory: &Path) -> Result<Vec<(String, PathBuf)>, OutputError> {
    let study = directory.join(table::FILE);
    if !study.exists() {
        return Ok(vec![(name, directory.to_owned())]);
    }
    let of_study = |(run, label): (String, String)| {
        let name = if label.is_empty() { run.clone() } else { label };
        (name, directory.join(run))
    };
    Ok(table::read(&study)?.into_iter().map(of_study).collect())
}
