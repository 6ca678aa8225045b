//! `clastic report`: one or several runs as a page for a browser.

use std::fs;
use std::path::{Path, PathBuf};

use crate::output::{OutputError, directory, report};

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
    let runs: Vec<_> = names(directories).into_iter().zip(directories.iter().cloned()).collect();
    if let Some(folder) = out.parent().filter(|folder| *folder != Path::new("")) {
        fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
    }
    report::write(&runs, &out)?;
    say(format_args!("written: {}", out.display()))?;
    Ok(Exit::Ok)
}
